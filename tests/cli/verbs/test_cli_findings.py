"""Impossible, locked and jammed mechanisms say what they are, in every verb."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import scenes

import prsm_jax
from prsm_jax import cli, file
from prsm_jax.cli.verbs import _contact
from prsm_jax.geometry import Finding

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
            "the load alone does not keep up this motion",
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
    # Of a jammed thread there are no forces and powers, but motions.
    rows = {line.split("  ")[0]: line.split()[-2:] for line in out.splitlines() if "  " in line}
    for row in ("drive torque", "input power", "loss: thread_sliding", "power balance residual"):
        assert ("–" in rows[row]) == (name == "jammed"), row
    assert "–" not in rows["stage 1: carrier ratio"]


def _rows(out):
    """Cells of each line of a table by its label."""
    lines = (re.split(r"\s{2,}", line.strip()) for line in out.splitlines())
    return {cells[0]: cells[1:] for cells in lines if len(cells) > 1}


@pytest.mark.parametrize("sense", [1, -1])
def test_without_a_load_there_is_no_trace_of_one(prsm, prsm_json, sense):
    """Drag alone takes 0.2 N·m at 1200 rpm, 0.2 · 40 π W; no other force or power is left."""
    verb = ("steady", "actuator", "--set", "load=0 N", "--set", "friction.drag.torque=0.2 N m")
    verb = (*verb, "--set", f"speed={1200 * sense} rpm")
    _, out, _ = prsm(*verb)
    rows = _rows(out)
    assert rows["drive torque"] == [f"{0.2 * sense}", "N·m"]
    assert rows["loss: drag"] == rows["input power"] == [f"{0.2 * 40 * np.pi:.6g}", "W"]
    others = [name for name in rows if name.startswith("loss: ") and name != "loss: drag"]
    assert len(others) > 1
    for name in (*others, "output power"):
        assert rows[name] == ["0", "W"], name
    assert rows["stage 1: normal force of screw on one roller"] == ["0", "N"]
    assert rows["efficiency"] == ["0", "%"]
    results = prsm_json(*verb)
    assert results["output_power_w"] == results["efficiency"] == 0
    assert results["contact_force_n"] == results["ring_gear_force_n"] == [0]
    assert {name for name, power in results["losses_w"].items() if power != 0} == {"drag"}


@pytest.mark.parametrize(("pressure", "shown"), [(0.0, 0.0), (3.4e8, 6.7e-4)])
def test_threads_without_load_have_no_stiffness(pressure, shown):
    """The stiffness of a Hertz contact goes to 0 with the cube root of its load."""
    factors = {"thread_sharing_factor": 1.0, "roller_sharing_factor": 1.0}
    shared = {"screw": factors, "nut": factors, "deflection_m": 0.0, "spacer_force_n": None}
    shared |= dict.fromkeys(("max_pressure_pa", "whole_ellipse_max_pressure_pa"), pressure)
    lines = _contact._lines_of_sharing(1, {**shared, "tangent_stiffness_n_per_m": 6.7e-4})
    assert ("stage 1: load sharing, axial stiffness dF/dx", shown, "N/m") in lines


def _documented_rows():
    """Verbs of each row of the table of exit statuses in the documentation, with its words."""
    page = (Path(__file__).parents[3] / "docs/command_line.md").read_text(encoding="utf-8")
    head = "| verb | exit status 1 because of an error |\n|---|---|\n"
    rows = page.split(head)[1].split("\n\n")[0].splitlines()
    cells = [row.strip("| ").split(" | ", 1) for row in rows]
    return {tuple(verbs.replace("`", "").split(", ")): words for verbs, words in cells}


@pytest.mark.parametrize("verb", ["check", "steady", "campbell", "modal"])
@pytest.mark.parametrize("kind", ["existence", "service"])
def test_the_exit_status_is_what_the_documentation_says(prsm, monkeypatch, verb, kind):
    one = Finding("screw_speed", "error", 1, 2.0, 1.0, "too fast", kind == "existence")
    monkeypatch.setattr("prsm_jax.cli._common.check_from", lambda *_: (one,))
    status, _, err = prsm(verb, "actuator", "--json", "-")
    (words,) = [words for verbs, words in _documented_rows().items() if verb in verbs]
    before, _, after = words.partition("; not for ")
    assert status == int("every error" in before or kind in before)
    assert (kind in after) == (status == 0)
    if verb != "check":
        assert err == "prsm: error found by check: screw_speed, stage 1: too fast\n"


def test_every_verb_with_findings_is_in_the_table():
    folder = Path(cli.__file__).parent / "verbs"
    named = {verb for verbs in _documented_rows() for verb in verbs}
    found: set[str] = set()
    for path in folder.rglob("_*.py"):
        for part in path.read_text(encoding="utf-8").split("@app.command\ndef ")[1:]:
            body = part.split("\n\n\n")[0]
            found |= {part.split("(")[0]} if "checked(" in body or "findings" in body else set()
    # `demo` improves an example of its own.
    assert found - {"demo"} == named


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
    assert "earlier run" not in out
    status, out, _ = prsm("optimise", contradiction, "--out", folder, "--keep-infeasible")
    assert status == 1
    (path,) = folder.glob("*.toml")
    assert "which breaks limits" in out
    # That file stays beside later results, which name it.
    before = path.read_bytes()
    status, out, err = prsm("optimise", contradiction, "--out", folder)
    assert f"{path} is of an earlier run" in out.splitlines()
    assert "earlier run" not in err
    status, out, err = prsm("optimise", contradiction, "--out", folder, "--json", "-")
    assert json.loads(out)["mechanism"] is None
    assert (
        f"no file written: the best design found breaks limits (--keep-infeasible); {path} is "
        "of an earlier run" in err
    )
    assert path.read_bytes() == before


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


def test_an_export_of_an_impossible_mechanism_is_written_and_says_so(prsm, tmp_path):
    """13 rollers of 4 mm around a screw of 12 mm overlap."""
    words = ("export", "actuator", "--as", "toml", "--set", "roller_count=13", "--out", tmp_path)
    status, out, err = prsm(*words)
    assert status == 1
    assert err.startswith("prsm: error found by check: roller_clearance, stage 1: 13 neighbouring")
    assert len(err.splitlines()) == 1
    assert out.splitlines()[0] == str(tmp_path / "actuator-export.toml")
    assert "prsm check finds errors: roller_clearance" in out
    assert file.load(tmp_path / "actuator-export.toml").stages[0].roller_count == 13
    status, out, _ = prsm(*words, "--json", "-")
    results = json.loads(out)
    assert (status, results["valid"]) == (1, False)
    assert "roller_clearance" in results["findings"]
    assert prsm("export", "actuator", "--as", "toml", "--out", tmp_path)[0] == 0


#: Verbs that save tables, with the name of their files.
SAVED = {"strength": "strength", "steady": "steady"}


@pytest.mark.parametrize("verb", SAVED)
@pytest.mark.parametrize("count", ["10", "14"])
def test_saved_pages_say_what_the_terminal_says(prsm, tmp_path, verb, count):
    """14 rollers of 4 mm do not fit around a screw of 12 mm: 32 sin(π/14) < 8."""
    impossible = 2 * (12 + 4) * np.sin(np.pi / int(count)) < 2 * 4
    folder = tmp_path / "out"
    words = (verb, "actuator", "--set", f"roller_count={count}", "--out", folder)
    status, out, _ = prsm(*words)
    assert status == int(impossible)
    page = (folder / f"{SAVED[verb]}.md").read_text(encoding="utf-8").replace("\\", "")
    for text in (" ".join(out.split()), page):
        assert ("prsm check finds errors: roller_clearance" in text) == impossible
        assert ("Not valid: the mechanism cannot be built as drawn." in text) == impossible
        if verb == "strength":
            assert ("Strength of actuator: fail" in text) == impossible
    saved = json.loads((folder / f"{SAVED[verb]}.json").read_text(encoding="utf-8"))
    _, out, _ = prsm(*words, "--json", "-")
    assert saved == json.loads(out)
    assert saved["valid"] is not impossible
    assert ("roller_clearance" in saved["findings"]) == impossible
    assert {Path(path).name for path in saved["files"]} == {
        f"{SAVED[verb]}.json",
        f"{SAVED[verb]}.md",
    }


def test_strength_report_and_findings_agree(prsm):
    """The status of the report and of the studio is the worst of checks and findings."""
    mechanism = file.apply_settings(scenes.example("actuator"), ["roller_count=14"])
    expected = prsm_jax.findings.status_of(
        prsm_jax.strength_checks(mechanism), prsm_jax.check(mechanism)
    )
    status, out, _ = prsm("strength", "actuator", "--set", "roller_count=14", "--json", "-")
    assert (status, json.loads(out)["status"]) == (1, expected) == (1, "fail")


def test_strength_without_limits_but_with_errors_has_a_headline(prsm, monkeypatch):
    one = Finding("screw_speed", "error", 1, 2.0, 1.0, "too fast", False)
    monkeypatch.setattr("prsm_jax.cli.verbs._analyse.check_from", lambda *_: (one,))
    monkeypatch.setattr("prsm_jax.cli.verbs._analyse.strength_checks_from", lambda *_: ())
    status, out, _ = prsm("strength", "wu2022")
    assert status == 1
    assert out.startswith("Strength of wu2022: fail\nNo checks: the file gives no limit.")
    assert "prsm check finds errors: screw_speed" in out
