"""The FMU of a mechanism, checked and run by FMPy, against `simulate` and against the balances."""

import dataclasses
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

import prsm_jax as prsm
from prsm_jax.exchange import write_fmu
from prsm_jax.exchange.fmu import DrivenState, check_exchangeable

FORWARD, BACKWARD, HOLDING, LOAD = 15.0, -4.0, 10.0, 7e3
STEP, REVERSAL, STOP = 1e-3, 8e-3, 20e-3


@pytest.fixture(scope="module")
def mechanism():
    """Friction that falls with the slip, and sticks: the acceleration is not constant."""
    text = prsm.file.example_text("wu2022")
    old = 'law = "coulomb"\ncoefficient = 0.05'
    assert old in text
    new = 'law = "stribeck"\nstatic_coefficient = 0.08\ncoefficient = 0.05\nstribeck_speed = 0.2'
    return prsm.loads(text.replace(old, new))


@pytest.fixture(scope="module")
def unit(mechanism, tmp_path_factory):
    path = tmp_path_factory.mktemp("fmu") / "screw.fmu"
    assert write_fmu(path, mechanism) == path
    assert [one.name for one in path.parent.iterdir()] == ["screw.fmu"]
    return path


def _simulated(mechanism, speed, torque, duration):
    """Speed and travel after a time, in one run of `simulate`."""
    scenario = prsm.TorqueScenario(torque, LOAD, duration, initial_speed=speed, samples=2)
    run = prsm.simulate(mechanism, scenario, method="quasi_steady")
    return float(run.screw_speed[-1]), float(run.position[-1])


def test_the_checker_finds_no_problem(unit):
    assert validate_fmu(str(unit)) == []


def test_the_description_has_units_and_the_unit_the_mechanism(unit, mechanism):
    description = fmpy.read_model_description(str(unit))
    assert description.fmiVersion == "3.0"
    assert description.coSimulation is not None
    found = {
        one.name: (one.causality, one.declaredType and one.declaredType.unit)
        for one in description.modelVariables
    }
    assert found == {
        "time": ("independent", None),
        "torque": ("input", "N.m"),
        "load": ("input", "N"),
        "initial_speed": ("parameter", "rad/s"),
        "initial_position": ("parameter", "m"),
        "screw_angle": ("output", "rad"),
        "screw_speed": ("output", "rad/s"),
        "screw_acceleration": ("output", "rad/s2"),
        "nut_position": ("output", "m"),
        "nut_speed": ("output", "m/s"),
        "carrier_speed[1]": ("output", "rad/s"),
        "roller_speed[1]": ("output", "rad/s"),
        "contact_force[1]": ("output", "N"),
        "friction_torque": ("output", "N.m"),
        "loss_power": ("output", "W"),
        "sticking": ("output", None),
    }
    units = {one.name: one.baseUnit for one in description.unitDefinitions}
    assert (units["N.m"].kg, units["N.m"].m, units["N.m"].s) == (1, 2, -2)
    assert (units["W"].kg, units["W"].m, units["W"].s) == (1, 2, -3)
    assert (units["rad/s"].rad, units["rad/s"].s) == (1, -1)
    with zipfile.ZipFile(unit) as archive:
        text = archive.read("resources/mechanism.toml").decode()
    assert prsm.dumps(prsm.loads(text)) == prsm.dumps(mechanism)


def _descriptions(path):
    return {one.name: one.description for one in fmpy.read_model_description(path).modelVariables}


@pytest.mark.parametrize(
    ("name", "driven", "moved", "turning"),
    [
        ("wu2022", "screw", "nut", "screw"),
        ("humanoid_leg", "nut", "screw", "nut"),
        ("li2020_two_stage", "first screw", "last nut", "screw"),
    ],
)
def test_descriptions_name_the_body_of_the_type(name, driven, moved, turning, tmp_path):
    """Names of variables have `screw` and `nut` for all types; what they are stands beside them."""
    path = write_fmu(tmp_path / "a.fmu", prsm.load(name))
    found = _descriptions(str(path))
    expected = {
        "torque": f"torque at the {driven}",
        "load": f"axial load on the {moved}, against its motion at positive speed",
        "initial_speed": f"speed of the {driven} at the start",
        "initial_position": f"position of the {moved} at the start",
        "screw_angle": f"angle of the {driven} since the start",
        "screw_speed": f"speed of the {driven}",
        "screw_acceleration": f"acceleration of the {driven}",
        "nut_position": f"position of the {moved}",
        "nut_speed": f"speed of the {moved}",
        "contact_force[1]": f"normal force of the {turning} on one roller",
        "friction_torque": f"torque that friction takes from the {driven}",
    }
    assert {key: found[key] for key in expected} == expected
    assert not [words for words in found.values() if words and "{" in words]


@pytest.fixture(scope="module")
def run(unit):
    """Forward, and then backward until the mechanism sticks; torques change between two steps."""
    between = REVERSAL - STEP / 2
    signals = np.array(
        [
            (0.0, FORWARD, LOAD),
            (between, FORWARD, LOAD),
            (between + STEP / 100, BACKWARD, LOAD),
            (STOP, BACKWARD, LOAD),
        ],
        dtype=[("time", float), ("torque", float), ("load", float)],
    )
    return fmpy.simulate_fmu(
        str(unit),
        start_values={"initial_position": 0.25},
        input=signals,
        step_size=STEP,
        output_interval=STEP,
        stop_time=STOP,
    )


