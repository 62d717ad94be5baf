"""Findings: each appears when it should, with the numbers that it names, and only then."""

import math
from typing import Any

import equinox as eqx
import numpy as np
import pytest
from scenes import array, equal_shares, example, stage, thread

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.findings import Margin, _margin
from prsm_jax.geometry import roller_clearance
from prsm_jax.mechanism import (
    AxialPlay,
    Gear,
    LoadSharing,
    Roller,
    Screw,
    ScrewShaft,
    Strength,
)


def _findings(one):
    return {finding.name: finding for finding in prsm.check(prsm.Mechanism((one,)))}


def test_another_source_is_another_program(monkeypatch):
    """One source in place of another: there are as many as before, and other margins."""

    def source(*names):
        def margins(mechanism, index):
            for name in names:
                value = lambda analysis: -analysis.mechanism.stages[index].thread.lead  # noqa: E731
                yield Margin(name, index + 1, value, (("warning", 0.0),), lambda _: "too long")

        return margins

    known = list(_margin._SOURCES)
    for names in (("one",), ("two", "three")):
        monkeypatch.setattr(_margin, "_SOURCES", [*known, source(*names)])
        found = _findings(stage(sharing="equal"))
        assert set(names) <= set(found)
        assert not ({"one", "two", "three"} - set(names)) & set(found)


def test_sound_mechanism_has_only_the_note_on_tooth_thickness():
    screw = Screw(mass=0.76, inertia=0.5 * 0.76 * 12e-3**2)
    found = _findings(stage(screw=screw, sharing="equal"))
    assert set(found) == {"tooth_thickness"}
    assert found["tooth_thickness"].severity == "note"


def test_feasible_ratio():
    found = _findings(stage(geometry=thread(starts=4.6), roller_count=5))["feasible_ratio"]
    assert found.severity == "error"
    assert found.value == pytest.approx(4.6)
    assert found.limit == 5
    assert "4.6" in found.message


def test_ratio_derived_from_radii_is_not_refused_for_its_rounding():
    assert "feasible_ratio" not in _findings(stage(geometry=thread(starts=5 * (1 + 1e-15))))


def test_roller_clearance():
    """2 a sin(π/N) against 2 r_R: with a = 4 r_R twelve rollers fit, thirteen do not."""
    fits, touches = stage(12), stage(13)
    assert "roller_clearance" not in _findings(fits)
    found = _findings(touches)["roller_clearance"]
    assert found.severity == "error"
    assert found.value == pytest.approx(2 * 16e-3 * np.sin(np.pi / 13) - 8e-3, rel=1e-12)
    assert float(roller_clearance(fits)) > 0
    taller = stage(12, geometry=thread(roller_addendum=0.4e-3))
    expected = float(roller_clearance(fits)) - 0.8e-3
    assert float(roller_clearance(taller)) == pytest.approx(expected, rel=1e-12)
    assert "roller_clearance" in _findings(taller)


@pytest.mark.parametrize(
    ("teeth", "count", "severity"), [(16.0, 10, None), (16.0, 7, "note"), (16.5, 10, "error")]
)
def test_gear_assembly(teeth, count, severity):
    gear = Gear(np.radians(20), roller_teeth=teeth)
    found = _findings(stage(count, gear=gear)).get("gear_assembly")
    assert (found.severity if found else None) == severity
    if severity == "note":
        # 80 teeth over 7 rollers leave 3/7 of a tooth.
        assert "3/7" in found.message


def test_meshing():
    """A profile far flatter than r_R / sin α never gets as steep as the screw's helix asks."""
    flat = thread(lead=100e-3, roller_profile_radius=0.2)
    found = _findings(stage(geometry=flat))["meshing"]
    assert found.severity == "error"
    assert found.value == pytest.approx(0.2)


def test_contact_on_flank():
    """The contact lies 0.055 mm (screw) and 0.011 mm (roller) above the nominal radii."""
    low = stage(geometry=thread(screw_addendum=0.05e-3, roller_addendum=0.02e-3))
    found = _findings(low)["contact_on_flank"]
    assert found.severity == "warning"
    assert "screw" in found.message
    assert found.value == pytest.approx(12.055213e-3, abs=1e-9)
    high = stage(geometry=thread(screw_addendum=0.06e-3, roller_addendum=0.02e-3))
    assert "contact_on_flank" not in _findings(high)


def test_findings_name_their_stage():
    good, bad = stage(), stage(13)
    found = prsm.check(prsm.Mechanism((good, bad)))
    assert [f.stage for f in found if f.name == "roller_clearance"] == [2]


@pytest.mark.parametrize("name", file.example_names())
def test_shipped_examples_can_be_built(name):
    """No errors; rollers of rings have no thread whose starts would have to be whole."""
    assert not [f.name for f in prsm.check(example(name)) if f.severity == "error"]


def test_check_never_raises_on_a_broken_design():
    broken = eqx.tree_at(lambda t: t.lead, thread(), array(0.4))
    assert isinstance(prsm.check(prsm.Mechanism((stage(geometry=broken),))), tuple)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("lead", -0.01, "lead is -0.01 m; it must be more than 0"),
        ("starts", 1.5, "starts is 1.5; it must be more than 2"),
        ("roller_radius", 0.0, "roller_radius is 0 m; it must be more than 0"),
        ("contact_angle", 45.0, "contact_angle is 45 rad; it must be between 0 and pi/2"),
        ("contact_angle", float("nan"), "contact_angle is nan rad"),
    ],
)
def test_dimensions_out_of_range(name, value, words):
    """Set past the checks of construction, as a trace would set them."""
    broken = eqx.tree_at(lambda t: getattr(t, name), thread(), array(value))
    found = _findings(stage(geometry=broken))["dimension"]
    assert found.severity == "error"
    assert words in found.message


