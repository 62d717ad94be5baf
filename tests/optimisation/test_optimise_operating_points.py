"""Means over operating points, limits at each of them, in Python and in the file."""

import numpy as np
import pytest
import scenes

from prsm_jax import file
from prsm_jax.mechanism import OperatingCase
from prsm_jax.optimisation import optimise, pareto
from prsm_jax.quantities import compute

BOX = {"lead": (4e-3, 14e-3)}
#: Speeds [rad/s], loads [N] and shares.
CASES = [(60.0, 5e3, 1.0), (90.0, 8e3, 3.0)]


@pytest.fixture
def bowls(own_quantities):
    """(x − ω/10)² for the lead x in millimetres: the best lead differs with the speed."""

    def lead(analysis):
        return analysis.mechanism.stages[0].thread.lead * 1e3

    own_quantities("speed_bowl", lambda a: (lead(a) - a.speed / 10) ** 2)
    own_quantities("load_times_lead", lambda a: lead(a) * a.load / 1e3)


def test_the_mean_by_shares(bowls):
    """The mean of (x − 6)² and three times (x − 9)² is least at 8.25, with 27/16."""
    best = optimise(scenes.frictionless(), BOX, minimise="speed_bowl", operating_points=CASES)
    assert best.converged, str(best)
    assert best.optimum.variables["lead"] == pytest.approx(8.25e-3, rel=1e-6)
    assert best.optimum.objective == pytest.approx(27 / 16, rel=1e-9)
    assert best.problem.operating_points == tuple(OperatingCase(*one) for one in CASES)


def test_a_limit_holds_at_every_point(bowls):
    """x F ≤ 50 N m: with 8 kN a lead of 6.25 mm, with 5 kN one of 10 mm."""
    best = optimise(
        scenes.frictionless(),
        BOX,
        None,
        "speed_bowl",
        {"load_times_lead": (None, 50.0)},
        operating_points=CASES,
    )
    assert best.converged, str(best)
    assert best.optimum.variables["lead"] == pytest.approx(6.25e-3, rel=1e-6)
    first, second = best.constraints
    assert (first.name, second.name) == ("load_times_lead[1]", "load_times_lead[2]")
    assert (first.active, second.active) == (False, True)
    assert first.value == pytest.approx(31.25, rel=1e-6)


def test_a_front_of_means(bowls):
    front = pareto(
        scenes.frictionless(),
        {"speed_bowl": "minimise", "load_times_lead": "minimise"},
        BOX,
        operating_points=CASES,
        points=4,
    )
    assert front.converged, str(front)
    for one in front.points:
        x = 1e3 * one.variables["lead"]
        mean = ((x - 6) ** 2 + 3 * (x - 9) ** 2) / 4
        assert one.objectives["speed_bowl"] == pytest.approx(mean, rel=1e-9)
        assert one.objectives["load_times_lead"] == pytest.approx(x * 7.25, rel=1e-9)


def test_the_mean_of_a_real_quantity():
    mechanism = scenes.mechanism()
    best = optimise(
        mechanism, {"contact_angle": (0.5, 1.1)}, maximise="efficiency", operating_points=CASES
    )
    assert best.converged, str(best)
    values = [
        float(compute(best.mechanism, ["efficiency"], speed=speed, load=load)["efficiency"])
        for speed, load, _ in CASES
    ]
    mean = np.average(values, weights=[share for *_, share in CASES])
    assert best.optimum.objective == pytest.approx(mean, rel=1e-12)


def test_the_file_has_operating_points():
    text = file.dumps(scenes.example("actuator"))
    rows = '\n[[optimise.operating_point]]\nspeed = "300 rpm"\nload = "3 kN"\nshare = 2\n'
    at = text.index("\n[[optimise.variable]]")
    read = file.loads(text[:at] + rows + text[at:])
    assert read.design_problem is not None
    cases = read.design_problem.operating_points
    assert not isinstance(cases, str)
    (case,) = cases
    assert (case.speed, case.load, case.share) == (pytest.approx(10 * np.pi), 3000.0, 2.0)
    assert file.loads(file.dumps(read)).design_problem == read.design_problem
    wrong = rows.replace("300 rpm", "300 kN")
    with pytest.raises(ValueError, match="speed"):
        file.loads(text[:at] + wrong + text[at:])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"operating_points": []}, "operating_points is empty"),
        ({"operating_points": [60.0]}, "give .speed, load."),
        ({"operating_points": [(60.0, 5e3, 0.0)]}, "share is 0.0; it must be positive"),
        ({"operating_points": [(60.0, np.inf)]}, "load is inf"),
        ({"operating_points": CASES, "speed": 60.0}, "give one or the other"),
        ({"operating_points": CASES, "nut_speed": 0.1}, "both set the speed"),
    ],
)
def test_errors_name_the_thing(unchecked, bowls, arguments, words):
    with pytest.raises(ValueError, match=words):
        optimise(scenes.frictionless(), BOX, minimise="speed_bowl", **arguments)
