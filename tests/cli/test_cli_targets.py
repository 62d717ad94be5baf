"""Outputs: refused before anything is computed, written where they are asked for."""

import json
import os
import re

import numpy as np
import pytest
from scipy.integrate import simpson

import prsm_jax
from prsm_jax import file
from tests import scenes

#: Every verb, with what it needs to run.
VERBS = {
    "check": ["wu2022"],
    "explain": ["wu2022"],
    "contact": ["wu2022"],
    "modal": ["wu2022"],
    "response": ["wu2022"],
    "campbell": ["wu2022"],
    "steady": ["wu2022"],
    "strength": ["wu2022"],
    "report": ["wu2022"],
    "simulate": ["wu2022"],
    "sensitivity": ["wu2022"],
    "optimise": ["actuator"],
    "pareto": ["actuator"],
    "studio": ["wu2022", "--no-browser"],
    "calibrate": ["wu2022", "--data", "wu2022_torque"],
    "sweep": ["wu2022", "--axis", "lead=5 mm,6 mm"],
    "study": ["actuator"],
    "tolerance": ["wu2022"],
    "export": ["wu2022", "--as", "csv"],
    "quantities": [],
    "example": ["wu2022"],
    "validate": [],
    "demo": [],
}


def test_every_verb_is_here():
    from prsm_jax.cli._verbs import app

    assert {name for name in app if not name.startswith("-")} <= {*VERBS, "bench", "doctor", "new"}


@pytest.fixture
def nothing_is_computed(monkeypatch):
    """A mechanism is not even read."""

    def refuse(*_):
        raise AssertionError("the file was read before the outputs were checked")

    monkeypatch.setattr("prsm_jax.file.load", refuse)
    monkeypatch.setattr("prsm_jax.validation.validate", refuse)


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize(
    ("option", "path", "expected"),
    [
        ("--out", "/proc/x", "/proc"),
        ("--out", "there.txt", "is a file"),
        ("--out", "there.txt/inside", "is a file"),
        ("--json", "nodir/x.json", "there is no folder"),
        ("--json", "/proc/x.json", "/proc"),
        ("--json", ".", "is a folder"),
    ],
)
def test_an_output_that_cannot_be_written_is_refused_first(
    prsm, nothing_is_computed, tmp_path, verb, option, path, expected
):
    (tmp_path / "there.txt").write_text("mine")
    status, out, err = prsm(verb, *VERBS[verb], option, path)
    assert (status, out) == (2, "")
    (line,) = err.splitlines()
    assert line.startswith(f"prsm: {option} {path}: ")
    assert expected in line
    assert [p.name for p in tmp_path.iterdir()] == ["there.txt"]
    assert (tmp_path / "there.txt").read_text() == "mine"


@pytest.mark.parametrize("verb", ["optimise", "sweep", "demo"])
def test_the_usual_folder_is_checked_as_well(prsm, nothing_is_computed, tmp_path, verb):
    (tmp_path / "out").write_text("mine")
    status, out, err = prsm(verb, *VERBS[verb])
    assert (status, out) == (2, "")
    assert "out" in err
    assert (tmp_path / "out").read_text() == "mine"


def test_a_pipe_is_written_to_and_a_link_followed(prsm, tmp_path):
    """A rename onto them would destroy them."""
    (tmp_path / "real.json").write_text("old")
    (tmp_path / "link.json").symlink_to("real.json")
    assert prsm("quantities", "--json", "link.json")[0] == 0
    assert (tmp_path / "link.json").is_symlink()
    assert json.loads((tmp_path / "real.json").read_text())["quantities"]

    os.mkfifo(tmp_path / "pipe")
    ours = os.open(tmp_path / "pipe", os.O_RDWR | os.O_NONBLOCK)
    try:
        status, _, err = prsm("example", "wu2022", "--json", "pipe")
        assert (status, err) == (0, "")
        assert json.loads(os.read(ours, 1 << 20))["name"] == "wu2022"
    finally:
        os.close(ours)
    assert (tmp_path / "pipe").is_fifo()


