"""Small systems of equations by elimination: values, derivatives, batches."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from prsm_jax.numerics import solve, solve_small, solver

_EPS = np.finfo(float).eps


@pytest.mark.parametrize("size", [2, 3, 12, 44])
def test_solutions(size):
    generator = np.random.default_rng(size)
    matrices = generator.normal(size=(20, size, size))
    # Without an exchange of rows the first pivot would be zero.
    matrices[:, 0, 0] = 0
    rights = generator.normal(size=(20, size))
    found = jax.jit(jax.vmap(solve))(jnp.asarray(matrices), jnp.asarray(rights))
    expected = np.linalg.solve(matrices, rights[..., None])[..., 0]
    error = np.abs(found - expected).max(1) / np.abs(expected).max(1)
    assert np.all(error < 10 * size * _EPS * np.linalg.cond(matrices))


def test_derivatives_in_both_modes():
    """Of the solution by matrix and right-hand side, against the closed form."""
    generator = np.random.default_rng(0)
    matrix, change = generator.normal(size=(2, 5, 5))
    right, moved = generator.normal(size=(2, 5))
    inverse = np.linalg.inv(matrix)
    x, dx = jax.jvp(
        solve, (jnp.asarray(matrix), jnp.asarray(right)), (jnp.asarray(change), jnp.asarray(moved))
    )
    np.testing.assert_allclose(dx, inverse @ (moved - change @ np.asarray(x)), rtol=1e-11)
    weight = generator.normal(size=5)
    by_matrix, by_right = jax.grad(lambda a, b: jnp.asarray(weight) @ solve(a, b), (0, 1))(
        jnp.asarray(matrix), jnp.asarray(right)
    )
    np.testing.assert_allclose(by_right, inverse.T @ weight, rtol=1e-11)
    np.testing.assert_allclose(by_matrix, -np.outer(inverse.T @ weight, x), rtol=1e-11)


def test_one_matrix_and_many_right_hand_sides():
    generator = np.random.default_rng(4)
    matrix, rights = generator.normal(size=(9, 9)) + 9 * np.eye(9), generator.normal(size=(5, 9))
    for solving in (solver, solve_small):
        found = jax.vmap(solving(jnp.asarray(matrix)))(jnp.asarray(rights))
        np.testing.assert_allclose(found, np.linalg.solve(matrix, rights.T).T, rtol=1e-12)
