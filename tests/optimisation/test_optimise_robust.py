"""Worst cases, duty cycles and tolerances in a search, against closed forms."""

import dataclasses

import numpy as np
import pytest
import scenes

from prsm_jax import file
from prsm_jax.mechanism import DutyCycle, Objective, OperatingCase, Tolerance
from prsm_jax.optimisation import MultiStart, operating_range, optimise, pareto
from prsm_jax.quantities import compute
from prsm_jax.uncertainty import tolerance

BOX = {"lead": (4e-3, 14e-3)}
#: Speeds [rad/s], loads [N] and shares.
CASES = [(60.0, 5e3, 1.0), (90.0, 8e3, 3.0), (70.0, 6e3, 1.0)]
#: Of lead and contact angle: 1/10 mm and 1/100 rad are one standard deviation.
TOLERANCES = (Tolerance("lead", -3e-4, 3e-4), Tolerance("contact_angle", -0.03, 0.03))


@pytest.fixture
def bowls(own_quantities):
    """Quantities of the lead x in millimetres, the contact angle and the operating point."""

    def lead(analysis):
        return analysis.mechanism.stages[0].thread.lead * 1e3

    def angle(analysis):
        return analysis.mechanism.stages[0].thread.contact_angle

    own_quantities("robust_bowl", lambda a: (lead(a) - a.speed / 10) ** 2)
    own_quantities("robust_load", lambda a: lead(a) * a.load / 1e3)
    own_quantities("robust_fourth", lambda a: (lead(a) - 8) ** 4 - 4 * lead(a))
    own_quantities("robust_sum", lambda a: lead(a) + 10 * angle(a))


def toleranced(**changes):
    mechanism = scenes.mechanism(scenes.stage())
    return dataclasses.replace(mechanism, tolerances=TOLERANCES, **changes)


def test_the_worst_of_several_points(bowls):
    """The larger of (x − 6)² and (x − 9)² is least half-way, with 9/4; x = 7 never counts."""
    best = optimise(
        scenes.mechanism(), BOX, minimise="robust_bowl", operating_points=CASES, worst_case=True
    )
    assert best.converged, str(best)
    assert best.optimum.variables["lead"] == pytest.approx(7.5e-3, rel=1e-7)
    assert best.optimum.objective == pytest.approx(2.25, rel=1e-7)


def test_a_worst_case_beside_a_mean(bowls):
    """The larger of (x − 6)² and (x − 9)², and 6.4 x / 4: at x < 7.5 the slope is 2 (x − 9) + 1.6.

    The mean of x F is x (5 + 3 · 8 + 6) / 5 = 7 x, here with the weight 1.6 / 7. At x = 7.5 the
    slope of the sum goes from −1.4 to 4.6, and so it is the least; with 4 / 7 the slope is 0 at 7.
    """
    for weight, least in ((1.6, 7.5), (4.0, 7.0)):
        problem = [
            Objective("robust_bowl", over="worst"),
            Objective("robust_load", weight=weight / 7),
        ]
        given = dataclasses.replace(_problem(), objectives=tuple(problem))
        best = optimise(scenes.mechanism(), problem=given)
        assert best.converged, str(best)
        assert best.optimum.variables["lead"] == pytest.approx(1e-3 * least, rel=1e-6)


def _problem():
    return optimise_problem(BOX, CASES)


def optimise_problem(box, cases):
    from prsm_jax.mechanism import DesignProblem, Variable

    return DesignProblem(
        tuple(Variable(name, *bounds) for name, bounds in box.items()),
        (Objective("robust_bowl", over="worst"),),
        operating_points=tuple(OperatingCase(*one) for one in cases),
    )


def test_the_range_of_a_level_follows_the_search(bowls):
    """From 10⁻⁴ at the start's scale to 196 away: (x − 8)⁴ − 4 x has its least at x = 9, −35."""
    best = optimise(
        scenes.mechanism(),
        {"lead": (4e-3, 40e-3)},
        minimise="robust_fourth",
        operating_points=CASES,
        worst_case=True,
        starts=2,
    )
    assert best.converged, str(best)
    assert best.optimum.variables["lead"] == pytest.approx(9e-3, rel=1e-5)
    assert best.optimum.objective == pytest.approx(-35.0, rel=1e-9)
