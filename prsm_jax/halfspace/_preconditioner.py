"""Approximate inverse of the influence matrix, which saves steps of conjugate gradients."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ._grid import Grid


def stiffness_symbol(grid: Grid) -> Float[Array, "kx ky"]:
    """Pressure amplitude of a wave of unit displacement on a half-space, |k|/2, for E* = 1 [1/m].

    Periodic and without edge effects, so on a grid that is not doubled: cheap, and so close to the
    inverse that the number of steps hardly grows with the number of cells. Waves longer than the
    grid are treated as waves of twice its length.

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
    """The field with each of its waves multiplied by the symbol."""
    waves = jnp.fft.rfft2(field)
    return jnp.fft.irfft2(waves * symbol.astype(waves.dtype), s=field.shape)
