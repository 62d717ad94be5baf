"""Normal displacement of an elastic half-space under pressure on a grid (Love 1929)."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar
from ._convolution import convolve, influence
from ._grid import Grid


def _newtonian(x: Float[Array, "cx 1"], y: Float[Array, "1 cy"]) -> Array:
    """∬ dx dy/√(x² + y²) = x asinh(y/|x|) + y asinh(x/|y|)."""
    return x * jnp.arcsinh(y / jnp.abs(x)) + y * jnp.arcsinh(x / jnp.abs(y))


def normal_influence(grid: Grid) -> Float[Array, "ky kx"]:
    """Transform of the normal displacement by unit pressure on one cell, for E* = 1.

    Even in both directions, so the transform is real and the influence matrix symmetric.

    **Arguments:**

    - `grid`: the grid.
    """
    return influence(_newtonian, grid).real / jnp.pi


def normal_displacement(
    grid: Grid, pressure: Float[Array, "nx ny"], modulus: Scalar
) -> Float[Array, "nx ny"]:
    """Sum of both bodies' normal displacements at the cells' centres, u = K p [m].

    Closed form of a uniformly loaded rectangle (Love 1929; Johnson 1985, equation 3.25), summed
    over all cells.

    **Arguments:**

    - `grid`: the grid.
    - `pressure`: uniform on every cell [Pa].
    - `modulus`: contact modulus E* [Pa].
    """
    return convolve(normal_influence(grid), pressure) / modulus