@pytest.mark.parametrize(
    ("lead", "found"), [(10e-3, False), (2.5e-3, False), (11.2067e-3, True), (10.005e-3, False)]
)
def test_unusual_lead(lead, found):
    one = _findings(stage(geometry=thread(lead=lead)))
    assert ("unusual_lead" in one) == found
    if found:
        assert one["unusual_lead"].severity == "note"
        assert "11.207 mm" in one["unusual_lead"].message
        assert "nearest: 10 or 12 mm" in one["unusual_lead"].message
        assert one["unusual_lead"].limit == pytest.approx(12e-3)


@pytest.mark.parametrize(("radius", "found"), [(4e-3, False), (3.8e-3, True), (3.6e-3, False)])
def test_unusual_module(radius, found):
    """m = 2 r_R / 16: 0.5 and 0.45 mm are in DIN 780, 0.475 mm is not."""
    one = _findings(
        stage(geometry=thread(roller_radius=radius), gear=Gear(np.radians(20), roller_teeth=16.0))
    )
    assert ("unusual_module" in one) == found
    if found:
        assert "0.475 mm" in one["unusual_module"].message
        assert "0.45 or 0.5 mm" in one["unusual_module"].message


@pytest.mark.parametrize(
    ("play", "shared", "names"),
    [
        (None, None, {"tooth_thickness"}),
        (AxialPlay(preload_force=1e3), None, {"tooth_thickness"}),
        # 0.08236 mm is what half a pitch lacks on a flank of the screw and of the rollers.
        ({"screw_tooth_thinning": 0.1e-3, "roller_tooth_thinning": 0.05e-3}, None, set()),
        ({"screw_tooth_thinning": 0.01e-3}, None, {"backlash"}),
        (AxialPlay(axial_backlash=30e-6), None, set()),
        (AxialPlay(preload_force=1e3, screw_tooth_thinning=0.2e-3), None, set()),
        (None, 30e-6, set()),
    ],
    ids=[
        "bare",
        "preloaded",
        "thinned",
        "not enough",
        "measured",
        "preloaded and thinned",
        "shared",
    ],
)
def test_advice_to_thin_teeth_only_where_nothing_is_known_of_them(play, shared, names):
    """`thin the teeth by at least 0.054 mm` is no advice for teeth that are thinned by more."""
    play = AxialPlay(**play) if isinstance(play, dict) else play
    given: dict[str, Any] = {} if play is None else {"strength": Strength(play=play)}
    if shared is not None:
        given["load_sharing"] = LoadSharing(20, backlash=shared)
    found = _findings(stage(**given))
    assert names == {"tooth_thickness", "backlash"} & set(found)
    if "tooth_thickness" in names:
        assert "thin the teeth by at least this amount" in found["tooth_thickness"].message


def test_no_advice_for_the_shipped_actuator():
    """It gives the thinning, and its play is positive."""
    names = {f.name for f in prsm.check(example("actuator"))}
    assert not names & {"tooth_thickness", "backlash"}
    (play,) = prsm.compute(example("actuator"), ["axial_backlash"])["axial_backlash"]
    assert float(play) > 0


@pytest.mark.parametrize("body", ["screw", "roller"])
def test_a_bore_wider_than_its_body(body):
    """Set past the checks of construction: 11 of 12 mm are left, 12 and 13 of 12 are none."""
    bodies = {"screw": (Screw, 12e-3), "roller": (Roller, 4e-3)}
    kind, radius = bodies[body]
    good = stage(**{body: kind(mass=1.0, inertia=1e-4, bore_radius=0.9 * radius)})
    assert "bore" not in _findings(good)
    for factor in (1.0, 1.1):
        place = lambda s: getattr(s, body).bore_radius  # noqa: E731
        broken = eqx.tree_at(place, good, array(factor * radius))
        found = _findings(broken)["bore"]
        assert (found.severity, found.impossible) == ("error", True)
        assert (found.value, found.limit) == pytest.approx((factor * radius, radius))
        assert f"stage.{body}.bore_radius is {1e3 * factor * radius:.6g} mm" in found.message


def test_a_bore_wider_than_the_root_of_the_shaft():
    shaft = ScrewShaft("fixed_supported", unsupported_length=0.3, root_radius=11e-3)
    good = stage(
        screw=Screw(mass=0.7, inertia=1e-4, bore_radius=10e-3), strength=Strength(shaft=shaft)
    )
    assert "bore" not in _findings(good)
    found = _findings(eqx.tree_at(lambda s: s.screw.bore_radius, good, array(11.5e-3)))["bore"]
    assert (found.value, found.limit) == pytest.approx((11.5e-3, 11e-3))


@pytest.mark.parametrize("speed", ["1200 rpm", "0 rpm", "-1200 rpm"])
def test_without_a_load_nothing_is_held(speed):
    """No self-locking, and no efficiency of work that is 0; under the least load both are there.

    A drag of 0.2 N·m holds 1 N at a lead of 10 mm, whose torque is 0.0016 N·m.
    """
    settings = ["friction.drag.torque=0.2 N m", f"speed={speed}"]
    for load in (0, 1):
        mechanism = file.apply_settings(equal_shares("actuator"), [*settings, f"load={load} N"])
        names = {one.name for one in prsm.check(mechanism)}
        assert ("self_locking" in names) == (load > 0)
        (row,) = (one for one in prsm.strength_checks(mechanism) if one.name == "self_locking")
        assert math.isnan(row.value) == (load == 0)
        assert (row.verdict, row.limit, row.margin) == ("no limit", None, None)