def test_steady_writes_pictures_and_tables(prsm_json, prsm, tmp_path):
    results = prsm_json("steady", "wu2022", "--out", "new/steady")
    names = {path.name for path in (tmp_path / "new" / "steady").iterdir()}
    pictures = {f"{name}.{kind}" for name in ("losses", "power-flow") for kind in ("png", "svg")}
    assert names == pictures | {"steady.json", "steady.md"}
    assert {path.rsplit("/", 1)[1] for path in results["pictures"]} == pictures
    saved = json.loads((tmp_path / "new" / "steady" / "steady.json").read_text())
    assert saved["efficiency"] == results["efficiency"]
    assert saved["assumptions"] == results["assumptions"]
    without = prsm_json("steady", "wu2022")
    assert without["drive_torque_nm"] == pytest.approx(saved["drive_torque_nm"], rel=1e-12)
    text = (tmp_path / "new" / "steady" / "steady.md").read_text()
    assert f"| efficiency | {100 * saved['efficiency']:.6g} | % |" in text


def test_other_verbs_write_into_out(prsm, tmp_path):
    assert prsm("check", "wu2022", "--out", "a")[0] == 0
    assert json.loads((tmp_path / "a" / "findings.json").read_text())["findings"]
    assert "inertia" in (tmp_path / "a" / "findings.md").read_text()
    assert prsm("quantities", "--out", "b")[0] == 0
    assert "| efficiency |" in (tmp_path / "b" / "quantities.md").read_text()
    assert prsm("example", "actuator", "--out", "c")[0] == 0
    assert (tmp_path / "c" / "actuator.toml").read_text() == file.example_text("actuator")
    # The name of a file is not made a folder; one that exists is what it is.
    for words in (("example", "actuator"), ("optimise", "actuator"), ("quantities",)):
        status, out, err = prsm(*words, "--out", "new/actuator.toml")
        assert (status, out) == (2, "")
        assert err == (
            "prsm: --out new/actuator.toml: is the name of a file; give a folder, which is made if "
            "needed\n"
        )
        assert not (tmp_path / "new").exists()
    (tmp_path / "folder.toml").mkdir()
    assert prsm("example", "actuator", "--out", "folder.toml")[0] == 0
    assert (tmp_path / "folder.toml" / "actuator.toml").is_file()
    status, _, err = prsm("example", "--out", "d")
    assert status == 2
    assert "say which example" in err
    assert not (tmp_path / "d").exists()


@pytest.mark.parametrize(
    "axis", ["leed=5 mm:15 mm:11", "leed=1,2", "lead=5 kg,6 kg", "lead=5 mm:x:3"]
)
def test_a_bad_axis_is_blamed_by_its_own_name(prsm, axis):
    status, out, err = prsm("sweep", "wu2022", "--axis", axis)
    assert (status, out) == (2, "")
    assert err.startswith(f"prsm: --axis {axis}: ")
    assert "--set" not in err
    if axis.startswith("leed"):
        assert "did you mean lead" in err