def test_a_run_equals_simulate(run, mechanism):
    """Steps of 1 ms against one run up to each time; steps have errors of up to 1e-8."""
    assert np.allclose(run["time"], STEP * np.arange(21), atol=1e-12)
    middle = round(REVERSAL / STEP)
    before = _simulated(mechanism, 0.0, FORWARD, REVERSAL)
    after = _simulated(mechanism, before[0], BACKWARD, STOP - REVERSAL)
    largest = max(abs(run["screw_speed"]))
    assert largest > 50
    assert run["screw_speed"][middle] == pytest.approx(before[0], abs=1e-9 * largest)
    assert run["screw_speed"][-1] == pytest.approx(after[0], abs=1e-9 * largest)
    moved = run["nut_position"] - 0.25
    assert moved[middle] == pytest.approx(before[1], rel=5e-9)
    assert moved[-1] == pytest.approx(before[1] + after[1], rel=5e-9)


def test_outputs_agree_with_each_other_and_with_the_geometry(run, mechanism):
    stage = mechanism.stages[0]
    thread = stage.thread
    travel = float(thread.lead) / (2 * np.pi)
    assert run["nut_speed"] == pytest.approx(travel * run["screw_speed"], rel=1e-12)
    assert run["nut_position"] - 0.25 == pytest.approx(travel * run["screw_angle"], rel=1e-9)
    # The rollers roll in the nut, which does not turn.
    spin = run["carrier_speed[1]"] * (1 - float(thread.nut_radius / thread.roller_radius))
    assert run["roller_speed[1]"] == pytest.approx(spin, rel=1e-12)
    assert np.allclose(run["loss_power"], run["friction_torque"] * run["screw_speed"], rtol=1e-12)
    # Newton's law of the screw, with the torques of load and friction. The inertia is constant but
    # for that of the carriers, a hundredth, whose ratio changes with friction by a few percent.
    torque = np.where(run["time"] < REVERSAL - 1e-9, FORWARD, BACKWARD)
    torque[round(REVERSAL / STEP)] = FORWARD
    left = torque - LOAD * travel - run["friction_torque"]
    turning = run["screw_speed"] > 1
    inertia = left[turning] / run["screw_acceleration"][turning]
    assert np.ptp(inertia) < 1e-3 * inertia.mean()
    carried = float(stage.screw.inertia) + travel**2 * float(stage.nut.mass)
    assert inertia.mean() > carried
    assert inertia.mean() == pytest.approx(carried, rel=0.2)


def test_it_sticks_until_the_torque_exceeds_friction(unit, mechanism):
    """At 10 N·m friction holds: the load alone needs 11.1 N·m, and does not drive it back."""
    found = fmpy.simulate_fmu(
        str(unit),
        start_values={"torque": HOLDING, "load": LOAD},
        step_size=STEP,
        output_interval=STEP,
        stop_time=3 * STEP,
    )
    assert found["sticking"].all()
    assert not found["screw_speed"].any()
    expected = HOLDING - LOAD * float(mechanism.stages[0].thread.lead) / (2 * np.pi)
    assert found["friction_torque"] == pytest.approx(expected, rel=1e-12)


def test_a_step_without_a_motion_fails_with_the_reason(unit):
    """A NaN as an input: FMPy reports the status, the log has the sentence."""
    said = []
    with pytest.raises(FMICallException, match="failed with status"):
        fmpy.simulate_fmu(
            str(unit),
            start_values={"torque": np.nan, "load": LOAD},
            step_size=STEP,
            stop_time=STEP,
            logger=lambda environment, status, category, message: said.append(message.decode()),
        )
    assert any("torque" in line and "nan" in line for line in said), said


def test_what_cannot_be_a_unit_is_refused(mechanism, tmp_path):
    stage = mechanism.stages[0]
    loose = dataclasses.replace(stage, friction=None)
    with pytest.raises(prsm.MissingDataError, match=r"give \[stage.friction.thread\]"):
        check_exchangeable(dataclasses.replace(mechanism, stages=(loose,)))
    smooth = prsm.friction.RegularisedCoulombFriction(0.05, 1e-3)
    friction = dataclasses.replace(stage.friction, thread=smooth)
    other = dataclasses.replace(stage, friction=friction)
    with pytest.raises(prsm.PrsmError, match="state of screw and nut alone"):
        write_fmu(tmp_path / "a.fmu", dataclasses.replace(mechanism, stages=(other,)))
    with pytest.raises(ValueError, match=r"must be \.fmu"):
        write_fmu(tmp_path / "a.zip", mechanism)
    with pytest.raises(prsm.MissingDataError, match="recirculating"):
        write_fmu(tmp_path / "a.fmu", prsm.load("recirculating_stage"))
    assert not list(tmp_path.iterdir())
    assert DrivenState() == (0.0, 0.0, 0.0)
