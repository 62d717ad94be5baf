"""Tolerances of least cost: Lagrange's closed form, optimality by perturbation, Monte Carlo."""

import dataclasses
import math

import numpy as np
import pytest
import scipy.optimize
from scipy.special import ndtri
from uncertainty_scenes import MECHANISM, TOLERANCES

import prsm_jax as prsm
from prsm_jax.mechanism import Tolerance
from prsm_jax.uncertainty import allocate_tolerances
from tests.present import present

LINEAR, QUADRATIC = "uncertainty_linear", "uncertainty_quadratic"
COSTS = (1.0, 8.0, 0.125)
ROWS = tuple(
    Tolerance(one.name, one.lower, one.upper, cost=cost)
    for one, cost in zip(TOLERANCES, COSTS, strict=True)
)


def _widths(allocation):
    pairs = zip(allocation.tolerances, allocation.before, strict=True)
    return np.array([new.half_width / old.half_width for new, old in pairs])


def test_one_limit_has_the_closed_form_of_lagrange():
    """All slopes are 0.2: widths are as the cube roots of the costs, 1 : 2 : 0.5."""
    allocation = allocate_tolerances(
        MECHANISM, 0.99, {LINEAR: (None, 3.5)}, tolerances=ROWS, findings=False
    )
    widths = _widths(allocation)
    assert widths / widths[0] == pytest.approx([1.0, 2.0, 0.5], rel=1e-10)
    deviation = 0.2 * math.sqrt(np.sum(widths**2))
    assert deviation == pytest.approx(0.5 / ndtri(0.99), rel=1e-10)
    assert allocation.yield_first_order == pytest.approx(0.99, abs=1e-12)
    assert allocation.cost == pytest.approx(np.sum(np.array(COSTS) / widths), rel=1e-12)
    assert allocation.cost_before == pytest.approx(9.125)
    # Monte Carlo agrees, because the quantity is linear.
    best = allocation.verification.best
    assert best.yield_share is not None
    assert best.yield_error is not None
    assert best.yield_share == pytest.approx(0.99, abs=5 * best.yield_error)
    assert best.yield_error < 2e-3
    assert f"Monte Carlo {100 * best.yield_share:.5g}" in allocation.text()
    assert allocation.to_dict()["yield_monte_carlo"] == best.yield_share


def test_errors_of_check_are_named_beside_the_yield():
    """Designs that fail or have an error lower the yield, and no width of the limit explains it."""
    allocation = allocate_tolerances(
        MECHANISM, 0.99, {LINEAR: (None, 3.5)}, tolerances=ROWS, findings=False
    )
    check = present(allocation.verification)
    assert "fail or have an error" not in allocation.text()
    best = dataclasses.replace(check.best, reasons={"not_finite": 2}, errors={"pointed_tooth": 31})
    worse = dataclasses.replace(check, methods={**check.methods, check.method: best})
    words = dataclasses.replace(allocation, verification=worse).text()
    assert words.endswith(
        f"of {best.samples} designs, those that fail or have an error are not within the "
        "limits: not finite (2), prsm check: pointed tooth (31)"
    )


def test_two_limits_cannot_be_met_at_less_cost():
    """No widths near those found keep the yield and cost less."""
    limits = {LINEAR: (2.5, 3.6), QUADRATIC: (0.8, None)}
    allocation = allocate_tolerances(MECHANISM, 0.95, limits, tolerances=ROWS, verify=False)
    assert 0.95 <= allocation.yield_first_order < 0.95 + 1e-6
    widths = _widths(allocation)
    deviations = np.array([[0.2, 0.2, 0.2], [0.1, 0.0, 0.0]])
    sides = np.array([[-0.5, 0.6], [-0.2, math.inf]])

    def share(at):
        from scipy.special import ndtr

        sizes = np.sqrt(np.sum((deviations * at) ** 2, axis=1))
        return 1 - np.sum(1 - ndtr(sides[:, 1] / sizes) + ndtr(sides[:, 0] / sizes))

    assert share(widths) == pytest.approx(allocation.yield_first_order, abs=1e-10)
    generator = np.random.default_rng(0)
    for size in (1e-1, 1e-2, 1e-3):
        for _ in range(200):
            other = widths * np.exp(size * generator.standard_normal(3))
            if share(other) >= 0.95:
                # The optimality that SLSQP reaches.
                assert np.sum(np.array(COSTS) / other) > allocation.cost * (1 - 1e-6)


