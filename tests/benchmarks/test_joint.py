"""The benchmark of joint derivatives: its references and its table, on functions of closed form."""

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.joint.command import tables
from benchmarks.joint.measured import (
    as_one,
    central_differences,
    error_of,
    random_subsets,
    reference_jacobian,
    timed,
)


def _evaluate(x):
    return {"product": x[0] * x[1] ** 2, "powers": jnp.stack([x[0] ** 3, jnp.exp(x[1])])}


def _jacobian(x):
    return np.array([[x[1] ** 2, 2 * x[0] * x[1]], [3 * x[0] ** 2, 0], [0, np.exp(x[1])]])


def test_references_and_differences():
    """Sixth order at 0.4 %, second order at 1e-5, each with its own error."""
    centre = jnp.asarray([1.3, 0.7])
    together = as_one(_evaluate)
    np.testing.assert_allclose(reference_jacobian(together, centre), _jacobian(centre), atol=1e-11)
    found = central_differences(together, 2)(centre)
    np.testing.assert_allclose(found, _jacobian(centre), atol=1e-9)
    assert error_of(np.asarray(found) * (1 + 1e-3), _jacobian(centre)) > 0.9e-3


def test_programs_are_sampled_for_the_whole_batch():
    designs = jnp.asarray([[1.3, 0.7], [1.0, 2.0], [0.4, 0.1]])
    found = timed({"slopes": jax.jacfwd(as_one(_evaluate))}, designs, 0.0)["slopes"]
    assert found.seconds > 0
    np.testing.assert_allclose(found.found[1], _jacobian(np.array([1.0, 2.0])), rtol=1e-14)


def test_subsets_are_different_and_the_same_again():
    names = [f"q{i}" for i in range(12)]
    subsets = random_subsets(names, 30, 15)
    assert len(set(subsets)) == 30
    assert subsets == random_subsets(names, 30, 15)
    assert all(2 <= len(one) <= 6 for one in subsets)


def test_the_table_has_the_numbers_of_the_document():
    row = {
        "quantities": ["efficiency", "max_pressure"],
        "microseconds": {"value": 1.234},
        "over_value": {"dictionary": 2.5, "concatenated": 2.75},
        "differences_over_forward": 3.25,
        "error_forward": 2e-9,
        "error_differences": 8e-8,
        "compile_s": {"forward, concatenated": 12.5},
    }
    second = {
        "quantity": "efficiency",
        "microseconds": {"value": 0.5},
        "reverse_over_value": 1.5,
        "hessian_over_value": 21.0,
        "error": 4e-9,
        "compile_s": {"forward over forward": 9.5},
    }
    text = tables({"example": "wu2022", "designs": 7, "joint": [row], "hessians": [second]})
    assert "Designs of `wu2022`, 7 at once" in text
    assert "| efficiency, max_pressure | 1.23 | 2.50 | 2.75 | 3.25 | 2e-09 | 8e-08 | 12.5 |" in text
    assert "| efficiency | 0.50 | 1.50 | 21.0 | 4e-09 | 9.5 |" in text
