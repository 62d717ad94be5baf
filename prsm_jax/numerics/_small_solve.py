"""Linear systems of a few unknowns, written out."""

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array, Float

from ._elimination import solver

#: Up to here elimination is written out; larger systems are factorised in a loop.
_LARGEST = 8


def solve_small(
    matrix: Float[Array, "n n"],
) -> Callable[[Float[Array, " n"]], Float[Array, " n"]]:
    """A function that solves `matrix x = right` for any right-hand side.

    Elimination without pivoting, as a few fused multiplications under `vmap`. It suits matrices
    `I/(γh) − J`: the step size keeps their diagonal large, and otherwise the error estimate of the
    step grows and the step is rejected.

    **Arguments:**

    - `matrix`: the matrix; n ≤ 8 is written out, larger ones are pivoted.
    """
    size = matrix.shape[-1]
    if size > _LARGEST:
        return solver(matrix)
    entries = [[matrix[i, j] for j in range(size)] for i in range(size)]
    inverse = []
    for k in range(size):
        inverse.append(1 / entries[k][k])
        for i in range(k + 1, size):
            factor = entries[i][k] * inverse[k]
            entries[i][k] = factor
            for j in range(k + 1, size):
                entries[i][j] = entries[i][j] - factor * entries[k][j]

    def solve(right: Float[Array, " n"]) -> Float[Array, " n"]:
        values = [right[i] for i in range(size)]
        for i in range(size):
            for j in range(i):
                values[i] = values[i] - entries[i][j] * values[j]
        for i in reversed(range(size)):
            for j in range(i + 1, size):
                values[i] = values[i] - entries[i][j] * values[j]
            values[i] = values[i] * inverse[i]
        return jnp.stack(values)

    return solve
