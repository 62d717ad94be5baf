"""Every analysis verb says what its numbers rest on: in the JSON, and beneath its tables."""

import dataclasses

import pytest
import scenes

import prsm_jax as prsm
from prsm_jax import file

EQUAL = "All engaged threads of all rollers carry the same load"
#: Verbs with the least that they need, and the quantities behind what they print.
VERBS = {
    "check": ((), None),
    "contact": ((), ["max_pressure"]),
    "modal": ((), ["natural_frequencies"]),
    "response": (("--points", "3"), ["natural_frequencies"]),
    "campbell": ((), ["natural_frequencies", "carrier_ratio"]),
    "steady": ((), ["efficiency"]),
    "simulate": (("--samples", "3"), ["efficiency"]),
    "sensitivity": (
        ("--quantities", "max_pressure", "--parameters", "lead"),
        ["max_pressure"],
    ),
    "optimise": ((), ["max_pressure"]),
    "pareto": (
        ("--minimise", "max_pressure", "--maximise", "efficiency", "--points", "3"),
        ["efficiency", "max_pressure"],
    ),
    # One number: of a screw that was not measured, all of them end where a friction vanishes.
    "calibrate": (
        (
            "--data",
            "wu2022_torque",
            "--loss",
            "squared",
            "--parameters",
            "friction.thread.coefficient",
        ),
        ["drive_torque"],
    ),
    "sweep": (("--axis", "lead=9 mm,10 mm", "--quantities", "max_pressure"), ["max_pressure"]),
    "tolerance": (
        ("--quantities", "max_pressure", "--method", "first_order"),
        ["max_pressure"],
    ),
}


@pytest.fixture(scope="module")
def design(tmp_path_factory):
    """The path of a design whose threads share equally without a word on it."""
    mechanism = scenes.example("actuator")
    stage = dataclasses.replace(mechanism.stages[0], load_sharing=None)
    problem = prsm.mechanism.DesignProblem(
        (prsm.mechanism.Variable("lead", 9e-3, 11e-3),),
        (prsm.mechanism.Objective("max_pressure", "minimise"),),
    )
    mechanism = dataclasses.replace(
        mechanism,
        stages=(stage,),
        duty_cycle=None,
        design_problem=problem,
        tolerances=(prsm.mechanism.Tolerance("lead", -1e-5, 1e-5),),
    )
    path = tmp_path_factory.mktemp("design") / "design.toml"
    path.write_text(file.dumps(mechanism), encoding="utf-8")
    return path


@pytest.mark.parametrize("verb", VERBS)
def test_the_json_of_every_verb_has_the_assumptions(prsm_json, design, verb):
    options, quantities = VERBS[verb]
    found = prsm_json(verb, design, *options)["assumptions"]
    assert found == list(prsm.assumptions(file.load(design), quantities))
    assert any(EQUAL in sentence for sentence in found)


def test_they_stand_beneath_the_table(prsm, design):
    _, out, _ = prsm("contact", design)
    table, _, below = out.partition("\nAssumptions\n")
    assert "Thread contacts" in table
    assert EQUAL in " ".join(below.split())
    assert max(len(line) for line in below.splitlines()) <= 80


def test_nothing_stands_there_where_nothing_is_assumed(prsm, prsm_json):
    assert prsm_json("steady", "wu2022")["assumptions"] == []
    assert "Assumptions" not in prsm("steady", "wu2022")[1]
