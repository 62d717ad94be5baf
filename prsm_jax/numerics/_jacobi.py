"""Singular values and vectors, and eigenvalues, of small dense matrices by Jacobi rotations.

One-sided (Hestenes 1958): pairs of vectors are rotated until all are orthogonal. Applied to the
triangular factor of `row_factor`, small singular values and their vectors keep their digits for any
ratio of stiffnesses (Drmač and Veselić 2008). The pairs of one step have no vector in common, so a
step is one operation on all of them, and on all designs of a batch, which is the last axis of every
array here.

Not by LAPACK: its batched calls wait for threads of XLA's only pool while they occupy one, so two
Python threads that run them simultaneously wait for each other for ever.
"""

import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap
from jaxtyping import Array, Float, Inexact

from ._row_factor import row_factor

Vectors = Inexact[Array, "vectors length batch"]
Norms = Float[Array, "pairs batch"]
#: Maximum number of sweeps over all pairs: 5 to 8 suffice for any finite matrix.
_MOST_SWEEPS = 40
#: Number of designs per chunk: their matrices fit in the cache.
_CHUNK = 64


def _tangents(
    first: Norms, second: Norms, product: Array, close: float
) -> tuple[Array, Array, Array | None, Array, Array]:
    """Rotations that make each pair orthogonal, and measures of their deviation from it.

    **Returns:** tangent and product of each pair after a change of the phase of the second vector;
    that phase (none if real); cosine between the pair; and the part of the longer vector that the
    rotation mixes into the direction of the other.
    """
    size = jnp.abs(product)
    lengths = jnp.sqrt(first) * jnp.sqrt(second)
    # NaN compares as converged.
    oblique = size > close * lengths
    divisor = jnp.where(oblique, product, jnp.ones_like(product))
    phase = None
    if jnp.iscomplexobj(product):
        phase = divisor / jnp.where(oblique, size, 1.0).astype(product.dtype)
        divisor = jnp.where(oblique, size, 1.0)
    ratio = (second - first) / (2 * divisor)
    tangent = jnp.where(ratio >= 0, 1.0, -1.0) / (jnp.abs(ratio) + jnp.sqrt(1 + ratio * ratio))
    tangent = jnp.where(oblique, tangent, 0.0)
    longer, shorter = jnp.maximum(first, second), jnp.minimum(first, second)
    cosine = jnp.where(oblique, size / jnp.where(oblique, lengths, 1.0), 0.0)
    mixed = jnp.abs(tangent) * jnp.sqrt(longer / jnp.where(oblique, shorter, 1.0))
    return tangent, divisor, phase, cosine, jnp.where(oblique, mixed, 0.0)


def _moved(top: Array, bottom: Array) -> tuple[Array, Array]:
    """Pairs of the next step: all vectors except the first move cyclically by one place."""
    if top.shape[0] == 1:
        return top, bottom
    return (
        jnp.concatenate([top[:1], bottom[:1], top[1:-1]]),
        jnp.concatenate([bottom[1:], top[-1:]]),
    )


def _sweep(pairs: tuple[Vectors, Vectors], close: float) -> tuple[Vectors, Vectors, Array]:
    """All pairs rotated once; a bound on the remaining cosines."""
    steps = 2 * pairs[0].shape[0] - 1

    def step(_, carry):
        top, bottom, first, second, most, mixed = carry
        product = jnp.sum(top.conj() * bottom, axis=1)
        t, divisor, phase, cosine, mixing = _tangents(first, second, product, close)
        cosines = 1 / jnp.sqrt(1 + t * t)
        c, s = (x.astype(top.dtype)[:, None] for x in (cosines, cosines * t))
        if phase is not None:
            bottom = phase.conj()[:, None] * bottom
        top, bottom = _moved(c * top - s * bottom, s * top + c * bottom)
        change = t * divisor
        first, second = _moved(first - change, second + change)
        # NaN stays NaN, and compares as converged below.
        most = jnp.maximum(most, jnp.max(cosine, axis=0))
        mixed = jnp.maximum(mixed, jnp.max(mixing, axis=0))
        return top, bottom, first, second, most, mixed

    squares = [jnp.sum(jnp.abs(x) ** 2, axis=1) for x in pairs]
    zero = jnp.zeros(squares[0].shape[1:], squares[0].dtype)
    start = (*pairs, *squares, zero, zero)
    top, bottom, _, _, most, mixed = jax.lax.fori_loop(0, steps, step, start)
    return top, bottom, steps * most * mixed


