"""Approximate inverse of the influence matrix, which makes conjugate gradients short."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ._grid import Grid


def stiffness_symbol(grid: Grid) -> Float[Array, "kx ky"]:
    """Pressure that makes a wave of unit displacement on a half-space, |k|/2, for E* = 1 [1/m].

    Without the influence of the grid's rim and periodic, so on a grid that is not doubled: cheap,
    and near enough to the inverse that the number of steps hardly grows with that of the cells.
    Waves longer than the grid count as twice its length.

    **Arguments:**

    - `grid`: the grid.
    """
    dtype = grid.spacing_x.dtype
    waves_x = jnp.fft.fftfreq(grid.shape[0], dtype=dtype) / grid.spacing_x
    waves_y = jnp.fft.rfftfreq(grid.shape[1], dtype=dtype) / grid.spacing_y
    waves = jnp.hypot(waves_x[:, None], waves_y[None, :])
    return jnp.pi * waves.at[0, 0].set(jnp.minimum(waves_x[1], waves_y[1]) / 2)


def apply_symbol(
    symbol: Float[Array, "kx ky"], field: Float[Array, "nx ny"]
) -> Float[Array, "nx ny"]:
    """The field with each of its waves multiplied."""
    waves = jnp.fft.rfft2(field)
    return jnp.fft.irfft2(waves * symbol.astype(waves.dtype), s=field.shape)
