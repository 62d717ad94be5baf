"""An operating point by the speed of the nut: the screw speed follows for every design."""

import numpy as np
import pytest
import scenes

from prsm_jax import file
from prsm_jax.optimisation import optimise, pareto

BOX = {"lead": (4e-3, 14e-3)}


@pytest.fixture
def power(own_quantities):
    """(ω − 150)²/1e4 with the speed ω of the screw, and the speeds of nut and screw themselves."""

    def nut(analysis):
        return analysis.speed * analysis.mechanism.stages[0].thread.lead / (2 * np.pi)

    own_quantities("screw_speed_bowl", lambda a: (a.speed - 150.0) ** 2 / 1e4)
    own_quantities("nut_speed_itself", nut)
    own_quantities("screw_speed_itself", lambda a: a.speed + 0 * a.mechanism.stages[0].thread.lead)


def test_the_lead_gives_the_screw_speed_that_is_wanted(power):
    """ω = 2π v/L is 150 rad/s at L = 2π·0.2/150 = 8.38 mm."""
    best = optimise(scenes.frictionless(), BOX, minimise="screw_speed_bowl", nut_speed=0.2)
    assert best.converged, str(best)
    assert best.optimum.variables["lead"] == pytest.approx(2 * np.pi * 0.2 / 150, rel=1e-5)
    assert best.problem.nut_speed == 0.2


def test_the_nut_has_its_speed_in_every_design_of_a_front(power):
    front = pareto(
        scenes.frictionless(),
        {"screw_speed_itself": "minimise", "nut_speed_itself": "maximise"},
        BOX,
        nut_speed=0.2,
        points=4,
    )
    # The nut's speed is no objective: it is the same everywhere, so one design is the best.
    assert len(front.points) == 1
    (one,) = front.points
    assert one.objectives["nut_speed_itself"] == pytest.approx(0.2, rel=1e-12)
    assert one.variables["lead"] == pytest.approx(14e-3)
    assert one.objectives["screw_speed_itself"] == pytest.approx(2 * np.pi * 0.2 / 14e-3)


def test_the_file_has_a_nut_speed():
    text = file.dumps(scenes.example("actuator"))
    start = text.index("[optimise]\n") + len("[optimise]\n")
    read = file.loads(text[:start] + 'nut_speed = "250 mm/s"\n' + text[start:])
    assert read.design_problem is not None
    assert read.design_problem.nut_speed == pytest.approx(0.25)
    assert file.loads(file.dumps(read)).design_problem == read.design_problem
    with pytest.raises(ValueError, match="nut_speed"):
        file.loads(text[:start] + 'nut_speed = "250 mm"\n' + text[start:])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"nut_speed": 0.0}, "nut_speed is 0.0 m/s; it must be positive"),
        ({"nut_speed": 0.2, "speed": 100.0}, "speed is 100 rad/s and nut_speed 0.2 m/s; give one"),
    ],
)
def test_errors_name_the_thing(power, arguments, words):
    with pytest.raises(ValueError, match=words):
        optimise(scenes.frictionless(), BOX, minimise="screw_speed_bowl", **arguments)
