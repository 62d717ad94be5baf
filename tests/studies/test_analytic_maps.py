"""Which designs of a map are allowed, and how far others are beyond a limit: numbers by hand."""

import numpy as np
import pytest
import scenes

from prsm_jax.mechanism import Constraint
from prsm_jax.optimisation import _limits
from prsm_jax.studies import Driver, DriverMap, StudyProblem
from prsm_jax.studies._map import _violation, map_over_drivers


def _map(**changes):
    """Six designs: allowed, failed, with an error, beyond a limit, at both ends of a tolerance."""
    failed = np.array([False, True, False, False, False, False])
    given = {
        "coordinates": {"lead": np.linspace(5e-3, 10e-3, 6)},
        "values": {},
        "elasticities": {},
        "usable": ~failed,
        "error": np.array([False, False, True, False, False, False]),
        "violations": {"mass": np.array([0.0, np.nan, 0.0, 0.25, 0.9e-5, 1.1e-5])},
    }
    return DriverMap(**(given | changes))


def test_allowed_designs_work_and_satisfy_all_limits():
    assert _map().allowed.tolist() == [True, False, False, False, True, False]
    assert _map().within(0.3).tolist() == [True, False, False, True, True, True]
    # One limit is enough; the other one is satisfied by all.
    two = {"mass": np.zeros(6), "lead": np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])}
    assert _map(violations=two).allowed.tolist() == [True, False, False, True, True, False]
    # Without limits too, a design that fails or has an error is not allowed.
    assert _map(violations={}).allowed.tolist() == [True, False, False, True, True, True]


def test_a_limit_without_a_value_is_not_satisfied():
    """A quantity may be NaN in a design that works."""
    unknown = {"mass": np.array([0.0, 0.0, 0.0, np.nan, 0.0, 0.0])}
    assert _map(violations=unknown).allowed.tolist() == [True, False, False, False, True, True]


@pytest.mark.parametrize(
    ("limit", "expected"),
    [
        ({"upper": 4.0}, [0.0, 0.0, 0.5, np.nan]),
        ({"lower": 4.0}, [0.5, 0.0, 0.0, np.nan]),
        ({"lower": 2.5, "upper": 5.0}, [0.1, 0.0, 0.2, np.nan]),
        ({"equal": 4.0}, [0.5, 0.0, 0.5, np.nan]),
        # Relative to the size of the larger limit, or absolute where that is 0.
        ({"lower": -4.0, "upper": 0.0}, [0.5, 1.0, 1.5, np.nan]),
        ({"upper": 0.0}, [2.0, 4.0, 6.0, np.nan]),
        ({"upper": 4.0, "lower": -np.inf}, [0.0, 0.0, 0.5, np.nan]),
    ],
)
def test_violations_are_relative_to_the_limit(limit, expected):
    values, usable = np.array([2.0, 4.0, 6.0, np.nan]), np.array([True, True, True, False])
    found = _violation(Constraint("mass", **limit), values, usable)
    np.testing.assert_allclose(found, expected, rtol=1e-15)


def test_a_limit_of_0_is_judged_as_the_search_judges_it():
    """A length to 1e-8 m, as `limit_readings` has it."""
    limit, values = Constraint("roller_clearance", lower=0.0), np.array([-9e-9, -1.1e-8, -5e-7])
    excess = _violation(limit, values, np.ones(3, bool))
    np.testing.assert_allclose(excess, [9e-6, 1.1e-5, 5e-4], rtol=1e-12)
    map_ = _map(
        coordinates={"lead": np.ones(3)},
        usable=np.ones(3, bool),
        error=np.zeros(3, bool),
        violations={"roller_clearance": excess},
    )
    assert map_.allowed.tolist() == [True, False, False]
    point = _limits._Point
    for value, kept in zip(values, map_.allowed, strict=True):
        (one,) = _limits._readings_of(limit, [point(None, None, {limit.quantity: float(value)})])
        assert (one.verdict == "pass") == kept


def test_the_worst_component_counts():
    values = np.array([[3.0, 4.0], [5.0, 3.0], [3.0, np.nan]])
    found = _violation(Constraint("rating_life", upper=4.0), values, np.array([True, True, False]))
    np.testing.assert_array_equal(found, [0.0, 0.25, np.nan])


def test_reasons_of_designs_that_fail_are_counted():
    """With k starts the screw has k − 2 roller radii: n rollers overlap if (k − 1) sin(π/n) < 1."""
    mechanism = scenes.mechanism(scenes.stage(friction=scenes.FIRST_STAGE_LOSSES))
    problem = StudyProblem(
        drivers=(Driver("starts", "1", 3.5, 6.0, 5.0),),
        senses={"efficiency": "maximise"},
        objectives=("efficiency",),
        limits=(),
        limited={},
        units={"efficiency": "1"},
    )
    found, _ = map_over_drivers(mechanism, problem, 6, None, False)
    starts = np.linspace(3.5, 6.0, 6)
    overlapping = (starts - 1) * np.sin(np.pi / mechanism.stages[0].roller_count) < 1
    assert 1 < overlapping.sum() < 5
    np.testing.assert_array_equal(found.usable, ~overlapping)
    assert found.reasons == {"overlapping_rollers": int(overlapping.sum())}
