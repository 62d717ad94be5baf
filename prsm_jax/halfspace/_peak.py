"""Largest pressure, interpolated between the cells' centres and differentiable."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..fields import Scalar


def peak_pressure(
    pressure: Float[Array, "nx ny"], material: Bool[Array, "nx ny"] | None = None
) -> Scalar:
    """Largest pressure: the vertex of a paraboloid through p² at the largest cell's neighbours.

    p² is a paraboloid in every Hertz contact, so this is exact there up to the error of the
    pressures, wherever the maximum lies between the centres. Where the paraboloid has no vertex
    within one cell (the rim of the grid, a single cell), or where a neighbour has no material (the
    pressure of a sharp edge ends in a step), the result is the value of the largest cell. The
    derivative is that of the vertex's height, with the largest cell fixed.

    **Arguments:**

    - `pressure`: uniform on every cell; not negative [Pa].
    - `material`: cells with material on both sides. Default: all cells.
    """
    nx, ny = pressure.shape
    flat = jnp.argmax(jax.lax.stop_gradient(pressure))
    row = jnp.clip(flat // ny, 1, nx - 2)
    column = jnp.clip(flat % ny, 1, ny - 2)
    patch = jax.lax.dynamic_slice(pressure, (row - 1, column - 1), (3, 3))
    top = jnp.max(jax.lax.stop_gradient(pressure))
    loaded = top > 0
    square = (patch / jnp.where(loaded, top, 1.0)) ** 2
    centre = square[1, 1]
    slope_x, slope_y = (square[2, 1] - square[0, 1]) / 2, (square[1, 2] - square[1, 0]) / 2
    bend_x = square[2, 1] - 2 * centre + square[0, 1]
    bend_y = square[1, 2] - 2 * centre + square[1, 0]
    twist = (square[2, 2] - square[2, 0] - square[0, 2] + square[0, 0]) / 4
    determinant = bend_x * bend_y - twist**2
    concave = (bend_x < 0) & (determinant > 0)
    safe = jnp.where(concave, determinant, 1.0)
    shift_x = (twist * slope_y - bend_y * slope_x) / safe
    shift_y = (twist * slope_x - bend_x * slope_y) / safe
    if material is not None:
        concave &= jnp.all(jax.lax.dynamic_slice(material, (row - 1, column - 1), (3, 3)))
    near = concave & (jnp.maximum(jnp.abs(shift_x), jnp.abs(shift_y)) <= 1)
    vertex = centre + jnp.where(near, (slope_x * shift_x + slope_y * shift_y) / 2, 0.0)
    # The largest cell may lie on the rim of the grid, where it is not the patch's centre.
    rim = centre < jnp.max(jax.lax.stop_gradient(square))
    height = jnp.sqrt(jnp.where(loaded & ~rim, vertex, 1.0))
    return jnp.where(rim | ~loaded, jnp.max(pressure), top * height)
