"""Triangular factor of a matrix whose rows and columns differ by many decades.

Householder reflections: the largest remaining column first and, in it, the largest remaining row.
This is backward stable row by row (Cox and Higham 1998): the rows of soft springs keep their digits
next to those of stiff ones, which an ordinary QR overwrites with rounding.

No row or column is exchanged: the row of a reflection stays where the largest entry was, and the
factor's columns stay in the order of the matrix. All arrays have a batch as their last axis.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Inexact

Stack = Inexact[Array, "rows columns batch"]


def _marked(index: Array, count: int) -> Array:
    return jnp.arange(count)[:, None] == index[None]


def _taken(values: Array, index: Array, axis: int) -> Array:
    """One slice of each member of the batch."""
    index = jnp.expand_dims(index, tuple(range(values.ndim - 1)))
    return jnp.squeeze(jnp.take_along_axis(values, index, axis), axis)


def row_factor(matrix: Stack) -> Inexact[Array, "columns columns batch"]:
    """R with `Rᴴ R = Aᴴ A`, row by row in the order of elimination, of full rank.

    A direction in the null space of the matrix gets a row of size eps² (for a matrix of size one):
    far below rounding, and enough to make the factor regular.

    **Arguments:**

    - `matrix`: A, with a largest entry of about one.
    """
    rows, columns, batch = matrix.shape
    dtype, real = matrix.dtype, matrix.real.dtype
    least = float(jnp.finfo(dtype).eps) ** 2

    def reflected(k, carry):
        a, remaining, turn, norms, at = carry
        squares = jnp.sum(jnp.abs(a) ** 2 * remaining[:, None], axis=0)
        # `turn` is the step in which a column was eliminated; `columns` before.
        pivot_column = jnp.argmax(jnp.where(turn < columns, -1.0, squares), axis=0)
        column = _taken(a, pivot_column, 1) * remaining.astype(dtype)
        norm = jnp.sqrt(_taken(squares, pivot_column, 0))
        row = jnp.argmax(jnp.where(remaining > 0, jnp.abs(column), -1.0), axis=0)
        first = _marked(row, rows)
        top = _taken(column, row, 0)
        size = jnp.abs(top)
        nonzero = size > 0
        phase = top / jnp.where(nonzero, size, 1.0).astype(dtype)
        phase = jnp.where(nonzero, phase, jnp.ones_like(phase))
        normal = column + jnp.where(first, phase * norm.astype(dtype), jnp.zeros_like(phase))
        # Compared this way round, NaN stays NaN.
        empty = norm <= least
        share = jnp.where(empty, 0.0, 1 / jnp.where(empty, 1.0, norm * (norm + size)))
        along = share[None].astype(dtype) * jnp.sum(normal.conj()[:, None] * a, axis=0)
        a = a - normal[:, None] * along[None]
        remaining = jnp.where(first & jnp.logical_not(empty)[None], 0.0, remaining)
        turn = jnp.where(_marked(pivot_column, columns), k, turn)
        return a, remaining, turn, norms.at[k].set(norm), at.at[k].set(row)

    start = (
        matrix,
        jnp.ones((rows, batch), real),
        jnp.full((columns, batch), columns),
        jnp.zeros((columns, batch), real),
        jnp.zeros((columns, batch), int),
    )
    a, _, turn, norms, at = jax.lax.fori_loop(0, columns, reflected, start)
    factor = jnp.take_along_axis(a, at[:, None], 0)
    number = jnp.arange(columns)[:, None, None]
    # Columns eliminated earlier hold rounding errors in place of zeros.
    factor = jnp.where(turn[None] < number, jnp.zeros_like(factor), factor)
    null_row = jnp.where(turn[None] == number, least, 0.0).astype(dtype)
    return jnp.where((norms <= least)[:, None], null_row, factor)