def test_a_tolerance_without_effect_becomes_ten_times_as_wide():
    rows = (ROWS[0], ROWS[2])
    limits = {QUADRATIC: (0.8, None)}
    allocation = allocate_tolerances(MECHANISM, 0.95, limits, tolerances=rows, verify=False)
    widths = _widths(allocation)
    assert widths[1] == pytest.approx(10.0, rel=1e-6)
    assert widths[0] == pytest.approx(0.2 / ndtri(0.95) / 0.1, rel=1e-5)


def test_one_sided_zones_keep_their_middle():
    rows = (Tolerance("lead", 0.1e-3, 0.3e-3, "uniform"),)
    limits = {LINEAR: (None, 3.7)}
    (one,) = allocate_tolerances(MECHANISM, 0.95, limits, tolerances=rows, verify=False).tolerances
    assert one.middle == pytest.approx(0.2e-3, rel=1e-12)
    assert one.distribution == "uniform"
    assert one.half_width == pytest.approx(0.3e-3 / 2 / ndtri(0.95) * 3**0.5, rel=1e-9)


def test_a_quantity_that_no_tolerance_moves_does_not_disturb_the_search():
    """The quadratic quantity does not depend on the load; alone it allows the widest tolerance."""
    rows = (ROWS[2], Tolerance("thread.coefficient", -0.04, 0.04))
    both = {LINEAR: (2.5, 3.2), QUADRATIC: (0.8, None)}
    one = allocate_tolerances(MECHANISM, 0.95, {LINEAR: (2.5, 3.2)}, tolerances=rows, verify=False)
    two = allocate_tolerances(MECHANISM, 0.95, both, tolerances=rows, verify=False)
    assert np.isfinite(_widths(two)).all()
    assert _widths(two) == pytest.approx(_widths(one), rel=1e-12)
    assert two.yield_first_order == one.yield_first_order
    free = allocate_tolerances(
        MECHANISM, 0.95, {QUADRATIC: (0.8, None)}, tolerances=rows[:1], verify=False
    )
    assert _widths(free)[0] == pytest.approx(10.0, rel=1e-12)
    assert free.yield_first_order == 1.0


@pytest.mark.parametrize(("status", "refused"), [(0, False), (8, False), (9, True)])
def test_a_search_that_stops_early_is_an_error(monkeypatch, status, refused):
    """SLSQP ends at an optimum with 0, and with 8 where rounding hides a further descent."""
    minimize = scipy.optimize.minimize

    def stopped(*args, **kwargs):
        found = minimize(*args, **kwargs)
        found.status, found.success, found.message = status, status == 0, "Iteration limit reached"
        return found

    monkeypatch.setattr(scipy.optimize, "minimize", stopped)
    limits = {LINEAR: (2.5, 3.6), QUADRATIC: (0.8, None)}

    def run():
        return allocate_tolerances(MECHANISM, 0.95, limits, tolerances=ROWS, verify=False)

    if refused:
        with pytest.raises(ValueError, match="found no optimum: Iteration limit reached"):
            run()
    else:
        assert run().yield_first_order >= 0.95


@pytest.mark.parametrize(
    ("wanted", "limits", "message"),
    [
        (1.0, {LINEAR: (None, 3.5)}, "wanted_yield is 1.0; it must be between 0 and 1"),
        (0.9, {}, "there are no limits"),
        (0.9, {LINEAR: (None, 2.9)}, "outside of its limits -inf to 2.9; no tolerances help"),
        (0.99, {LINEAR: (None, 3.01)}, "needs tolerances of less than a tenth"),
    ],
)
def test_what_is_wrong_is_said(wanted, limits, message):
    with pytest.raises(ValueError, match=message):
        allocate_tolerances(MECHANISM, wanted, limits, tolerances=ROWS)


def test_wide_limits_allow_the_widest_tolerances():
    """Ten times the given ones, but for the contact angle of 45°, which has to stay above 0."""
    allocation = allocate_tolerances(
        MECHANISM, 0.99, {LINEAR: (-100.0, 100.0)}, tolerances=ROWS, verify=False
    )
    assert _widths(allocation) == pytest.approx([10.0, math.pi / 4 / 0.15, 10.0], rel=1e-9)
    assert isinstance(allocation, prsm.uncertainty.Allocation)


def test_a_widened_tolerance_stays_in_the_range_of_its_number():
    """The coefficient 0.1 ± 0.04, without effect, cannot become ten times as wide."""
    rows = (ROWS[0], Tolerance("thread.coefficient", -0.04, 0.04))
    limits = {LINEAR: (None, 3.2)}
    allocation = allocate_tolerances(MECHANISM, 0.95, limits, tolerances=rows, verify=False)
    assert _widths(allocation)[1] == pytest.approx(2.5, rel=1e-6)
    assert allocation.tolerances[1].lower > -0.1 - 1e-12
