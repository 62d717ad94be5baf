"""Stress tensor below a contact on a grid, by influence functions."""

import functools
import operator
from typing import Annotated

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..contact import von_mises_stress
from ..fields import In, Scalar
from ..programs import mapped, physics
from ..results import DesignResult, lines_of
from ..text import Line
from ._convolution import field_of, influence, spectrum
from ._grid import Grid
from ._rectangle_stress import pressure_stress, shear_stress

#: Index of the component at each place of the tensor.
_FULL = ((0, 3, 5), (3, 1, 4), (5, 4, 2))


class SubsurfaceStress(DesignResult):
    """Stress tensor below the cells' centres at some depths; tension is positive."""

    grid: Grid
    #: [m].
    depths: Annotated[Float[Array, "depths"], In("m")]
    #: Axes x, y of the grid, z into the body [Pa].
    tensor: Float[Array, "depths nx ny 3 3"]

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Batch axes of these stresses; empty for a single design."""
        return self.depths.shape[:-1]

    def lines(self) -> list[Line]:
        """What `print` shows."""
        # The deviatoric part, by NumPy: printing compiles nothing.
        tensor = np.asarray(self.tensor)
        pressure = np.trace(tensor, axis1=-2, axis2=-1)[..., None, None] / 3
        square = np.sum((tensor - pressure * np.eye(3)) ** 2, axis=(-2, -1))
        cells = Line("cells", " × ".join(map(str, self.grid.shape)))
        return [cells, *lines_of(self), Line("von Mises stress", np.sqrt(1.5 * square), "Pa")]

    @property
    @mapped
    def von_mises(self) -> Float[Array, "depths nx ny"]:
        """Reduced stress after von Mises [Pa]."""
        return von_mises_stress(self.tensor)

    @property
    @mapped
    def max_von_mises(self) -> tuple[Scalar, Scalar]:
        """Largest von Mises stress of all points [Pa] and its depth [m].

        Interpolated by a parabola through the maxima at three depths; at the first or last depth
        the value there.
        """
        largest = jnp.max(self.von_mises, axis=(1, 2))
        index = jnp.argmax(largest)
        if len(largest) < 3:
            return largest[index], self.depths[index]
        start = jnp.clip(index - 1, 0, len(largest) - 3)
        z = jax.lax.dynamic_slice(self.depths, (start,), (3,))
        s = jax.lax.dynamic_slice(largest, (start,), (3,))
        # Newton's divided differences.
        first, second = (s[1] - s[0]) / (z[1] - z[0]), (s[2] - s[1]) / (z[2] - z[1])
        bend = (second - first) / (z[2] - z[0])
        inside = (bend < 0) & (start == index - 1)
        safe = jnp.where(inside, bend, -1.0)
        depth = (z[0] + z[1]) / 2 - first / (2 * safe)
        value = s[0] + (depth - z[0]) * (first + safe * (depth - z[1]))
        return (
            jnp.where(inside, value, largest[index]),
            jnp.where(inside, depth, self.depths[index]),
        )


def _swapped(x, y, depth, poisson_ratio):
    """Stresses due to traction along y: those along x with both axes exchanged."""
    xx, yy, zz, xy, yz, zx = shear_stress(y, x, depth, poisson_ratio)
    return yy, xx, zz, xy, zx, yz


@physics("subsurface_influence")
def subsurface_stress_field(
    grid: Grid,
    pressure: Float[Array, "nx ny"],
    depths: Float[Array, "depths"],
    poisson_ratio: Scalar | float,
    *,
    traction_x: Float[Array, "nx ny"] | None = None,
    traction_y: Float[Array, "nx ny"] | None = None,
) -> SubsurfaceStress:
    """Stress below any pressure and traction on a grid, at any depths z ≥ 0.

    Closed-form stresses of uniformly loaded rectangles, convolved by FFT at each depth. Exact for
    cells of constant load; the error of this assumption is largest at the surface.

    **Arguments:**

    - `grid`: the grid.
    - `pressure`: on the cells [Pa].
    - `depths`: below the surface [m].
    - `poisson_ratio`: of the body.
    - `traction_x`, `traction_y`: tangential traction on this body [Pa]; a component that is not
      given is not traced. The traction on the other body is opposite.
    """
    nu = jnp.asarray(poisson_ratio, pressure.dtype)
    loads = [(pressure_stress, spectrum(pressure))]
    if traction_x is not None:
        loads.append((shear_stress, spectrum(traction_x)))
    if traction_y is not None:
        loads.append((_swapped, spectrum(traction_y)))

    def component(index: int, depth: Scalar) -> Float[Array, "nx ny"]:
        parts = (
            influence(lambda x, y, law=law: law(x, y, depth, nu)[index], grid) * waves
            for law, waves in loads
        )
        return field_of(functools.reduce(operator.add, parts), grid.shape)

    def at(depth: Scalar) -> Float[Array, "nx ny 3 3"]:
        six = [component(index, depth) for index in range(6)]
        return jnp.stack([jnp.stack([six[i] for i in row], axis=-1) for row in _FULL], axis=-2)

    return SubsurfaceStress(grid, depths, jax.lax.map(at, depths))
