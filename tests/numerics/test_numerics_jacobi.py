"""Singular values and eigenvalues by Jacobi rotations, against 50 digits and NumPy."""

import functools

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

from prsm_jax.numerics import hermitian_eigenvalues, singular_values

_singular = jax.jit(singular_values)
_EPS = np.finfo(float).eps
DIGITS = 50


def _exact(matrix):
    """Singular values, ascending, from the eigenvalues of AᵀA with 50 digits."""
    with mpmath.workdps(DIGITS):
        exact = mpmath.matrix(matrix.tolist())
        values = mpmath.eigsy(exact.T * exact, eigvals_only=True)
        return np.sort([float(mpmath.sqrt(abs(value))) for value in values])


def _graded(generator, rows, columns, row_decades, column_decades):
    """Random entries of order one, with rows and columns scaled over some decades."""
    matrix = generator.normal(size=(rows, columns))
    matrix *= 10 ** generator.uniform(-row_decades, 0, rows)[:, None]
    return matrix * 10 ** generator.uniform(-column_decades, 0, columns)


@pytest.mark.parametrize(
    ("rows", "columns", "row_decades", "column_decades"),
    [(30, 17, 0, 0), (30, 17, 6, 0), (30, 17, 12, 3), (4, 3, 12, 0), (9, 2, 6, 6), (5, 1, 3, 0)],
)
def test_small_singular_values_keep_their_digits(rows, columns, row_decades, column_decades):
    """Rows over 12 decades are stiffnesses over 24. The condition of what is left is about 100."""
    generator = np.random.default_rng(rows)
    for _ in range(3):
        matrix = _graded(generator, rows, columns, row_decades, column_decades)
        values, vectors = _singular(jnp.asarray(matrix))
        exact = _exact(matrix)
        np.testing.assert_allclose(np.sort(values), exact, rtol=1e-13)
        np.testing.assert_allclose(vectors.T @ vectors, np.eye(columns), atol=1e-14)
        # Column by column: each singular value belongs to its vector.
        norms = np.linalg.norm(matrix @ np.asarray(vectors), axis=0)
        np.testing.assert_allclose(norms, values, atol=10 * _EPS * exact[-1])


def test_lapack_loses_them():
    """Why: the same matrices by NumPy."""
    matrix = _graded(np.random.default_rng(30), 30, 17, 12, 3)
    exact, found = _exact(matrix), np.linalg.svd(matrix, compute_uv=False)[::-1]
    assert np.max(np.abs(found / exact - 1)) > 1e-11


def test_complex_matrices():
    generator = np.random.default_rng(5)
    matrix = generator.normal(size=(9, 6)) + 1j * generator.normal(size=(9, 6))
    matrix *= 10 ** generator.uniform(-6, 0, 9)[:, None]
    values, vectors = (np.asarray(x) for x in _singular(jnp.asarray(matrix)))
    # As real matrices of twice the size, which have every value twice.
    wide = np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])
    np.testing.assert_allclose(np.sort(values), _exact(wide)[::2], rtol=1e-13)
    np.testing.assert_allclose(vectors.conj().T @ vectors, np.eye(6), atol=1e-14)
    changed = (matrix.conj().T @ matrix) @ vectors
    np.testing.assert_allclose(changed, vectors * values**2, atol=1e-14 * values.max() ** 2)


@pytest.mark.parametrize("rows", [3, 5, 9])
def test_what_is_not_reached_has_vectors_all_the_same(rows):
    """Fewer rows than columns, a matrix of low rank, one of zeros: a whole orthonormal basis."""
    generator = np.random.default_rng(rows)
    matrix = generator.normal(size=(rows, 3)) @ generator.normal(size=(3, 7))
    values, vectors = _singular(jnp.asarray(matrix))
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(7), atol=1e-14)
    assert np.sum(np.asarray(values) > 1e-13 * np.max(values)) == 3
    values, vectors = _singular(jnp.zeros((rows, 7)))
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(7), atol=1e-14)
    assert np.max(values) < 1e-30


def test_repeated_values():
    """A projection, turned: four ones and three zeros."""
    basis = np.linalg.qr(np.random.default_rng(8).normal(size=(7, 7)))[0][:, :4]
    values, vectors = _singular(jnp.asarray(basis @ basis.T))
    np.testing.assert_allclose(np.sort(values), [0, 0, 0, 1, 1, 1, 1], atol=1e-15)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(7), atol=1e-14)


def test_batches_are_what_their_members_are_alone():
    """In any nesting of `vmap`, in one chunk and in several; one bad member does not spread."""
    matrices = np.random.default_rng(1).normal(size=(3, 100, 6, 4))
    matrices[1, 7, 2, 2] = np.nan
    nested = jax.jit(jax.vmap(jax.vmap(singular_values, in_axes=1), in_axes=1))
    values, vectors = nested(jnp.asarray(matrices.transpose(2, 0, 1, 3)))
    assert np.isnan(values[1, 7]).all()
    assert np.isnan(vectors[1, 7]).all()
    assert np.isnan(np.asarray(values)).sum() == 4
    for place in ((0, 0), (1, 8), (2, 99)):
        alone, own = _singular(jnp.asarray(matrices[place]))
        np.testing.assert_allclose(values[place], alone, rtol=1e-14)
        np.testing.assert_allclose(vectors[place], own, atol=1e-14)


def test_single_precision():
    matrix = _graded(np.random.default_rng(2), 12, 8, 3, 0)
    values, vectors = _singular(jnp.asarray(matrix, jnp.float32))
    assert values.dtype == jnp.float32
    np.testing.assert_allclose(np.sort(values), _exact(matrix), rtol=1e-5)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(8), atol=1e-6)


@pytest.mark.parametrize("dtype", [float, complex])
def test_eigenvalues_of_a_hermitian_matrix(dtype):
    generator = np.random.default_rng(9)
    matrix, change = generator.normal(size=(2, 9, 9)).astype(dtype)
    if dtype is complex:
        matrix, change = (x + 1j * generator.normal(size=(9, 9)) for x in (matrix, change))
    matrix, change = matrix + matrix.conj().T, change + change.conj().T
    found = np.sort(hermitian_eigenvalues(jnp.asarray(matrix)))
    bound = 100 * _EPS * np.linalg.norm(matrix)
    np.testing.assert_allclose(found, np.linalg.eigvalsh(matrix), atol=bound)
    along = functools.partial(jax.jvp, hermitian_eigenvalues)
    values, slopes = along((jnp.asarray(matrix),), (jnp.asarray(change),))
    differences = [np.linalg.eigvalsh(matrix + t * change) for t in (1e-6, -1e-6)]
    expected = (differences[0] - differences[1]) / 2e-6
    np.testing.assert_allclose(np.asarray(slopes)[np.argsort(values)], expected, atol=1e-7)


def test_blocks_of_a_matrix_stay_apart():
    """Eigenvalues stand in the places of their block, whatever the others are."""
    generator = np.random.default_rng(10)
    first, second = (x + x.T for x in generator.normal(size=(2, 4, 4)))
    matrix = np.zeros((8, 8))
    odd, even = np.ix_(range(1, 8, 2), range(1, 8, 2)), np.ix_(range(0, 8, 2), range(0, 8, 2))
    matrix[odd], matrix[even] = first, second
    found = np.asarray(hermitian_eigenvalues(jnp.asarray(matrix)))
    for block, places in ((first, slice(1, 8, 2)), (second, slice(0, 8, 2))):
        np.testing.assert_allclose(np.sort(found[places]), np.linalg.eigvalsh(block), atol=1e-13)
