"""Choices among listed values: every combination, against problems whose best one is known."""

import json

import numpy as np
import pytest
import scenes

from prsm_jax import file
from prsm_jax.mechanism import (
    Choice,
    DesignProblem,
    Gear,
    Objective,
    Screw,
    Variable,
    standard_modules,
)
from prsm_jax.optimisation import Slsqp, optimise, pareto
from prsm_jax.optimisation.search import _outputs

ANGLE = {"contact_angle": (0.3, 1.3)}


def _numbers(analysis):
    stage = analysis.mechanism.stages[0]
    return stage.thread.lead * 1e3, stage.thread.contact_angle, stage.roller_count


@pytest.fixture
def valley(own_quantities):
    """(x − 8.2)² + 10 (y − x/10)² + (N − 8)²/4: the best lead is 8 mm of 5, 8 and 10."""

    def function(analysis):
        x, y, count = _numbers(analysis)
        return (x - 8.2) ** 2 + 10 * (y - x / 10) ** 2 + (count - 8) ** 2 / 4

    own_quantities("stepped_valley", function)
    own_quantities("lead_in_mm", lambda a: _numbers(a)[0] + 0 * _numbers(a)[1])


def test_the_best_of_all_combinations(valley):
    best = optimise(
        scenes.frictionless(),
        ANGLE,
        minimise="stepped_valley",
        choices={"lead": [5e-3, 8e-3, 10e-3], "roller_count": range(7, 10)},
    )
    assert best.converged, str(best)
    stage = best.mechanism.stages[0]
    assert (float(stage.thread.lead), stage.roller_count) == (8e-3, 8)
    assert best.optimum.objective == pytest.approx(0.04, abs=1e-9)
    assert best.optimum.variables["contact_angle"] == pytest.approx(0.8, abs=1e-5)
    # Every combination has the value of its own minimum over the angle.
    assert len(best.choices) == 9
    for one in best.choices:
        lead, count = one.choices["lead"] * 1e3, one.choices["roller_count"]
        assert one.objective == pytest.approx((lead - 8.2) ** 2 + (count - 8) ** 2 / 4, abs=1e-8)
        assert one.variables == {"contact_angle": pytest.approx(lead / 10, abs=1e-4)}
        assert one.kkt_residual <= 1e-6
        assert one.status == ("best" if (lead, count) == (8, 8) else "worse")
    worst = next(one for one in best.choices if one.choices == {"lead": 5e-3, "roller_count": 7})
    assert worst.message == "objective 10.49, against 0.04 of the best"
    assert (
        json.loads(json.dumps(best.to_dict(), allow_nan=False))["choices"][0]["status"] == "worse"
    )
    assert "lead = 5 mm, roller_count = 7: worse: objective 10.49" in str(best)


def test_the_best_of_a_maximised_objective(valley, own_quantities):
    """The greatest value wins, and the message of a worse one names it."""

    def function(analysis):
        x, y, _ = _numbers(analysis)
        return 5 + x - (y - x / 10) ** 2

    own_quantities("hill", function)
    best = optimise(
        scenes.frictionless(), ANGLE, maximise="hill", choices={"lead": [5e-3, 10e-3, 8e-3]}
    )
    assert [one.status for one in best.choices] == ["worse", "best", "worse"]
    assert best.optimum.objective == pytest.approx(15.0, abs=1e-9)
    assert "against 15 of the best" in best.choices[0].message


def test_choices_that_only_go_together(valley):
    """A bore of 13 mm radius needs a wider screw than the present one of 12 mm."""
    both = {"screw.bore_radius": [1e-3, 13e-3], "roller_radius": [4e-3, 8e-3]}
    best = optimise(
        scenes.frictionless(screw=Screw(mass=0.76, inertia=1.7e-4, bore_radius=1e-3)),
        ANGLE,
        minimise="stepped_valley",
        choices=both,
        respect_findings=False,
    )
    status = {tuple(one.choices.values()): one.status for one in best.choices}
    assert status[13e-3, 4e-3] == "cannot be built"
    assert [name for name, one in status.items() if one == "cannot be built"] == [(13e-3, 4e-3)]
    dropped = next(one for one in best.choices if one.status == "cannot be built")
    assert "bore" in dropped.message


