"""Singular values and vectors, and eigenvalues, of small dense matrices by Jacobi rotations.

One-sided (Hestenes 1958): pairs of vectors are turned until all are orthogonal. Applied to the
triangular factor of `row_factor`, small singular values and their vectors keep their digits
whatever the ratio of stiffnesses is (Drmač and Veselić 2008). The pairs of one step have no vector
in common, so a step is one operation on all of them, and on all designs of a batch, which is the
last axis of every array here.

Not by LAPACK: its batched calls wait for threads of XLA's only pool while they hold one, so two
Python threads that run them at once wait for each other for ever.
"""

import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap
from jaxtyping import Array, Float, Inexact

from ._row_factor import row_factor

Vectors = Inexact[Array, "vectors length batch"]
#: Most sweeps over all pairs: 5 to 8 suffice for any matrix that is finite.
_MOST_SWEEPS = 40
#: Designs that are taken at once: their matrices stay in the cache.
_CHUNK = 128


def _turned(top: Vectors, bottom: Vectors, close: float) -> tuple[Vectors, Vectors, Array]:
    """Each pair made orthogonal; and whether any was not, to rounding."""
    first, second = (jnp.sum(jnp.abs(x) ** 2, axis=1) for x in (top, bottom))
    product = jnp.sum(top.conj() * bottom, axis=1)
    size = jnp.abs(product)
    # What is not a number compares as done.
    oblique = size > close * (jnp.sqrt(first) * jnp.sqrt(second))
    divisor = jnp.where(oblique, size, 1.0)
    ratio = (second - first) / (2 * divisor)
    tangent = jnp.where(ratio >= 0, 1.0, -1.0) / (jnp.abs(ratio) + jnp.sqrt(1 + ratio * ratio))
    tangent = jnp.where(oblique, tangent, 0.0)
    cosine = 1 / jnp.sqrt(1 + tangent * tangent)
    phase = jnp.where(oblique, product / divisor.astype(product.dtype), jnp.ones_like(product))
    c = cosine.astype(top.dtype)[:, None]
    s = (cosine * tangent).astype(top.dtype)[:, None]
    bottom = phase.conj()[:, None] * bottom
    return c * top - s * bottom, s * top + c * bottom, jnp.any(oblique)


def _moved(top: Vectors, bottom: Vectors) -> tuple[Vectors, Vectors]:
    """The pairs of the next step: all vectors but the first go round by one place."""
    if top.shape[0] == 1:
        return top, bottom
    return (
        jnp.concatenate([top[:1], bottom[:1], top[1:-1]]),
        jnp.concatenate([bottom[1:], top[-1:]]),
    )


def _orthogonal(vectors: Vectors) -> Vectors:
    """The vectors, turned among each other until all are orthogonal; in the same places.

    Orthogonal ones are left as they are, so groups that are orthogonal from the start stay apart.
    Not a number where the rotations did not end.
    """
    count = vectors.shape[0]
    if count < 2:
        return vectors
    padded = vectors
    if count % 2:
        padded = jnp.concatenate([vectors, jnp.zeros_like(vectors[:1])])
    half = padded.shape[0] // 2
    period = padded.shape[0] - 1
    close = count * float(jnp.finfo(vectors.dtype).eps)

    def goes_on(carry):
        _, _, step, oblique = carry
        return ((step % period != 0) | oblique) & (step < _MOST_SWEEPS * period)

    def advance(carry):
        top, bottom, step, before = carry
        top, bottom, oblique = _turned(top, bottom, close)
        # The first step of a sweep forgets the sweep before.
        return (*_moved(top, bottom), step + 1, oblique | (before & (step % period != 0)))

    start = (padded[:half], padded[half:], jnp.zeros((), jnp.int32), jnp.asarray(True))
    top, bottom, _, oblique = jax.lax.while_loop(goes_on, advance, start)
    found = jnp.concatenate([top, bottom])[:count]
    return jnp.where(oblique, jnp.full_like(found, jnp.nan), found)


def _by_chunks(function, matrices: Array):
    """`function` of a stack of matrices, or of one chunk of it after the other."""
    count = matrices.shape[-1]
    if count <= _CHUNK:
        return function(matrices)
    chunks = -(-count // _CHUNK)
    padded = jnp.pad(matrices, ((0, 0), (0, 0), (0, chunks * _CHUNK - count)))
    found = jax.lax.map(
        lambda k: function(jax.lax.dynamic_slice_in_dim(padded, k * _CHUNK, _CHUNK, 2)),
        jnp.arange(chunks),
    )

    def joined(values):
        values = jnp.moveaxis(values, 0, -2)
        return values.reshape((*values.shape[:-2], -1))[..., :count]

    return jax.tree.map(joined, found)


def _stacked(function):
    """`function` of matrices that lie side by side in the last axis; any `vmap` adds to them."""

    @custom_vmap
    def side_by_side(matrices):
        return _by_chunks(function, matrices)

    @side_by_side.def_vmap
    def _more(axis_size, in_batched, matrices):
        joined = jnp.moveaxis(matrices, 0, -1)
        found = side_by_side(joined.reshape((*joined.shape[:-2], -1)))

        def parted(values):
            return jnp.moveaxis(values.reshape((*values.shape[:-1], -1, axis_size)), -1, 0)

        return jax.tree.map(parted, found), jax.tree.map(lambda _: True, found)

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
    scaled to one, not of the matrix itself. Those of a singular matrix are as large as rounding
    makes them, and its vectors complete the others. No derivatives: see the rules of
    `spring_modes`. Not a number where an entry is not one.

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
    # Positive definite, so that the norms of its orthogonal rows are its eigenvalues.
    shift = 2 * jnp.eye(matrix.shape[0], dtype=matrix.dtype)
    values, vectors = _hermitian((matrix / size.astype(matrix.dtype) + shift)[..., None])
    return (values[:, 0] - 2) * size, vectors[..., 0]


@jax.custom_jvp
def hermitian_eigenvalues(
    matrix: Inexact[Array, "n n"],
) -> Float[Array, " n"]:
    """Eigenvalues of a Hermitian matrix, in no order; errors are about 1e-15 of its norm.

    Those of a block of a matrix that falls into blocks stand in the places of the block. The
    derivative of a simple one is `vᴴ dA v`.

    **Arguments:**

    - `matrix`: the matrix.
    """
    return _hermitian_eigen(matrix)[0]


@hermitian_eigenvalues.defjvp
def _hermitian_eigenvalues_jvp(primals, tangents):
    values, vectors = _hermitian_eigen(*primals)
    (change,) = tangents
    return values, jnp.real(jnp.sum(vectors.conj() * (change @ vectors), axis=0))
