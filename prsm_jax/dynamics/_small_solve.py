"""Linear systems of a few unknowns, written out."""

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array, Float

#: Up to here elimination is written out; larger systems go to LAPACK.
_LARGEST = 8


def solve_small(
    matrix: Float[Array, "n n"],
) -> Callable[[Float[Array, " n"]], Float[Array, " n"]]:
    """A function that solves `matrix x = right` for any right-hand side.

    Elimination without pivoting, as a few fused multiplications under `vmap` instead of a LAPACK
    call per matrix. Without pivoting it suits matrices `I/(γh) − J`: the step size keeps their
    diagonal large, and where it does not, the error estimate of the step grows and rejects it.

    **Arguments:**

    - `matrix`: the matrix; n ≤ 8 is written out.
    """
    size = matrix.shape[-1]
    if size > _LARGEST:
        from jax.scipy.linalg import lu_factor, lu_solve

        factors = lu_factor(matrix)
        return lambda right: lu_solve(factors, right)
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
