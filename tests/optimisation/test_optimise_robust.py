"""Worst cases, duty cycles and tolerances in a search, against closed forms."""

import dataclasses
from typing import Any

import numpy as np
import pytest
import scenes

from prsm_jax import file
from prsm_jax.mechanism import (
    DesignProblem,
    DutyCycle,
    Objective,
    OperatingCase,
    Tolerance,
    Variable,
)
from prsm_jax.optimisation import MultiStart, operating_range, optimise, pareto
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
    own_quantities("robust_product", lambda a: (lead(a) - 6) ** 2 + 10 * lead(a) * angle(a))


def problem_of(*objectives):
    """A design problem of the lead over all operating points."""
    return DesignProblem(
        (Variable("lead", *BOX["lead"]),),
        objectives,
        operating_points=tuple(OperatingCase(*one) for one in CASES),
    )


def toleranced(**changes):
    mechanism = scenes.mechanism(scenes.stage())
    return dataclasses.replace(mechanism, tolerances=TOLERANCES, **changes)


def test_the_worst_of_several_points(bowls):
    """The larger of (x − 6)² and (x − 9)² is least half-way, with 9/4; x = 7 never counts."""
    best = optimise(
        scenes.frictionless(),
        BOX,
        minimise="robust_bowl",
        operating_points=CASES,
        worst_case=True,
        respect_findings=False,
    )
    assert best.converged, str(best)
    assert best.optimum.variables["lead"] == pytest.approx(7.5e-3, rel=1e-7)
    assert best.optimum.objective == pytest.approx(2.25, rel=1e-7)


def test_a_worst_case_beside_a_mean(bowls):
    """The larger of (x − 6)² and (x − 9)², plus w x, where 7 x is the mean of x F.

    Below x = 7.5 the slope is 2 (x − 9) + w. For w = 1.6 it is −1.4 there and 4.6 above, so the
    least is at the tie; for w = 4 the slope is 0 at x = 7.
    """
    for weight, least in ((1.6, 7.5), (4.0, 7.0)):
        given = problem_of(
            Objective("robust_bowl", over="worst"), Objective("robust_load", weight=weight / 7)
        )
        best = optimise(scenes.frictionless(), problem=given, respect_findings=False)
        assert best.converged, str(best)
        assert best.optimum.variables["lead"] == pytest.approx(1e-3 * least, rel=1e-6)


def test_the_range_of_a_level_follows_the_search(bowls):
    """(x − 8)⁴ − 4 x is −35 at x = 9 and up to 10⁶ in the box; the same at all points."""
    best = optimise(
        scenes.frictionless(),
        {"lead": (4e-3, 40e-3)},
        minimise="robust_fourth",
        operating_points=CASES,
        worst_case=True,
        starts=2,
        respect_findings=False,
    )
    assert best.converged, str(best)
    assert best.optimum.variables["lead"] == pytest.approx(9e-3, rel=1e-5)
    assert best.optimum.objective == pytest.approx(-35.0, rel=1e-9)


def test_a_limit_at_three_standard_deviations(bowls):
    """x + 10 α has the standard deviation 0.1 √2, from 0.1 mm and 10 · 0.01 rad."""
    mechanism, reserve = toleranced(), 3 * 0.1 * np.sqrt(2)
    angle = float(mechanism.stages[0].thread.contact_angle)
    for limits, sign in (((None, 17.0), 1), ((15.0, 20.0), -1)):
        best = optimise(
            mechanism,
            BOX,
            constraints={"robust_sum": limits},
            maximise="robust_load" if sign > 0 else None,
            minimise="robust_load" if sign < 0 else None,
            load=1e3,
            speed=60.0,
            tolerance_sigmas=3.0,
            respect_findings=False,
        )
        assert best.converged, str(best)
        limit = limits[1] if sign > 0 else limits[0]
        lead = limit - sign * reserve - 10 * angle
        assert best.optimum.variables["lead"] == pytest.approx(1e-3 * lead, rel=1e-7)
        active = [one.name for one in best.constraints if one.active]
        assert active == [f"robust_sum {'+' if sign > 0 else '-'} 3 sigma"]
        # x F varies by 0.1 F / 1000 for one standard deviation of x.
        assert best.optimum.objective == pytest.approx(lead - sign * 0.3, rel=1e-7)