def test_a_mission_in_numbers(prsm_json, prsm):
    """Start and end of a mission, both at standstill, say nothing: peaks and sums do."""
    results = prsm_json("simulate", "actuator_mission", "--samples", "41")
    summary = results["summary"]
    torque, speed = (
        np.asarray(results[key]) for key in ("drive_torque_nm", "screw_speed_rad_per_s")
    )
    assert summary["duration_s"] == 2.0
    assert summary["peak_drive_torque_nm"] == np.abs(torque).max()
    assert summary["peak_drive_power_w"] == pytest.approx(np.abs(torque * speed).max(), rel=1e-14)
    assert summary["peak_contact_force_n"] == np.max(results["contact_force_n"])
    assert 0.3 < summary["mission_efficiency"] < 1
    status, out, err = prsm("simulate", "actuator_mission", "--samples", "41")
    assert (status, err) == (0, "")
    rows = {cells[0]: cells[1:] for cells in (re.split(r"\s{2,}", x) for x in out.splitlines())}
    assert rows["peak drive torque"] == [f"{summary['peak_drive_torque_nm']:.6g}", "N·m"]
    efficiency = f"{100 * summary['mission_efficiency']:.6g}"
    assert rows["efficiency over the mission"] == [efficiency, "%"]
    # The energies that are printed give the efficiency that is printed. 10 mm of lead.
    power = torque * speed
    taken = np.asarray(results["load_n"]) * speed * 0.01 / (2 * np.pi)
    for words, one in (
        ("energy supplied by the drive", np.maximum(power, 0)),
        ("energy taken back by the drive", np.maximum(-power, 0)),
        ("net energy from the drive", power),
        ("energy taken by the load", np.maximum(taken, 0)),
        ("energy given back by the load", np.maximum(-taken, 0)),
        ("net energy to the load", taken),
    ):
        value, unit = rows[words]
        assert unit == "J"
        assert float(value) == pytest.approx(simpson(one, x=results["time_s"]), rel=1e-5)
    ways = ("supplied by the drive", "taken back by the drive", "taken by the load")
    supplied, back, taken, returned = (
        float(rows[f"energy {way}"][0]) for way in (*ways, "given back by the load")
    )
    ratio = (taken + back) / (supplied + returned)
    assert 100 * ratio == pytest.approx(float(efficiency), rel=1e-5)
    said = " ".join(out.split())
    assert "both directions counted" in said
    assert f"has to supply {rows['energy supplied by the drive'][0]} J" in said
    assert "start" not in out
    # What is uncertain, by how much, and when.
    assert results["solver"]["error_estimate"] == pytest.approx(0.836, abs=5e-4)
    assert results["solver"]["error_time_s"] == pytest.approx(0.7, abs=1e-9)
    (stated,) = (one for one in results["assumptions"] if "in balance" in one)
    words = "carrier speed uncertain by up to 84 % of the highest screw speed at t = 0.700 s"
    assert words in stated
    assert words in said


def test_a_mission_without_power_has_no_efficiency(prsm, prsm_json):
    """0/0 is no number; 0.02 N·m of drag at 3000 rpm take 2π W, and none comes out: 0 %."""

    def rows(*options):
        _, out, _ = prsm("simulate", *options)
        return {cells[0]: cells[1:] for cells in (re.split(r"\s{2,}", x) for x in out.splitlines())}

    idle = rows("wu2022", "--set", "load=0 N")
    assert idle["efficiency over the mission"] == ["–", "%"]
    assert idle["efficiency %"] == ["–", "–"]
    assert idle["energy from the drive"] == ["0", "J"]
    assert prsm_json("simulate", "wu2022", "--set", "load=0 N")["summary"]["drive_energy_j"] == 0
    dragged = rows("humanoid_leg", "--set", "load=0 N")
    assert dragged["peak drive power"] == [f"{2 * np.pi:.6g}", "W"]
    assert dragged["efficiency over the mission"] == ["0", "%"]
    assert dragged["efficiency %"] == ["0", "0"]


#: A screw under no torque, with what its load and its motion at the start are.
_FREE = """
[[stage]]
roller_count = 10
engaged_threads = 20
sharing = "equal"
thread = { lead = "10 mm", starts = 5, roller_radius = "4 mm", contact_angle = "45 deg" }
material = { youngs_modulus = "210 GPa", poisson_ratio = 0.3, density = "7850 kg/m^3" }
screw = { length = "350 mm", bore_radius = "4 mm" }
roller = { length = "50 mm" }
nut = { length = "80 mm", wall_thickness = "10 mm" }
carrier = { count = 2, length = "4 mm", radial_width = "6 mm" }

[stage.friction.thread]
law = "coulomb"
coefficient = 0.06

[scenario]
duration = "1 s"
samples = 201
torque = "0 N*m"
"""


