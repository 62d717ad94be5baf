"""Impossible, locked and jammed mechanisms say what they are, in every verb."""

import json

import numpy as np
import pytest
import scenes

import prsm_jax
from prsm_jax import file

#: Verbs with the least that they need.
VERBS = {
    "contact": (),
    "modal": (),
    "response": ("--points", "3"),
    "campbell": (),
    "steady": (),
    "simulate": ("--samples", "3"),
    "sensitivity": ("--quantities", "efficiency", "--parameters", "lead"),
}


@pytest.mark.parametrize("verb", VERBS)
def test_overlapping_rollers_are_not_analysed_as_if_nothing_were_wrong(prsm, verb):
    status, out, err = prsm(
        verb, "actuator", *VERBS[verb], "--set", "roller_count=13", "--json", "-"
    )
    results = json.loads(out)
    assert status == 1
    assert results["valid"] is False
    assert "roller_clearance" in results["findings"]
    assert "prsm: error found by check: roller_clearance, stage 1: 13 neighbouring" in err


def test_a_sound_mechanism_is_valid(prsm_json):
    results = prsm_json("steady", "actuator")
    assert results["valid"] is True
    assert results["result"] == "successful"
    names = {f.name for f in prsm_jax.check(scenes.example("actuator")) if f.severity != "note"}
    assert set(results["findings"]) == names


def test_findings_stand_beneath_the_table(prsm):
    status, out, err = prsm("steady", "wu2022")
    assert (status, err) == (0, "")
    assert "prsm check finds warnings: inertia (4), torsional_support" in " ".join(out.split())
    status, out, err = prsm("steady", "actuator", "--set", "roller_count=13")
    assert status == 1
    assert "prsm check finds errors: roller_clearance" in out
    assert "Not valid: overlapping rollers" in out
    assert "13 neighbouring rollers overlap by 1.142 mm" in err


@pytest.mark.parametrize(
    ("settings", "name", "words", "status"),
    [
        # μ cot α > 1: no torque moves the load.
        (["friction.thread.coefficient=1.5"], "jammed", "no torque moves", 1),
        # μ > tan α at a contact angle of 60°: the load does not turn the screw.
        (
            [
                *("friction.thread.coefficient=0.7", "contact_angle=60 deg", "speed=-100 rpm"),
                # Steeper flanks need thinner teeth.
                "screw_tooth_thinning=0.3 mm",
            ],
            "self_locking",
            "the load alone causes no motion",
            0,
        ),
    ],
)
def test_a_thread_that_does_not_move_has_no_efficiency(prsm, settings, name, words, status):
    options = [word for setting in settings for word in ("--set", setting)]
    code, out, _ = prsm("steady", "actuator", *options, "--json", "-")
    results = json.loads(out)
    assert code == status
    assert results["efficiency"] is None
    assert results["result"] == name
    assert words in results["result_message"]
    _, out, _ = prsm("steady", "actuator", *options)
    (line,) = [line for line in out.splitlines() if line.startswith("efficiency")]
    assert line.split() == ["efficiency:", "none,", *name.replace("_", " ").split(), "–", "%"]
    assert words in " ".join(out.split())


def test_check_counts_errors(prsm):
    status, out, _ = prsm("check", "actuator", "--set", "roller_count=13", "--json", "-")
    assert status == 1
    assert json.loads(out)["errors"] == 1
    status, out, _ = prsm("check", "actuator", "--json", "-")
    assert (status, json.loads(out)["errors"]) == (0, 0)


@pytest.fixture(scope="module")
def contradiction(tmp_path_factory):
    """A design problem that nothing satisfies: a lead of 9 to 11 mm, and a nut speed of 10 m/s."""
    mechanism = scenes.example("actuator")
    path = tmp_path_factory.mktemp("design") / "design.toml"
    text = file.dumps(prsm_jax.Mechanism(mechanism.stages, mechanism.operating_point))
    text += (
        '\n[optimise]\nminimise = "nut_outer_diameter"\n\n[[optimise.variable]]\nname = "lead"\n'
        'lower = "9 mm"\nupper = "11 mm"\n\n[[optimise.constraint]]\nquantity = "nut_speed"\n'
        'lower = "10 m/s"\n'
    )
    path.write_text(text, encoding="utf-8")
    return path


def test_an_infeasible_optimisation_says_so_and_writes_nothing(prsm, contradiction, tmp_path):
    folder = tmp_path / "out"
    status, out, _ = prsm("optimise", contradiction, "--out", folder)
    assert status == 1
    first = out.splitlines()[0]
    assert first.startswith("NO FEASIBLE DESIGN: no feasible design found")
    assert "best found" in out
    assert "no file written" in out
    assert not list(folder.glob("*.toml"))
    status, out, _ = prsm("optimise", contradiction, "--out", folder, "--json", "-")
    results = json.loads(out)
    assert (status, results["feasible"], results["valid"]) == (1, False, False)
    assert results["mechanism"] is None
    status, out, _ = prsm("optimise", contradiction, "--out", folder, "--keep-infeasible")
    assert status == 1
    assert len(list(folder.glob("*.toml"))) == 1
    assert "which breaks limits" in out


def test_a_failed_design_of_a_sweep_has_a_reason(prsm_json, tmp_path):
    import xarray

    results = prsm_json(
        *("sweep", "actuator", "--axis", "roller_count=10,13", "--quantities", "efficiency"),
        *("--out", tmp_path),
    )
    assert (results["points"], results["failed"]) == (2, 1)
    assert results["reasons"] == {"overlapping_rollers": 1}
    data = xarray.open_zarr(results["store"], consolidated=False)
    names = dict(
        zip(
            data["code"].attrs["flag_meanings"].split(),
            data["code"].attrs["flag_values"],
            strict=True,
        )
    )
    np.testing.assert_array_equal(data["code"], [0, names["overlapping_rollers"]])
    assert np.isnan(data["efficiency"][1])
