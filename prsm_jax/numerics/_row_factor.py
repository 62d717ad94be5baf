"""Triangular factor of a matrix whose rows and columns differ by many decades.

Householder reflections with the largest remaining column and, in it, the largest remaining row
taken first. That is backward stable row by row (Cox and Higham 1998): the rows of soft springs
keep their digits beside those of stiff ones, which an ordinary QR overwrites with rounding.

Nothing is exchanged: the reflection leaves its row where its largest entry was, and the factor's
columns stay in the order of the matrix. All arrays have a batch as their last axis.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Inexact

Stack = Inexact[Array, "rows columns batch"]


def _largest(values: Float[Array, "n batch"]) -> Array:
    """Marks the largest of each column."""
    return jnp.arange(values.shape[0])[:, None] == jnp.argmax(values, axis=0)[None, :]


def _picked(marked: Array, values: Array, axis: int) -> Array:
    return jnp.sum(jnp.where(marked, values, jnp.zeros_like(values)), axis=axis)


def row_factor(matrix: Stack) -> Inexact[Array, "columns columns batch"]:
    """R with `Rᴴ R = Aᴴ A`, row by row in the order of elimination, of full rank.

    A direction that the matrix does not reach gets a row of size eps² (of a matrix of size one):
    far below anything that rounding leaves, and enough to make the factor regular.

    **Arguments:**

    - `matrix`: A, with a largest entry of about one.
    """
    _, columns, batch = matrix.shape
    dtype = matrix.dtype
    least = float(jnp.finfo(dtype).eps) ** 2

    def reflected(k, carry):
        a, done, factor = carry
        squares = jnp.sum(jnp.abs(a) ** 2, axis=0)
        own = _largest(jnp.where(done, -1.0, squares))
        norm = jnp.sqrt(_picked(own, squares, 0))
        column = _picked(own[None], a, 1)
        first = _largest(jnp.abs(column))
        top = _picked(first, column, 0)
        size = jnp.abs(top)
        some = size > 0
        phase = top / jnp.where(some, size, 1.0).astype(dtype)
        phase = jnp.where(some, phase, jnp.ones_like(phase))
        normal = column + jnp.where(first, phase * norm.astype(dtype), jnp.zeros_like(phase))
        divisor = norm * (norm + size)
        # Not the other way round: what is not a number stays so.
        empty = norm <= least
        share = jnp.where(empty, 0.0, 1 / jnp.where(empty, 1.0, divisor)).astype(dtype)
        along = share[None] * jnp.sum(normal.conj()[:, None] * a, axis=0)
        reached = _picked(first[:, None], a, 0) - _picked(first, normal, 0)[None] * along
        alone = jnp.where(own, least, 0.0).astype(dtype)
        factor = factor.at[k].set(jnp.where(empty, alone, reached))
        gone = first[:, None] | own[None]
        a = jnp.where(gone, jnp.zeros_like(a), a - normal[:, None] * along[None])
        return a, done | own, factor

    nothing = jnp.zeros((columns, batch), bool)
    start = (matrix, nothing, jnp.zeros((columns, columns, batch), dtype))
    return jax.lax.fori_loop(0, columns, reflected, start)[2]
