"""Warnings of `check` as constraints: `avoid_warnings`."""

from typing import Any

import numpy as np
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.findings import margins_of
from prsm_jax.mechanism import Gear, Nut, Roller
from prsm_jax.optimisation import optimise, pareto
from prsm_jax.optimisation.search._margin_rows import respected, sorted_margins


def _mechanism(**more: Any):
    """Twenty threads of 2 mm pitch; between its gears a roller has 50 − 2 × 6 mm, 19 pitches."""
    parts: dict[str, Any] = {
        "roller": Roller(mass=0.03, inertia=4e-7, length=50e-3),
        "nut": Nut(mass=2.2, inertia=9e-4),
        "gear": Gear(np.radians(20), roller_teeth=16, face_width=6e-3),
        "sharing": "equal",
    }
    return scenes.frictionless(**(parts | more))


def _warnings(mechanism):
    """All but those on masses and inertias of this scene, which are made up."""
    found = [f.name for f in prsm.check(mechanism) if f.severity == "warning"]
    return [name for name in found if name not in ("mass", "inertia")]


def test_a_search_stops_where_the_first_warning_begins():
    """19 pitches of five starts in 38 mm: a lead of 10 mm, less a micrometre of the length."""
    start, bounds = _mechanism(), {"lead": (5e-3, 20e-3)}
    usual = optimise(start, bounds, maximise="nut_speed")
    # The error begins later, where the roller is shorter than its threads.
    assert usual.optimum.variables["lead"] > 12.49e-3
    assert "thread_length" in _warnings(usual.mechanism)
    assert "--avoid-warnings, or avoid_warnings in [optimise]" in str(usual)

    best = optimise(start, bounds, maximise="nut_speed", avoid_warnings=True)
    assert best.feasible
    assert best.converged, str(best)
    assert best.optimum.variables["lead"] == pytest.approx(5 * (38e-3 - 1e-6) / 19, rel=1e-9)
    assert _warnings(best.mechanism) == []
    assert best.problem.avoid_warnings
    (active,) = [one for one in best.margins if one.active]
    assert active.name == "thread_length of roller, warning (stage 1)"
    assert "avoid-warnings" not in str(best)


def test_a_front_avoids_them_too():
    front = pareto(
        _mechanism(),
        {"nut_speed": "maximise", "nut_radius": "minimise"},
        {"lead": (5e-3, 20e-3), "roller_radius": (3e-3, 5e-3)},
        points=3,
        avoid_warnings=True,
    )
    assert front.points
    assert max(one.variables["lead"] for one in front.points) == pytest.approx(10e-3, rel=1e-4)


def test_warnings_of_the_file_prevent_no_search():
    """The length of the roller does not follow the radius: nobody can repair it on the way."""
    start = _mechanism(roller=Roller(mass=0.03, inertia=4e-7, length=45e-3))
    assert _warnings(start) == ["thread_length"]
    bounds = {"roller_radius": (3e-3, 5e-3)}
    best = optimise(start, bounds, minimise="nut_radius", avoid_warnings=True)
    assert best.feasible
    assert best.optimum.variables["roller_radius"] == pytest.approx(3e-3)
    assert _warnings(best.mechanism) == ["thread_length"]


def test_a_gear_that_does_not_match_prevents_no_search():
    """Only an exact match avoids its warning, whatever the lead."""
    gear = Gear(np.radians(20), roller_teeth=16, ring_teeth=81, face_width=6e-3)
    start = _mechanism(gear=gear)
    assert "gear_mismatch" in _warnings(start)
    best = optimise(start, {"lead": (5e-3, 20e-3)}, maximise="nut_speed", avoid_warnings=True)
    assert best.feasible
    assert best.optimum.variables["lead"] == pytest.approx(5 * (38e-3 - 1e-6) / 19, rel=1e-9)


def test_an_error_that_no_variable_changes_is_no_warning():
    """`buckling` has a limit of each; the message names the error."""
    (margin,) = (m for m in margins_of(scenes.example("actuator")) if m.name == "buckling")
    kept = respected(warnings=True)
    found = sorted_margins((margin,), np.full((3, 1), -0.5), kept)
    ((row, value),) = found.fixed
    assert (row.label, value) == ("buckling (stage 1)", -0.5)
    # Constant and above 0, it is a warning of the file.
    assert sorted_margins((margin,), np.full((3, 1), 0.3), kept).fixed == ()


def test_a_warning_between_two_limits_is_no_constraint():
    """Self-locking is no fault: a search must not leave it to avoid being nearly self-locking."""
    mechanism = scenes.example("actuator")
    both, errors = respected(warnings=True), respected(warnings=False)
    limits = {
        (one.name, one.subject): (errors.limit(one), both.limit(one))
        for one in margins_of(mechanism)
    }
    assert limits["self_locking", ""] == (None, None)
    # An error and a warning on the same side: the stricter one holds.
    assert limits["jamming", ""] == (0.0, 0.3)
    assert limits["rating_life", ""] == (None, 0.0)
    # Notes are for information.
    assert limits["unusual_lead", ""] == (None, None)


def test_a_design_that_is_not_checked_has_no_warnings_to_avoid():
    with pytest.raises(ValueError, match="avoid_warnings is True and respect_findings False"):
        optimise(
            _mechanism(),
            {"lead": (5e-3, 20e-3)},
            maximise="nut_speed",
            avoid_warnings=True,
            respect_findings=False,
        )


def test_the_file_says_so():
    text = file.dumps(scenes.example("actuator"))
    assert "avoid_warnings" not in text
    read = file.loads(text.replace("[optimise]\n", "[optimise]\navoid_warnings = true\n"))
    assert read.design_problem is not None
    assert read.design_problem.avoid_warnings is True
    assert file.loads(file.dumps(read)).design_problem == read.design_problem
    with pytest.raises(prsm.FileError, match="avoid_warnings"):
        file.loads(text.replace("[optimise]\n", "[optimise]\navoid_warnings = 1\n"))
