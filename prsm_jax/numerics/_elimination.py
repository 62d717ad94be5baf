"""Gaussian elimination of one small matrix, in plain array operations.

Not by LAPACK: its batched calls share XLA's few threads and, in jaxlib 0.10, two independent calls,
e.g. two responses in one compiled program, can wait for each other for ever. For matrices of this
size there is no disadvantage.
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Inexact, Int


class Factors(eqx.Module):
    """P A = L U, with partial pivoting."""

    #: U in the upper triangle, the multipliers of L below it.
    matrix: Inexact[Array, "n n"]
    #: Row of A in each row of the factors.
    order: Int[Array, " n"]

    @property
    def smallest_pivot(self) -> Float[Array, ""]:
        """Magnitude of the smallest pivot."""
        return jnp.min(jnp.abs(jnp.diagonal(self.matrix)))


def factorise(matrix: Inexact[Array, "n n"]) -> Factors:
    """Factors of a matrix; those of a singular matrix are finite, but useless."""
    rows = jnp.arange(matrix.shape[0])

    def step(k, carry):
        a, order = carry
        column = jnp.where(rows >= k, jnp.abs(a[:, k]), -1.0)
        p = jnp.argmax(column)
        first, best = a[k], a[p]
        # Exchange, and eliminate below: one pass over the matrix.
        a = jnp.where((rows == p)[:, None], first[None, :], a)
        a = jnp.where((rows == k)[:, None], best[None, :], a)
        pivot = jnp.where(best[k] == 0, jnp.ones_like(best[k]), best[k])
        share = jnp.where(rows > k, a[:, k] / pivot, jnp.zeros_like(best))
        reduced = a - share[:, None] * jnp.where(rows > k, best, jnp.zeros_like(best))[None, :]
        stored = (rows > k)[:, None] & (rows == k)[None, :]
        a = jnp.where(stored, share[:, None], reduced)
        moved = jnp.where(rows == p, order[k], order)
        return a, jnp.where(rows == k, order[p], moved)

    eliminated, order = jax.lax.fori_loop(0, matrix.shape[0], step, (matrix, rows))
    return Factors(eliminated, order)


def substitute(factors: Factors, right: Inexact[Array, "n loads"]) -> Inexact[Array, "n loads"]:
    """Solve A x = b with the factors of A."""
    a, size = factors.matrix, factors.matrix.shape[0]
    rows = jnp.arange(size)

    def forward(k, x):
        return x - jnp.where(rows > k, a[:, k], jnp.zeros_like(a[:, k]))[:, None] * x[k][None, :]

    def backward(step, x):
        k = size - 1 - step
        row = x[k] / a[k, k]
        rest = x - jnp.where(rows < k, a[:, k], jnp.zeros_like(a[:, k]))[:, None] * row[None, :]
        return jnp.where((rows == k)[:, None], row[None, :], rest)

    lower = jax.lax.fori_loop(0, size, forward, right[factors.order])
    return jax.lax.fori_loop(0, size, backward, lower)


def substitute_transposed(
    factors: Factors, right: Inexact[Array, "n loads"]
) -> Inexact[Array, "n loads"]:
    """Solve Aᵀ x = b with the factors of A."""
    a, size = factors.matrix, factors.matrix.shape[0]
    rows = jnp.arange(size)

    def forward(k, x):
        row = x[k] / a[k, k]
        rest = x - jnp.where(rows > k, a[k], jnp.zeros_like(a[k]))[:, None] * row[None, :]
        return jnp.where((rows == k)[:, None], row[None, :], rest)

    def backward(step, x):
        k = size - 1 - step
        return x - jnp.where(rows < k, a[k], jnp.zeros_like(a[k]))[:, None] * x[k][None, :]

    upper = jax.lax.fori_loop(0, size, forward, right)
    lower = jax.lax.fori_loop(0, size, backward, upper)
    return jnp.zeros_like(lower).at[factors.order].set(lower)


def solve(matrix: Inexact[Array, "n n"], right: Inexact[Array, " n"]) -> Inexact[Array, " n"]:
    """x with A x = b; the derivatives solve with the same factors.

    **Arguments:**

    - `matrix`: A, real. If it is singular to rounding, the result is meaningless.
    - `right`: b.
    """
    return solver(matrix)(right)


def solver(
    matrix: Inexact[Array, "n n"],
) -> Callable[[Inexact[Array, " n"]], Inexact[Array, " n"]]:
    """A function that solves A x = b for any b, with the matrix factorised once.

    **Arguments:**

    - `matrix`: A, real.
    """
    factors = factorise(jax.lax.stop_gradient(matrix))

    def solved(right: Inexact[Array, " n"]) -> Inexact[Array, " n"]:
        return jax.lax.custom_linear_solve(
            lambda x: matrix @ x,
            right,
            lambda _, b: substitute(factors, b[:, None])[:, 0],
            lambda _, b: substitute_transposed(factors, b[:, None])[:, 0],
        )

    return solved