def test_an_objective_with_its_standard_deviation(bowls):
    """(x − 6)² + 10 x α: the slope of its standard deviation is a second derivative of it."""
    mechanism = toleranced()
    angle = float(mechanism.stages[0].thread.contact_angle)

    def worsened(x):
        slopes = np.array([0.1 * (2 * (x - 6) + 10 * angle), 0.01 * 10 * x])
        return (x - 6) ** 2 + 10 * x * angle + 3 * np.linalg.norm(slopes)

    best = optimise(
        mechanism,
        {"lead": (1e-3, 14e-3)},
        minimise="robust_product",
        tolerance_sigmas=3.0,
        respect_findings=False,
    )
    assert best.converged, str(best)
    from scipy.optimize import minimize_scalar

    # SciPy's minimum without slopes is good to the root of the rounding error.
    found: Any = minimize_scalar(worsened, bounds=(1.0, 14.0), options={"xatol": 1e-10})
    assert best.optimum.variables["lead"] == pytest.approx(1e-3 * found.x, rel=1e-6)
    assert best.optimum.objective == pytest.approx(found.fun, rel=1e-12)


def test_the_middle_of_a_zone_counts(bowls):
    """A zone from 0 to 0.6 mm has its middle at 0.3 mm."""
    mechanism = dataclasses.replace(
        scenes.frictionless(), tolerances=(Tolerance("lead", 0.0, 6e-4),)
    )
    best = optimise(
        mechanism,
        BOX,
        maximise="robust_load",
        constraints={"robust_sum": (None, 17.0)},
        tolerance_sigmas=2.0,
        respect_findings=False,
    )
    angle = float(mechanism.stages[0].thread.contact_angle)
    lead = 17.0 - 10 * angle - 0.3 - 2 * 0.1
    assert best.optimum.variables["lead"] == pytest.approx(1e-3 * lead, rel=1e-7)


def test_a_real_quantity_agrees_with_its_tolerance_analysis():
    mechanism = toleranced()
    best = optimise(
        mechanism,
        {"contact_angle": (0.5, 1.1)},
        maximise="efficiency",
        constraints={"max_pressure": (None, 1.5e9)},
        tolerance_sigmas=3.0,
    )
    assert best.converged, str(best)
    found = tolerance(best.mechanism, ["efficiency", "max_pressure"], method="first_order").best
    efficiency, pressure = found.estimates["efficiency"], found.estimates["max_pressure"]
    assert best.optimum.objective == pytest.approx(
        efficiency.mean - 3 * efficiency.standard_deviation, rel=1e-9
    )
    (limit,) = best.constraints
    assert limit.value == pytest.approx(pressure.mean + 3 * pressure.standard_deviation, rel=1e-9)


def test_the_duty_cycle_as_operating_points(bowls):
    """The mean by durations of (x − 6)², (x − 9)² and (x − 7)² is least at (6 + 27 + 7) / 5."""
    speeds, loads, durations = np.array(CASES).T
    cycle = DutyCycle(durations, speeds, loads)
    mechanism = dataclasses.replace(scenes.frictionless(), duty_cycle=cycle)
    best = optimise(
        mechanism,
        BOX,
        minimise="robust_bowl",
        operating_points="duty_cycle",
        respect_findings=False,
    )
    assert best.optimum.variables["lead"] == pytest.approx(8e-3, rel=1e-7)
    assert best.problem.operating_points == tuple(OperatingCase(*one) for one in CASES)


def test_a_front_over_a_duty_cycle(bowls):
    """The means are (x − 8)² + 8/5 and 7 x, so √(f₁ − 8/5) + f₂/7 is 8 along the front."""
    speeds, loads, durations = np.array(CASES).T
    cycle = DutyCycle(durations, speeds, loads)
    front = pareto(
        dataclasses.replace(scenes.frictionless(), duty_cycle=cycle),
        {"robust_bowl": "minimise", "robust_load": "minimise"},
        BOX,
        operating_points="duty_cycle",
        points=5,
        respect_findings=False,
    )
    assert front.converged, str(front)
    assert len(front.points) == 5
    first, second = front.values.T
    leads = np.array([1e3 * one.variables["lead"] for one in front.points])
    # A sum of squares against its closed form: rounding.
    np.testing.assert_allclose(first, (leads - 8) ** 2 + 1.6, rtol=1e-12)
    np.testing.assert_allclose(second, 7 * leads, rtol=1e-12)
    # From the best mean, where 1e-4 of the other one counts, to the lower end of the box.
    assert leads[[0, -1]] == pytest.approx([8.0, 4.0], abs=1e-2)
    assert np.all(np.diff(leads) < -0.4)


