"""Gaussian elimination against LAPACK, and responses in batches."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from response_scenes import LAWS
from scenes import example

import prsm_jax as prsm
from prsm_jax.numerics import factorise, substitute, substitute_transposed

_EPS = np.finfo(float).eps
_solve = jax.jit(lambda a, b: substitute(factorise(a), b))
_solve_transposed = jax.jit(lambda a, b: substitute_transposed(factorise(a), b))


@pytest.mark.parametrize("dtype", [float, complex])
def test_it_solves_what_needs_exchanges_of_rows(dtype):
    generator = np.random.default_rng(3)
    matrix = generator.normal(size=(12, 12)).astype(dtype)
    if dtype is complex:
        matrix = matrix + 1j * generator.normal(size=(12, 12))
    # Without an exchange the first pivot would be 0 and the second 1e-17.
    matrix[0, 0], matrix[1, 1] = 0, 1e-17
    right = generator.normal(size=(12, 3)).astype(dtype)
    for solve, one in ((_solve, matrix), (_solve_transposed, matrix.T)):
        found = np.asarray(solve(jnp.asarray(matrix), jnp.asarray(right)))
        expected = np.linalg.solve(one, right)
        # A growth of the pivots by less than ten.
        bound = 10 * 12 * _EPS * np.linalg.cond(matrix) * np.abs(expected).max()
        assert np.abs(found - expected).max() < bound
    exact = np.asarray(factorise(jnp.asarray(matrix)).smallest_pivot)
    assert exact > 1e-3


def test_a_singular_matrix_shows_in_its_pivots():
    generator = np.random.default_rng(4)
    low = generator.normal(size=(8, 7))
    singular = low @ generator.normal(size=(7, 8))
    factors = factorise(jnp.asarray(singular))
    assert float(factors.smallest_pivot) < 100 * _EPS * np.abs(singular).max()
    assert np.isfinite(np.asarray(factors.matrix)).all()
    assert float(factorise(jnp.zeros((3, 3))).smallest_pivot) == 0.0


def test_one_bad_design_of_a_batch_is_marked():
    """Designs side by side: each is what it is alone; what is not a number is at no pole."""
    one, hertz = example("wu2022"), jnp.asarray([100.0, 5e3])

    def response(stiffness):
        moved = prsm.set_parameter(one, "stiffness.screw_roller", stiffness)
        found = prsm.frequency_response(moved, "screw u", "nut u", hertz, damping=LAWS["modal"])
        return found.value, found.at_pole

    many = jax.jit(jax.vmap(response))
    values, at_pole = many(jnp.asarray([1e8, np.nan, 2e8]))
    assert at_pole.tolist() == [[False] * 2] * 3
    assert np.isnan(np.asarray(values[1])).all()
    others, at_pole = many(jnp.asarray([2e8, 1e8, 3e8]))
    assert not at_pole.any()
    np.testing.assert_array_equal(values[2], others[0])
    np.testing.assert_array_equal(values[0], others[1])


def test_two_responses_in_one_program_do_not_wait_for_each_other():
    """Large enough for batched LAPACK calls of jaxlib 0.10 to share, and to block, two threads."""
    one = prsm.set_parameter(example("wu2022"), "roller_count", 30)
    hertz = jnp.geomspace(100.0, 6e4, 2000)

    @jax.jit
    def both(stiffness):
        moved = prsm.set_parameter(one, "stiffness.screw_roller", stiffness)
        return [
            prsm.frequency_response(moved, source, "nut u", hertz, damping=None).value
            for source in ("screw u", "roller 3 u")
        ]

    first, second = both(jnp.asarray(2e8))
    assert np.isfinite(np.asarray(first)).all()
    assert np.isfinite(np.asarray(second)).all()
