"""Influence of loaded rectangles on all others: discrete convolution by FFT, not periodic.

The influence of a uniformly loaded rectangle is the second difference of an antiderivative over its
four corners. On a grid all rectangles share their corners, so one array of corner values holds the
whole influence matrix. The grid is doubled for the transform to avoid wrap-around (Liu, Wang and
Liu 2000): the convolution is exact to rounding.
"""

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array, Float, Inexact

from ._grid import Grid

#: Function of two coordinates relative to a corner [m], broadcast against each other.
Antiderivative = Callable[[Float[Array, "cx 1"], Float[Array, "1 cy"]], Array]


def _fast_length(least: int) -> int:
    """The smallest even product of 2, 3 and 5 that is at least `least`."""
    length = least + least % 2
    while True:
        remainder = length
        for factor in (2, 3, 5):
            while remainder % factor == 0:
                remainder //= factor
        if remainder == 1:
            return length
        length += 2


def _padded(shape: tuple[int, ...]) -> tuple[int, int]:
    return _fast_length(2 * shape[0] - 1), _fast_length(2 * shape[1] - 1)


def influence(antiderivative: Antiderivative, grid: Grid) -> Inexact[Array, "ky kx"]:
    """Transform of the influence of one loaded cell on all offsets of the grid.

    **Arguments:**

    - `antiderivative`: F(X, Y) with ∂²F/∂X∂Y the influence of a point load; X and Y are never 0.
    - `grid`: the grid.
    """

    def corners(length: int, spacing) -> Float[Array, "corners"]:
        return (jnp.arange(length + 1, dtype=spacing.dtype) - (length // 2 + 0.5)) * spacing

    lengths = _padded(grid.shape)
    x, y = corners(lengths[0], grid.spacing_x), corners(lengths[1], grid.spacing_y)
    values = antiderivative(x[:, None], y[None, :])
    kernel = jnp.diff(jnp.diff(values, axis=0), axis=1)
    return jnp.fft.rfft2(jnp.fft.ifftshift(kernel)).T


def spectrum(field: Float[Array, "nx ny"]) -> Inexact[Array, "ky kx"]:
    """Transform of a field on the doubled grid, x last; rows that hold only zeros are left out."""
    lengths = _padded(field.shape)
    rows = jnp.fft.rfft(field, n=lengths[1], axis=1)
    return jnp.fft.fft(rows.T, n=lengths[0], axis=1)


def field_of(transform: Inexact[Array, "ky kx"], shape: tuple[int, ...]) -> Float[Array, "nx ny"]:
    """Field on the cells of the grid from its transform on the doubled grid."""
    rows = jnp.fft.ifft(transform, axis=1)[:, : shape[0]].T
    return jnp.fft.irfft(rows, n=_padded(shape)[1], axis=1)[:, : shape[1]]


def convolve(
    transform: Inexact[Array, "ky kx"], field: Float[Array, "nx ny"]
) -> Float[Array, "nx ny"]:
    """Effect of a load field, by the transform of `influence`."""
    load_spectrum = spectrum(field)
    return field_of(load_spectrum * transform.astype(load_spectrum.dtype), field.shape)