def test_a_ratio_at_standstill_is_no_efficiency(prsm, prsm_json, tmp_path):
    """12 kN fall from rest: no ratio there; later all their power is lost or in masses."""
    path = tmp_path / "falls.toml"
    text = _FREE.replace("1 s", "20 ms").replace("201", "21")
    path.write_text(text + 'load = "12 kN"\n')
    found = prsm_json("simulate", str(path))
    assert found["efficiency"] == [None] + [0] * 20
    _, out, _ = prsm("simulate", str(path))
    assert re.search(r"^efficiency % +– +0$", out, re.MULTILINE)


def test_carriers_that_turn_alone_have_a_speed(prsm, prsm_json, tmp_path):
    """Drag of 0.05 N·m stops the screw; carriers of no load go on, with the energy not lost."""
    path = tmp_path / "coasts.toml"
    path.write_text(
        _FREE.replace(
            "[stage.friction.thread]",
            '[stage.friction.drag]\ntorque = "0.05 N*m"\n\n[stage.friction.thread]',
        )
        + 'initial_speed = "157 rad/s"\n'
        '\n[scenario.load]\nkind = "hinge"\nconstant = "0 N"\nstiffness = "0 N/m"\n'
    )
    found = prsm_json("simulate", str(path))
    ((*_, speed),) = found["carrier_speed_rad_per_s"]
    assert found["screw_speed_rad_per_s"][-1] == 0
    assert speed > 50
    _, out, _ = prsm("simulate", str(path))
    rows = {cells[0]: cells[1:] for cells in (re.split(r"\s{2,}", x) for x in out.splitlines())}
    assert rows["stage 1: carrier ratio"][1] == "–"
    assert float(rows["stage 1: carrier speed rpm"][1]) == pytest.approx(speed * 30 / np.pi, 1e-5)


def test_a_torque_at_standstill_is_said_to_be_without_friction(prsm):
    """7 kN times the lead of 10 mm over 2π, which no friction of a motion changes."""
    _, out, _ = prsm("simulate", "wu2022", "--set", "speed=0 rpm")
    assert re.search(rf"peak drive torque +{7e3 * 10e-3 / (2 * np.pi):.6g} ", out)
    words = "The screw stands still: torques are those that hold the load without thread friction"
    assert words in " ".join(out.split())
    _, out, _ = prsm("simulate", "wu2022")
    assert "stands still" not in out


def test_a_steady_state_at_standstill_says_that_it_is_the_start_of_motion(prsm, prsm_json):
    """Its torque is that of turning slowly; any torque down to that of back-driving holds."""
    still = prsm_json("steady", "wu2022", "--set", "speed=0")
    mechanism = scenes.example("wu2022")
    slow, back = (
        float(prsm_jax.steady_state(mechanism, speed=speed).drive_torque) for speed in (1e-6, -1e-6)
    )
    assert still["drive_torque_nm"] == pytest.approx(slow, rel=1e-6)
    assert back < 7e3 * 10e-3 / (2 * np.pi) < slow
    words = (
        "At speed 0, efficiency, torque and forces are those of the start of motion, with the "
        "screw driving: the limit of slow turning. At rest, any torque between this one and that "
        "of back-driving (a negative speed) holds the load."
    )
    assert still["assumptions"][0] == words
    assert words not in prsm_json("steady", "wu2022")["assumptions"]
    _, out, _ = prsm("steady", "wu2022", "--set", "speed=0")
    assert words in " ".join(out.split())
    # The other way round, the load drives forward; without a load nothing is to be held.
    pulled = prsm_json("steady", "wu2022", "--set", "speed=0", "--set", "load=-7 kN")
    assert "(a positive speed)" in pulled["assumptions"][0]
    idle = prsm_json("steady", "wu2022", "--set", "speed=0", "--set", "load=0 N")
    assert not any("start of motion" in one for one in idle["assumptions"])


def test_a_closed_form_has_no_steps(prsm):
    status, out, err = prsm("simulate", "wu2022", "--method", "closed_form")
    assert (status, err) == (0, "")
    assert "closed form" in out
    assert "steps" not in out
    # From rest to the operating point: both ends are worth printing.
    assert "start" in out