def test_an_error_of_the_search_is_no_choice_that_cannot_be_built(valley):
    with pytest.raises(ValueError, match=r"^(?!none of).*tolerance"):
        optimise(
            scenes.frictionless(),
            ANGLE,
            minimise="stepped_valley",
            choices={"lead": [5e-3, 8e-3]},
            tolerance=2.0,
        )


def test_what_breaks_a_limit_is_dropped_with_its_reason(valley):
    best = optimise(
        scenes.frictionless(),
        ANGLE,
        minimise="stepped_valley",
        constraints={"lead_in_mm": (None, 7.0)},
        choices={"lead": [5e-3, 8e-3, 10e-3]},
        # A limit that no angle changes stays broken, for as many iterations as there may be.
        method=Slsqp(max_iterations=20),
    )
    assert [one.status for one in best.choices] == ["best", "infeasible", "infeasible"]
    assert "lead_in_mm = 8" in best.choices[1].message
    assert best.feasible
    assert float(best.mechanism.stages[0].thread.lead) == 5e-3


def test_a_combination_with_an_error_of_check_is_dropped(valley):
    """Twenty rollers overlap: an error of `check` that the angle does not change."""
    best = optimise(
        scenes.frictionless(), ANGLE, minimise="stepped_valley", choices={"roller_count": [8, 20]}
    )
    assert [one.status for one in best.choices] == ["best", "infeasible"]
    assert "none of the variables changes the error" in best.choices[1].message


def test_the_file_has_choices(tmp_path):
    mechanism = scenes.example("actuator")
    text = file.dumps(mechanism)
    line = 'choices = { roller_count = [9, 10], "gear.roller_teeth" = [16, 18] }\npoints = 7\n'
    start = text.index("[optimise]\n") + len("[optimise]\n")
    read = file.loads(text[:start] + line + text[start:])
    problem = read.design_problem
    assert problem is not None
    assert problem.choices == (
        Choice("roller_count", (9.0, 10.0)),
        Choice("gear.roller_teeth", (16.0, 18.0)),
    )
    assert problem.points == 7
    assert file.loads(file.dumps(read)).design_problem == problem
    for wrong, words in (
        ("choices = { roller_count = [9, 9] }", "lists a value twice"),
        ("choices = { roller_count = [8.5] }", "whole number"),
        ("choices = { roller_count = 9 }", "must be a list"),
        ("choices = { lead = [0.01] }", "moves the same number as 'lead'"),
        ("choices = { leed = [0.01] }", "did you mean lead"),
        ("choices = 3", "must be a table of lists"),
    ):
        with pytest.raises(ValueError, match=words):
            file.loads(text[:start] + wrong + "\n" + text[start:])


@pytest.mark.parametrize(
    ("choices", "words"),
    [
        ({"lead": []}, "no values"),
        ({"lead": 5e-3}, "give a list of numbers"),
        ({"lead": [5e-3, 5e-3]}, "lists a value twice"),
        ({"roller_count": [7.5]}, "must be a whole number"),
        ({"roller_count": [np.inf]}, "lists inf; give finite"),
        ({"roller_count": "12"}, "give a list of numbers"),
        ({"contact_angle": [0.5]}, "given twice; remove one"),
        ({"leed": [5e-3]}, "did you mean lead"),
        ({"lead": np.linspace(1e-3, 2e-3, 1001)}, "1001 combinations"),
        ({"lead": [-1.0]}, "none of the 1 choices can be built"),
    ],
)
def test_errors_name_the_thing(unchecked, valley, choices, words):
    with pytest.raises(ValueError, match=words):
        optimise(scenes.frictionless(), ANGLE, minimise="stepped_valley", choices=choices)


@pytest.fixture
def geared(own_quantities):
    """A mechanism of a gear, and (r_R / mm − 4.3)² + (y − r_R / (5 mm))² of its contact angle y."""

    def function(analysis):
        thread = analysis.mechanism.stages[0].thread
        radius = thread.roller_radius * 1e3
        return (radius - 4.3) ** 2 + (thread.contact_angle - radius / 5) ** 2

    own_quantities("roller_of_4_3", function)
    return scenes.mechanism(scenes.stage(gear=Gear(np.radians(20), roller_teeth=16.0)))


