"""What `check` calls an error, the optimiser avoids without being told."""

import json

import numpy as np
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax.mechanism import AxialPlay, Gear, Screw, Strength
from prsm_jax.optimisation import optimise

#: A solid cylinder of 12 mm radius: no finding.
SCREW = Screw(mass=0.76, inertia=0.5 * 0.76 * 12e-3**2)


def _errors(mechanism):
    return [f.name for f in prsm.check(mechanism) if f.severity == "error"]


def test_neighbouring_rollers_stay_apart():
    """The clearance of 12 rollers of 5 starts is 2 r (4 sin 15° − 1) less the addenda."""
    thread = scenes.thread(roller_radius=10e-3, roller_addendum=0.3e-3)
    start = scenes.mechanism(scenes.stage(12, geometry=thread))
    best = optimise(start, {"roller_radius": (4e-3, 12e-3)}, minimise="nut_radius_of_stage")
    assert best.feasible
    assert best.converged, str(best)
    gap = 2 * (4 * np.sin(np.pi / 12) - 1)
    expected = (0.6e-3 + 1e-6) / gap  # a micrometre more than touching
    assert best.optimum.variables["roller_radius"] == pytest.approx(expected, rel=1e-9)
    assert _errors(best.mechanism) == []
    (margin,) = [m for m in best.margins if m.name == "roller_clearance (stage 1)"]
    assert margin.active
    # d(5 r_R)/d gap: what a wider gap would cost.
    assert margin.multiplier == pytest.approx(5 / gap, rel=1e-6)
    assert "check: roller_clearance (stage 1)" in str(best)

    free = optimise(
        start,
        {"roller_radius": (4e-3, 12e-3)},
        minimise="nut_radius_of_stage",
        respect_findings=False,
    )
    assert free.bounds_active == {"roller_radius": "lower"}
    assert _errors(free.mechanism) == ["roller_clearance"]
    assert not free.margins


@pytest.fixture(autouse=True)
def _radius(own_quantities):
    own_quantities("nut_radius_of_stage", lambda a: a.mechanism.stages[0].thread.nut_radius)
    own_quantities("lead_mm", lambda a: a.mechanism.stages[0].thread.lead * 1e3)
    own_quantities("starts_off", lambda a: (a.mechanism.stages[0].thread.starts - 5.3) ** 2 + 1.0)


def test_teeth_keep_their_play():
    """A longer lead eats the play that thinning leaves; the search stops a micrometre before."""
    play = AxialPlay(screw_tooth_thinning=0.08e-3, roller_tooth_thinning=0.05e-3)
    start = scenes.mechanism(scenes.stage(screw=SCREW, strength=Strength(play=play)))
    best = optimise(start, {"lead": (5e-3, 20e-3)}, maximise="lead_mm")
    assert best.converged, str(best)
    found = prsm.compute(best.mechanism, ["axial_backlash"])["axial_backlash"]
    assert float(found[0]) == pytest.approx(1e-6, abs=1e-10)
    assert _errors(best.mechanism) == []
    longer = prsm.set_parameter(best.mechanism, "lead", best.optimum.variables["lead"] * 1.01)
    assert _errors(longer) == ["backlash"]
    assert not [f for f in best.findings_start if f.severity != "note"]


def test_starts_become_whole():
    """(n − 5.3)² is least at 5 among whole numbers; 5.3 is no mechanism."""
    start = scenes.mechanism(scenes.stage(5))
    best = optimise(start, {"starts_at_fixed_pitch": (3.2, 8.7)}, minimise="starts_off")
    assert best.feasible, str(best)
    assert best.optimum.variables["starts_at_fixed_pitch"] == pytest.approx(5.0, abs=1e-7)
    assert best.optimum.objective == pytest.approx(1.09, abs=1e-6)
    assert _errors(best.mechanism) == []
    # The relaxed search comes first, then one for each of 5 and 6.
    ends = [run.end.variables["starts_at_fixed_pitch"] for run in best.runs]
    np.testing.assert_allclose(sorted(ends), [5, 5.3, 6], atol=1e-3)


@pytest.mark.parametrize(
    ("one", "name"),
    [
        (lambda: scenes.stage(13), "roller_clearance"),
        (lambda: scenes.stage(gear=Gear(np.radians(20), roller_teeth=16.5)), "gear_assembly"),
    ],
)
def test_an_error_that_no_variable_changes_is_said_first(one, name):
    best = optimise(scenes.mechanism(one()), {"lead": (5e-3, 12e-3)}, maximise="lead_mm")
    assert not best.feasible
    assert not best.converged
    first, *rest = str(best).splitlines()
    assert first.startswith("NO FEASIBLE DESIGN: ")
    assert f"{name} (stage 1)" in first
    assert "best found" in rest[0]
    assert "optimum" not in rest[0]
    plain = best.to_dict()
    assert plain["feasible"] is False
    assert [f["name"] for f in plain["findings_start"] if f["severity"] == "error"] == [name]
    assert [f["name"] for f in plain["findings_optimum"] if f["severity"] == "error"] == [name]
    json.dumps(plain, allow_nan=False)


def test_warnings_of_both_designs_are_reported():
    """The contact leaves the thread's crest at a longer lead: a warning, which is no limit."""
    low = scenes.thread(lead=5e-3, screw_addendum=0.05e-3)
    start = scenes.mechanism(scenes.stage(screw=SCREW, geometry=low))
    best = optimise(start, {"lead": (5e-3, 12e-3)}, maximise="lead_mm")
    assert best.bounds_active == {"lead": "upper"}
    starts = {f.name for f in best.findings_start if f.severity == "warning"}
    ends = {f.name for f in best.findings_optimum if f.severity == "warning"}
    # The crest is that near that ellipses are cut from the first, and at the end the contact is
    # beyond it; the mechanism has no other warnings.
    assert (starts, ends) == ({"contact_truncation"}, {"contact_truncation", "contact_on_flank"})
    told = [line for line in str(best).splitlines() if line.startswith("prsm check of the ")]
    first, counted, *new = (line.removeprefix("prsm check of the ") for line in _in_order(told))
    # Warnings of the file are counted: both sides of the screw's crest, and of the nut's.
    count = sum(f.name == "contact_truncation" for f in best.findings_start)
    assert count > 1
    assert first == f"start: warnings: contact_truncation ({count})"
    count = sum(f.name == "contact_truncation" for f in best.findings_optimum)
    assert counted == f"optimum: warnings as at the start: contact_truncation ({count})"
    # Those of the optimum alone are told in full.
    messages = [f.message for f in best.findings_optimum if f.name == "contact_on_flank"]
    assert new == [f"optimum: warning contact_on_flank, stage 1: {text}" for text in messages]


def _in_order(lines):
    """Those that count first, each design in turn."""
    return sorted(lines, key=lambda line: ("start" not in line[:25], ": warnings" not in line))
