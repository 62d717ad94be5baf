"""Grid of equal rectangles for the pressures and gaps of a half-space contact."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar, as_scalar


def _centred(count: int, spacing: Scalar) -> Float[Array, "n"]:
    return (jnp.arange(count, dtype=spacing.dtype) - (count - 1) / 2) * spacing


class Grid(eqx.Module):
    """Equal rectangular cells in the contact plane, centred on the origin.

    The number of cells is static; the spacings are traced and differentiable. Fields are arrays
    `[x, y]` of values at the cells' centres.
    """

    #: Number of cells along x and y.
    shape: tuple[int, int] = eqx.field(static=True)
    #: Length of a cell along x [m].
    spacing_x: Scalar = eqx.field(converter=as_scalar)
    #: Length of a cell along y [m].
    spacing_y: Scalar = eqx.field(converter=as_scalar)

    def __check_init__(self) -> None:
        if len(self.shape) != 2 or min(self.shape) < 4:
            raise ValueError(
                f"the grid's shape is {self.shape!r}; give two numbers of cells, at least 4 each"
            )

    @property
    def x(self) -> Float[Array, "nx"]:
        """Centres of the cells along x [m]."""
        return _centred(self.shape[0], self.spacing_x)

    @property
    def y(self) -> Float[Array, "ny"]:
        """Centres of the cells along y [m]."""
        return _centred(self.shape[1], self.spacing_y)

    @property
    def points(self) -> tuple[Float[Array, "nx ny"], Float[Array, "nx ny"]]:
        """Coordinates x and y of all cells' centres [m]."""
        x, y = jnp.meshgrid(self.x, self.y, indexing="ij")
        return x, y

    @property
    def cell_area(self) -> Scalar:
        """Area of one cell [m²]."""
        return self.spacing_x * self.spacing_y


def grid_over(shape: tuple[int, int], half_length: Scalar, half_width: Scalar) -> Grid:
    """Grid of `shape` cells that covers ±`half_length` by ±`half_width`.

    **Arguments:**

    - `shape`: number of cells along x and y.
    - `half_length`, `half_width`: half the extent along x and y [m].

    **Raises:** `ValueError` for a shape that is not two numbers of at least 4.
    """
    return Grid(shape, 2 * half_length / shape[0], 2 * half_width / shape[1])