def test_standard_modules_with_numbers_of_teeth(geared):
    """r_R = m z_R / 2: of 4 pairs 0.45 mm with 19 teeth is nearest to 4.3 mm, at 4.275 mm."""
    best = optimise(
        geared,
        ANGLE,
        minimise="roller_of_4_3",
        choices={"gear_module": standard_modules(0.45e-3, 0.5e-3), "roller_teeth": [17, 19]},
        respect_findings=False,
    )
    assert best.converged, str(best)
    assert len(best.choices) == 4
    for one in best.choices:
        radius = one.choices["gear_module"] * 1e3 * one.choices["roller_teeth"] / 2
        assert one.objective == pytest.approx((radius - 4.3) ** 2, abs=1e-9)
    (stage,) = best.mechanism.stages
    assert stage.gear is not None
    assert stage.gear.roller_teeth == 19
    assert stage.gear_module == pytest.approx(0.45e-3, rel=1e-15)
    assert stage.thread.roller_radius == pytest.approx(4.275e-3, rel=1e-15)


def test_a_module_is_no_choice_where_the_teeth_vary(geared):
    with pytest.raises(ValueError, match="'gear_module' moves again when 'roller_teeth' is set"):
        optimise(
            geared,
            {"roller_teeth": (16.0, 20.0)},
            minimise="roller_of_4_3",
            choices={"gear_module": [0.4e-3, 0.5e-3]},
        )


def test_a_front_refuses_open_choices(valley):
    problem = DesignProblem(
        (Variable("contact_angle", 0.3, 1.3),),
        (Objective("stepped_valley"), Objective("lead_in_mm")),
        choices=(Choice("lead", (5e-3, 8e-3)),),
    )
    with pytest.raises(ValueError, match="has choices of lead"):
        pareto(scenes.frictionless(), problem=problem)


def test_numbers_of_rollers_share_a_program(valley, monkeypatch):
    """As many traces for five numbers of rollers as for two, and the results of one by one."""
    traced = []
    whole = _outputs.outputs_at

    def counted(inputs, position):
        traced.append(inputs[0].stages[0].roller_count)
        return whole(inputs, position)

    monkeypatch.setattr(_outputs, "outputs_at", counted)
    arguments = {"minimise": "stepped_valley", "constraints": {"lead_in_mm": (None, 20.0)}}
    counts = [3, 6, 7, 9, 12]
    best = optimise(scenes.frictionless(), ANGLE, choices={"roller_count": counts}, **arguments)
    # Of a traced number once, of three rollers once: with derivatives, in one program.
    assert [isinstance(one, int) for one in traced] == [True, False]
    for count, one in zip(counts, best.choices, strict=True):
        assert one.choices == {"roller_count": count}
        assert one.objective == pytest.approx(1.8**2 + (count - 8) ** 2 / 4, abs=1e-8)
    alone = optimise(scenes.frictionless(roller_count=9), ANGLE, **arguments)
    assert best.optimum.variables == pytest.approx(alone.optimum.variables, rel=1e-9)
    assert best.mechanism.stages[0].roller_count == 7
    assert isinstance(best.mechanism.stages[0].roller_count, int)


def test_a_quantity_that_needs_the_number_itself(own_quantities):
    """A sum over range(N) has no program for a traced number: each number has its own."""

    def function(analysis):
        _, y, count = _numbers(analysis)
        return sum((y - 0.1 * k) ** 2 for k in range(count))

    own_quantities("sum_over_rollers", function)
    best = optimise(
        scenes.frictionless(),
        ANGLE,
        minimise="sum_over_rollers",
        choices={"roller_count": [9, 11]},
        respect_findings=False,
    )
    # The mean of 0 to 0.8 and of 0 to 1.0.
    for one, mean in zip(best.choices, (0.4, 0.5), strict=True):
        assert one.variables == {"contact_angle": pytest.approx(mean, abs=1e-6)}
