"""The verbs that analyse: JSON, tables, errors, and agreement with the Python interface."""

import json

import numpy as np
import pytest

import prsm_jax
from prsm_jax import file
from prsm_jax.programs import _stored
from tests import scenes

#: Keys that users' scripts rely on.
SIDE_KEYS = {
    "contact_radius_m",
    "contact_angle_position_rad",
    "semi_major_m",
    "semi_minor_m",
    "max_pressure_pa",
    "approach_m",
    "stiffness_n_per_m",
    "stiffness_tangent_n_per_m",
}
STEADY_KEYS = {
    "efficiency",
    "carrier_ratio",
    "drive_torque_nm",
    "contact_force_n",
    "losses_w",
    "power_balance_residual",
}
SIMULATE_KEYS = {
    "time_s",
    "carrier_ratio",
    "efficiency",
    "drive_torque_nm",
    "screw_roller_axial_force_n",
    "ring_gear_force_n",
    "carrier_force_n",
    "spline_friction_n",
    "solver",
}


def test_contact_json(prsm_json):
    results = prsm_json("contact", "wu2022")
    (stage,) = results["stages"]
    for side in ("screw", "nut"):
        assert stage[side].keys() >= SIDE_KEYS
        assert stage[side]["stiffness_tangent_n_per_m"] == pytest.approx(
            1.5 * stage[side]["stiffness_n_per_m"], rel=1e-14
        )


def test_modal_json_lists_every_degree_of_freedom(prsm_json):
    results = prsm_json("modal", "wu2022")
    count = len(results["frequencies_hz"])
    assert count == 7 + 10
    assert len(results["families"]) == len(results["multiplicities"]) == count
    assert results["frequencies_hz"] == sorted(results["frequencies_hz"])
    assert results["families"].count("roller") == 7 - 3
    assert results["families"].count("transverse") == 8


def test_steady_json_agrees_with_python(prsm_json):
    results = prsm_json("steady", "li2020_two_stage")
    assert results.keys() >= STEADY_KEYS
    state = scenes.steady_state(scenes.example("li2020_two_stage"))
    assert results["efficiency"] == pytest.approx(float(state.efficiency), rel=1e-14)
    assert results["carrier_ratio"] == pytest.approx(np.asarray(state.carrier_ratio), rel=1e-14)
    assert set(results["losses_w"]) == {"spline", "thread_sliding", "thrust_bearing"}


def test_steady_twice_uses_the_stored_program(prsm_json, monkeypatch, tmp_path):
    monkeypatch.setenv("PRSM_JAX_CACHE", str(tmp_path / "cache"))
    # Other tests of this process may have used the program from another folder.
    monkeypatch.setattr(_stored, "_used", {})
    first = prsm_json("steady", "wu2022")
    stored = list((tmp_path / "cache" / "programs").iterdir())
    assert len(stored) == 1
    assert prsm_json("steady", "wu2022") == first
    # Another structure is another program; another number is not.
    prsm_json("steady", "wu2022", "--set", "lead=12 mm")
    assert list((tmp_path / "cache" / "programs").iterdir()) == stored
    # A program that was cut short is made again.
    stored[0].write_bytes(b"not a program")
    assert prsm_json("steady", "wu2022") == first


def test_simulate_json(prsm_json):
    results = prsm_json("simulate", "li2020_two_stage", "--samples", "21")
    assert results.keys() >= SIMULATE_KEYS
    assert np.shape(results["carrier_ratio"]) == (2, 21)
    assert results["solver"]["result"] == "successful"
    assert results["solver"].keys() >= {"name", "steps", "rejected", "result"}


def test_set_changes_the_result_and_takes_units(prsm_json):
    slow = prsm_json("steady", "wu2022", "--set", "speed=60 rpm", "--set", "load=1 kN")
    assert slow["speed_rad_per_s"] == pytest.approx(2 * np.pi, rel=1e-15)
    assert slow["load_n"] == 1000.0


def test_check_warns_of_faulty_numbers(prsm_json):
    """Table 4 of Wu et al. 2022; warnings leave the exit status at 0, which `prsm_json` asserts."""
    found = prsm_json("check", "wu2022")["findings"]
    names = [finding["name"] for finding in found if finding["severity"] == "warning"]
    assert names == ["inertia"] * 4 + ["torsional_support"]
    assert all(set(f) >= {"stage", "value", "limit", "message"} for f in found)


def test_json_to_a_file_leaves_stdout_empty(prsm, tmp_path):
    status, out, err = prsm("contact", "lisowski2014", "--json", tmp_path / "contact.json")
    assert (status, out, err) == (0, "", "")
    assert json.loads((tmp_path / "contact.json").read_text())["stages"]


