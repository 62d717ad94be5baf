"""Eigenvalues and eigenvectors of small symmetric matrices by cyclic Jacobi rotations."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

#: Cyclic Jacobi converges quadratically; 4×4 matrices reach rounding in four sweeps, whatever the
#: spread of their entries. One more for larger ones.
_SWEEPS = 5


def _rotate(matrix, vectors, p: int, q: int):
    """One Jacobi rotation on a matrix held as nested lists of scalars."""
    size = len(matrix)
    off = matrix[p][q]
    difference = matrix[q][q] - matrix[p][p]
    # tan of the angle, ± 2 a / (|d| + √(d² + 4 a²)): one root and one division, no overflow at
    # scaled matrices, and 0/1 where there is nothing to rotate.
    width = jnp.abs(difference) + jnp.sqrt(difference**2 + 4 * off**2)
    signed = jnp.where(difference >= 0, 2 * off, -2 * off)
    tangent = signed / jnp.where(width > 0, width, 1.0)
    cosine = 1 / jnp.sqrt(1 + tangent**2)
    sine = tangent * cosine
    matrix[p][p] = matrix[p][p] - tangent * off
    matrix[q][q] = matrix[q][q] + tangent * off
    matrix[p][q] = matrix[q][p] = jnp.zeros_like(off)
    for k in range(size):
        if k not in (p, q):
            left, right = matrix[k][p], matrix[k][q]
            matrix[k][p] = matrix[p][k] = cosine * left - sine * right
            matrix[k][q] = matrix[q][k] = sine * left + cosine * right
    for row in vectors:
        row[p], row[q] = cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]


def symmetric_eigen(
    matrix: Float[Array, "n n"],
) -> tuple[Float[Array, " n"], Float[Array, "n n"]]:
    """Eigenvalues, in no order, and eigenvectors (columns) of a small symmetric matrix.

    Cyclic Jacobi: under `vmap` a few fused loops instead of a LAPACK call per matrix. Not meant
    to be differentiated; the blocks of a symmetric stage have `block_modes`.

    **Arguments:**

    - `matrix`: a symmetric matrix; meant for n ≤ 6.
    """
    size = matrix.shape[-1]
    upper = [(i, j) for i in range(size) for j in range(i, size)]
    square = [(i, j) for i in range(size) for j in range(size)]

    def sweep(_, carry):
        entries, flat = carry
        symmetric = [[entries[min(i, j), max(i, j)] for j in range(size)] for i in range(size)]
        vectors = [[flat[i, j] for j in range(size)] for i in range(size)]
        for p in range(size - 1):
            for q in range(p + 1, size):
                _rotate(symmetric, vectors, p, q)
        return {(i, j): symmetric[i][j] for i, j in upper}, {
            (i, j): vectors[i][j] for i, j in square
        }

    # Scalars rather than a matrix in the carry: under `vmap` each becomes one contiguous array,
    # and a sweep a few fused loops. A loop over sweeps compiles four times faster than unrolled
    # ones and runs twice as fast.
    unit = jnp.eye(size, dtype=matrix.dtype)
    start = ({(i, j): matrix[i, j] for i, j in upper}, {(i, j): unit[i, j] for i, j in square})
    entries, flat = jax.lax.fori_loop(0, _SWEEPS, sweep, start)
    values = jnp.stack([entries[i, i] for i in range(size)])
    columns = jnp.stack([flat[i, j] for i, j in square]).reshape(size, size)
    return values, columns


def generalised_eigen(
    stiffness: Float[Array, "n n"], mass: Float[Array, " n"]
) -> tuple[Float[Array, " n"], Float[Array, "n n"]]:
    """Solve K φ = λ M φ with a diagonal M: λ [1/s²], in no order, mass-normalised shapes φ.

    The symmetric matrix M^{-1/2} K M^{-1/2} is scaled to unit size first, so that float32 keeps
    its range (λ reaches 1e11).
    """
    weight = 1 / jnp.sqrt(mass)
    scaled = stiffness * weight[:, None] * weight[None, :]
    size = jax.lax.stop_gradient(jnp.max(jnp.abs(jnp.diagonal(scaled))))
    size = jnp.where(size > 0, size, 1.0)
    values, vectors = symmetric_eigen(scaled / size)
    return values * size, weight[:, None] * vectors