def test_a_front_with_tolerances(bowls):
    """Each objective is three standard deviations worse than that of the design."""
    mechanism = toleranced()
    angle = float(mechanism.stages[0].thread.contact_angle)
    front = pareto(
        mechanism,
        {"robust_load": "maximise", "robust_product": "minimise"},
        BOX,
        load=1e3,
        speed=60.0,
        tolerance_sigmas=3.0,
        points=5,
        respect_findings=False,
    )
    assert front.converged, str(front)
    assert len(front.points) == 5
    x = np.array([1e3 * one.variables["lead"] for one in front.points])
    slopes = np.stack([0.1 * (2 * (x - 6) + 10 * angle), 0.01 * 10 * x])
    expected = (x - 6) ** 2 + 10 * x * angle + 3 * np.linalg.norm(slopes, axis=0)
    np.testing.assert_allclose(front.values[:, 0], x - 0.3, rtol=1e-12)
    np.testing.assert_allclose(front.values[:, 1], expected, rtol=1e-12)
    # Nothing but the box ends the front.
    assert x[[0, -1]] == pytest.approx([14.0, 4.0], rel=1e-6)
    assert np.all(np.diff(x) < -0.4)


def test_many_starts_at_once_for_a_worst_case(bowls):
    best = optimise(
        scenes.frictionless(),
        problem=problem_of(Objective("robust_bowl", over="worst")),
        method=MultiStart(steps=10, keep=1),
        starts=8,
        respect_findings=False,
    )
    assert best.converged, str(best)
    assert best.optimum.variables["lead"] == pytest.approx(7.5e-3, rel=1e-7)


def test_a_range_of_operating_points():
    points = operating_range((10.0, 30.0), (5e3, 5e3), points=3)
    assert points == ((10.0, 5e3), (20.0, 5e3), (30.0, 5e3))
    assert len(operating_range((1.0, 2.0), (3.0, 4.0))) == 9
    with pytest.raises(ValueError, match="speeds are"):
        operating_range((2.0, 1.0), (3.0, 4.0))
    with pytest.raises(ValueError, match="points is 1"):
        operating_range((1.0, 2.0), (3.0, 4.0), points=1)


def test_the_file_says_the_same():
    text = file.dumps(scenes.example("actuator"))
    short = text.index('maximise = "efficiency"\n')
    rest = text[short + len('maximise = "efficiency"\n') :]
    words = 'operating_points = "duty_cycle"\ntolerance_sigmas = 3\n'
    rows = '[[optimise.objective]]\nquantity = "efficiency"\nsense = "maximise"\nover = "worst"\n\n'
    at = rest.index("[[optimise.variable]]")
    whole = text[:short] + words + rest[:at] + rows + rest[at:]
    whole += '\n[tolerances]\nlead = "±0.02 mm"\n'
    read = file.loads(whole)
    problem = read.design_problem
    assert problem is not None
    assert problem.operating_points == "duty_cycle"
    assert problem.tolerance_sigmas == 3.0
    assert problem.objectives[0].over == "worst"
    assert file.loads(file.dumps(read)).design_problem == problem
    for old, new, message in (
        ('"duty_cycle"', '"duty"', "operating_points"),
        ("sigmas = 3", "sigmas = 30", "at most 10"),
        ('"worst"', '"best"', "over"),
        (words, words + "nut_speed = 0.1\n", "both set the speed"),
    ):
        with pytest.raises(ValueError, match=message):
            file.loads(whole.replace(old, new))
    cycle = whole.index("[[duty_cycle]]"), whole.index("[optimise]")
    with pytest.raises(ValueError, match="the file has no"):
        file.loads(whole[: cycle[0]] + whole[cycle[1] :])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"operating_points": "duty"}, "operating_points is 'duty'"),
        ({"operating_points": "duty_cycle"}, "the mechanism has none"),
        ({"worst_case": True}, "the problem has none; give operating_points"),
        ({"tolerance_sigmas": 3.0}, "the mechanism has no tolerances"),
        ({"tolerance_sigmas": -1.0}, "it must be above 0"),
        (
            {"operating_points": CASES, "worst_case": True, "method": "lbfgs"},
            "with constraints or worst cases choose slsqp",
        ),
    ],
)
def test_errors_name_the_thing(unchecked, bowls, arguments, words):
    with pytest.raises(ValueError, match=words):
        optimise(scenes.frictionless(), BOX, minimise="robust_bowl", **arguments)


def test_a_front_refuses_a_worst_case(bowls):
    problem = problem_of(Objective("robust_bowl", over="worst"), Objective("robust_load"))
    with pytest.raises(ValueError, match="a front takes means"):
        pareto(scenes.frictionless(), problem=problem)
