"""Yield against a common factor, and cost against yield, for linear quantities in closed form."""

import math

import numpy as np
import pytest
from scipy.special import ndtr, ndtri
from uncertainty_scenes import MECHANISM, TOLERANCES

from prsm_jax.mechanism import Tolerance
from prsm_jax.uncertainty import allocate_tolerances, cost_curve, yield_curve

LINEAR, QUADRATIC = "uncertainty_linear", "uncertainty_quadratic"
LIMITS = {LINEAR: (None, 3.5)}


def test_the_yield_of_wider_tolerances():
    """σ² = 0.12 k² about 3, with the limit 3.5."""
    factors = [0.5, 1.0, 2.0]
    told = []
    found = yield_curve(
        MECHANISM,
        factors,
        LIMITS,
        tolerances=TOLERANCES,
        samples=2048,
        findings=False,
        progress=lambda done, total: told.append((done, total)),
    )
    expected = ndtr(0.5 / (math.sqrt(0.12) * np.array(factors)))
    assert found.factors == pytest.approx(factors)
    # Rounding alone: the quantity is linear.
    assert found.yields["first_order"] == pytest.approx(expected, rel=1e-12)
    assert found.errors["first_order"] == pytest.approx([0, 0, 0])
    for method in ("second_order", "monte_carlo"):
        errors = found.errors[method]
        assert (errors > 0).all()
        assert (errors < 1e-2).all()
        assert (np.abs(found.yields[method] - expected) < 5 * errors).all()
    # Of each factor also the nominal design and both ends of the three zones.
    designs = 3 * (2048 + 1 + 2 * len(TOLERANCES))
    assert told[-1] == (designs, designs)
    assert told == sorted(told)


def test_a_one_sided_zone_keeps_its_middle():
    """Lead 0.2 ± 0.1 mm: 3.4 in the middle, and the limit 3.5 half a deviation away from it."""
    rows = (Tolerance("lead", 0.1e-3, 0.3e-3, sigmas=1.0),)
    found = yield_curve(MECHANISM, [2.0], LIMITS, tolerances=rows, method="first_order")
    assert found.yields["first_order"] == pytest.approx(ndtr(0.1 / 0.4), rel=1e-11)


def test_factors_end_where_numbers_leave_their_range():
    """The contact angle of 45° ± 0.5 rad may be 1.57 times as wide, and not twice."""
    rows = (Tolerance("contact_angle", -0.5, 0.5),)
    found = yield_curve(MECHANISM, None, LIMITS, tolerances=rows, method="first_order")
    assert list(found.factors) == [0.25, 0.5, 0.75, 1.0, 1.25, 1.5]


@pytest.mark.parametrize(
    ("factors", "limits", "message"),
    [
        ([0.0, 1.0], LIMITS, "give positive numbers"),
        ([], LIMITS, "give positive numbers"),
        ([1.0], {}, "there are no limits"),
    ],
)
def test_a_yield_curve_that_makes_no_sense_is_refused(factors, limits, message):
    with pytest.raises(ValueError, match=message):
        yield_curve(MECHANISM, factors, limits, tolerances=TOLERANCES, method="first_order")


def test_the_cost_of_a_yield_has_the_closed_form_of_lagrange():
    """Equal parts and costs: all widths are the same, and the cost is 3 over the width."""
    found = cost_curve(MECHANISM, [0.9, 0.99], LIMITS, tolerances=TOLERANCES)
    widths = 0.5 / ndtri(np.array([0.9, 0.99])) / math.sqrt(0.12)
    assert found.costs == pytest.approx(3 / widths, rel=1e-10)
    assert found.given_cost == pytest.approx(3.0)
    assert found.given_yield == pytest.approx(ndtr(0.5 / math.sqrt(0.12)), rel=1e-12)


def test_costs_are_those_of_the_allocation_and_nan_out_of_reach():
    limits = {LINEAR: (2.5, 3.05), QUADRATIC: (0.8, None)}
    found = cost_curve(MECHANISM, [0.6, 0.9999], limits, tolerances=TOLERANCES)
    one = allocate_tolerances(MECHANISM, 0.6, limits, tolerances=TOLERANCES, verify=False)
    assert found.costs[0] == pytest.approx(one.cost, rel=1e-12)
    assert np.isnan(found.costs[1])
    with pytest.raises(ValueError, match="must be between 0 and 1"):
        cost_curve(MECHANISM, [1.0], limits, tolerances=TOLERANCES)