@pytest.mark.parametrize("verb", ["contact", "modal", "steady", "check"])
def test_without_json_a_table_is_printed(prsm, verb):
    status, out, err = prsm(verb, "actuator")
    assert (status, err) == (0, "")
    assert len(out.splitlines()) > 3
    assert max(map(len, out.splitlines())) <= 80


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["steady", "nosuch"], "nosuch"),
        (["steady", "wu2022", "--set", "lead=10 kg"], "wrong unit"),
        (["steady", "wu2022", "--set", "leed=10 mm"], "leed"),
        # Ten metres.
        (["steady", "wu2022", "--set", "lead=10"], "at most 1 m"),
        (["steady", "wu2022", "--set", "lead"], "KEY=VALUE"),
        (["steady"], "file"),
        (["stedy", "wu2022"], "steady"),
        (["modal", "wu2022", "--stage", "3"], "stage is 3"),
        (["modal", "li2020_two_stage"], "mass"),
        (["example", "nosuch"], "nosuch"),
        (["validate", "nosuch"], "nosuch"),
    ],
)
def test_what_a_user_can_mend_is_one_line_and_status_two(prsm, tmp_path, words, expected):
    status, out, err = prsm(*words, "--json", tmp_path / "x.json")
    assert status == 2
    assert out == ""
    assert len(err.strip().splitlines()) == 1
    assert expected.lower() in err.lower()
    assert list(tmp_path.iterdir()) == []


def test_locking_is_reported_as_an_invalid_state(prsm_json):
    # Far past the locking limit of a 45° thread no contact force balances the load.
    results = prsm_json(
        "steady", "li2020_single_stage_viscous", "--set", "speed=1e4 rad/s", status=0
    )
    assert results["valid"] is True
    locked = prsm_json(
        "steady",
        "wu2022",
        "--set",
        "friction.thread.coefficient=2",
        "--set",
        "lead=60 mm",
        status=1,
    )
    assert locked["valid"] is False


def test_quantities_catalogue(prsm_json):
    known = prsm_json("quantities")["quantities"]
    assert {"name", "symbol", "unit", "description"} == set(known[0])
    assert {q.name for q in prsm_jax.quantities.catalogue()} == {entry["name"] for entry in known}


def test_example_prints_a_file_that_can_be_read(prsm):
    for name in file.example_names():
        status, out, _ = prsm("example", name)
        assert status == 0
        file.loads(out)


def test_simulate_runs_the_scenario_of_a_file(prsm_json):
    """A mission out and back; numbers of the scenario and of the options can be set."""
    results = prsm_json("simulate", "actuator_mission", "--samples", "41")
    assert results.keys() >= SIMULATE_KEYS
    assert results["time_s"][-1] == 2.0
    assert np.max(results["screw_speed_rad_per_s"]) > 100
    # The load pushes one way and then the other.
    assert np.min(results["load_n"]) < -5e3
    assert np.max(results["load_n"]) > 5e3
    assert np.min(results["contact_force_n"]) >= 0
    assert results["solver"]["result"] == "successful"
    shorter = prsm_json(
        "simulate",
        "actuator_mission",
        *("--samples", "41", "--method", "quasi_steady", "--set", "scenario.duration=0.5 s"),
    )
    assert shorter["time_s"][-1] == 0.5


TORQUE = """
[scenario]
duration = "0.1 s"
torque = "3.2 N m"
most_phases = 4
samples = 11

[scenario.load]
kind = "hinge"
constant = "2 kN"
"""


def test_simulate_under_a_prescribed_torque(prsm, prsm_json, tmp_path):
    """Between 2.8 N·m, at which the load runs back, and 3.6 N·m, at which it yields: it sticks."""
    text = file.example_text("actuator_mission")
    text = text[: text.index("[scenario]")] + TORQUE
    (tmp_path / "torque.toml").write_text(text)
    results = prsm_json("simulate", tmp_path / "torque.toml")
    assert results.keys() >= SIMULATE_KEYS | {"position_m", "sticking", "phases"}
    assert all(results["sticking"])
    assert results["position_m"] == [0.0] * 11
    (phase,) = results["phases"]
    assert phase == {"start_s": 0.0, "end_s": pytest.approx(0.1), "mode": "sticking"}
    # The torque is the prescribed one, and friction holds the screw.
    _, out, _ = prsm("simulate", tmp_path / "torque.toml")
    assert "peak drive torque" in out
    assert "stands still" not in out