def _orthogonal(vectors: Vectors) -> Vectors:
    """The vectors, rotated among each other until all are orthogonal; in the same places.

    Orthogonal pairs are not rotated, so groups that are orthogonal from the start stay separate.
    After a sweep products of cosines and mixing remain. If all values differ, these are the square
    of the cosines before it, so no further sweep is needed to confirm convergence. NaN where the
    rotations did not converge.
    """
    count = vectors.shape[0]
    if count < 2:
        return vectors
    padded = vectors
    if count % 2:
        padded = jnp.concatenate([vectors, jnp.zeros_like(vectors[:1])])
    half = padded.shape[0] // 2
    close = count * float(jnp.finfo(vectors.dtype).eps)

    def goes_on(carry):
        return jnp.any(carry[2] > close) & (carry[3] < _MOST_SWEEPS)

    def advance(carry):
        return (*_sweep(carry[:2], close), carry[3] + 1)

    remaining = jnp.full(vectors.shape[2:], jnp.inf, vectors.real.dtype)
    start = (padded[:half], padded[half:], remaining, jnp.zeros((), jnp.int32))
    top, bottom, remaining, _ = jax.lax.while_loop(goes_on, advance, start)
    rotated = jnp.concatenate([top, bottom])[:count]
    converged = jnp.logical_not(remaining > close)
    return jnp.where(converged[None, None], rotated, jnp.full_like(rotated, jnp.nan))


def _by_chunks(function, matrices: Array):
    """`function` of a stack of matrices, chunk by chunk."""
    count = matrices.shape[-1]
    if count <= _CHUNK:
        return function(matrices)
    chunks = -(-count // _CHUNK)
    padded = jnp.pad(matrices, ((0, 0), (0, 0), (0, chunks * _CHUNK - count)))
    results = jax.lax.map(
        lambda k: function(jax.lax.dynamic_slice_in_dim(padded, k * _CHUNK, _CHUNK, 2)),
        jnp.arange(chunks),
    )

    def joined(values):
        values = jnp.moveaxis(values, 0, -2)
        return values.reshape((*values.shape[:-2], -1))[..., :count]

    return jax.tree.map(joined, results)


def _stacked(function):
    """`function` of matrices stacked along the last axis; a `vmap` extends this axis."""

    @custom_vmap
    def side_by_side(matrices):
        return _by_chunks(function, matrices)

    @side_by_side.def_vmap
    def _more(axis_size, in_batched, matrices):
        joined = jnp.moveaxis(matrices, 0, -1)
        results = side_by_side(joined.reshape((*joined.shape[:-2], -1)))

        def parted(values):
            return jnp.moveaxis(values.reshape((*values.shape[:-1], -1, axis_size)), -1, 0)

        return jax.tree.map(parted, results), jax.tree.map(lambda _: True, results)

    return side_by_side


@_stacked
def _singular(matrices):
    vectors = _orthogonal(row_factor(matrices).conj())
    values = jnp.sqrt(jnp.sum(jnp.abs(vectors) ** 2, axis=1))
    return values, jnp.swapaxes(vectors / values[:, None].astype(vectors.dtype), 0, 1)


@_stacked
def _hermitian(matrices):
    vectors = _orthogonal(matrices)
    values = jnp.sqrt(jnp.sum(jnp.abs(vectors) ** 2, axis=1))
    return values, jnp.swapaxes(vectors.conj() / values[:, None].astype(vectors.dtype), 0, 1)


def singular_values(
    matrix: Inexact[Array, "rows columns"],
) -> tuple[Float[Array, " columns"], Inexact[Array, "columns columns"]]:
    """Singular values, in no order, and the right singular vectors as columns.

    Relative errors are about 1e-15 times the condition of the matrix with its rows and columns
    scaled to one, not of the matrix itself. Singular values that should be 0 are of the size of
    rounding, and their vectors complete the basis. No derivatives: see the rules of `spring_modes`.
    NaN if an entry is NaN.

    **Arguments:**

    - `matrix`: A; fewer rows than columns are allowed.
    """
    size = jnp.max(jnp.abs(matrix))
    size = jnp.where(size == 0, 1.0, size)
    values, vectors = _singular((matrix / size.astype(matrix.dtype))[..., None])
    return values[:, 0] * size, vectors[..., 0]


def _hermitian_eigen(matrix):
    size = jnp.linalg.norm(matrix)
    size = jnp.where(size == 0, 1.0, size)
    # Shifted to be positive definite: the norms of its orthogonal rows are its eigenvalues.
    shift = 2 * jnp.eye(matrix.shape[0], dtype=matrix.dtype)
    values, vectors = _hermitian((matrix / size.astype(matrix.dtype) + shift)[..., None])
    return (values[:, 0] - 2) * size, vectors[..., 0]


@jax.custom_jvp
def hermitian_eigenvalues(
    matrix: Inexact[Array, "n n"],
) -> Float[Array, " n"]:
    """Eigenvalues of a Hermitian matrix, in no order; errors are about 1e-15 of its norm.

    If the matrix consists of uncoupled blocks, the eigenvalues of a block are in the places of the
    block. The derivative of a simple eigenvalue is `vᴴ dA v`.

    **Arguments:**

    - `matrix`: the matrix.
    """
    return _hermitian_eigen(matrix)[0]


@hermitian_eigenvalues.defjvp
def _hermitian_eigenvalues_jvp(primals, tangents):
    values, vectors = _hermitian_eigen(*primals)
    (change,) = tangents
    return values, jnp.real(jnp.sum(vectors.conj() * (change @ vectors), axis=0))
