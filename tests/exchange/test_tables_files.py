"""Profiles, duty cycles and measurements as CSV: in other units, and there and back."""

import csv
import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.calibration import Measurements, read_measurements
from prsm_jax.exchange import (
    read_duty_cycle,
    read_scenario,
    write_duty_cycle,
    write_measurements,
    write_scenario,
)
from prsm_jax.mechanism import DutyCycle
from prsm_jax.scenario import HingeLoad, SineProfile, TableProfile

#: A conversion rounds twice.
ROUNDED = 4e-16


def _text(path, *lines):
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _profile(function) -> TableProfile:
    assert isinstance(function, TableProfile)
    return function


def _table(path):
    with path.open(newline="") as file:
        headings, *rows = csv.reader(file)
    return dict(zip(headings, np.array(rows, float).T, strict=True))


def test_a_recorded_mission_is_read_in_si(tmp_path):
    path = _text(
        tmp_path / "mission.csv",
        "# recorded on the test rig",
        "load [kN];time [ms];speed [rpm]",
        "1.5;0;0",
        "2;250;600",
        "-1;1000;-300",
    )
    scenario = read_scenario(path, samples=11)
    assert isinstance(scenario, prsm.Scenario)
    assert scenario.samples == 11
    assert float(scenario.duration) == 1.0
    speed, load = _profile(scenario.speed), _profile(scenario.load)
    assert list(speed.times) == [0.0, 0.25, 1.0]
    turns = np.array([0.0, 600.0, -300.0]) * 2 * np.pi / 60
    assert np.asarray(speed.values) == pytest.approx(turns, rel=ROUNDED)
    assert np.asarray(load.values) == pytest.approx([1500.0, 2000.0, -1000.0], rel=ROUNDED)
    # Between rows the numbers change linearly: 0.1 s of 0.25 s.
    assert float(load(jnp.asarray(0.1))) == pytest.approx(1500 + 0.4 * 500, rel=1e-15)


def test_a_torque_makes_a_scenario_of_a_torque(tmp_path):
    path = _text(tmp_path / "t.csv", "time [s],torque [N m],load [N]", "0,1,2", "0.5,3,4")
    scenario = read_scenario(path)
    assert isinstance(scenario, prsm.TorqueScenario)
    assert list(_profile(scenario.torque).values) == [1.0, 3.0]


def test_tables_come_back_exactly(tmp_path):
    speed = TableProfile([0.0, 0.1, 0.7], [0.1, 1 / 3, 2.0])
    load = TableProfile([0.0, 0.3, 0.7], [7e3, np.pi, -1e-3])
    scenario = prsm.Scenario(speed, load, 0.7)
    again = read_scenario(write_scenario(tmp_path / "scenario.csv", scenario))
    assert isinstance(again, prsm.Scenario)
    assert list(_profile(again.speed).times) == [0.0, 0.1, 0.3, 0.7]
    for time in (0.0, 0.1, 0.3, 0.7):
        at = jnp.asarray(time)
        assert float(_profile(again.speed)(at)) == float(speed(at))
        assert float(_profile(again.load)(at)) == float(load(at))


@pytest.mark.parametrize(
    ("scenario", "lost"),
    [
        (prsm.Scenario(1.0, 5e3, 0.1, initial_position=0.01), "initial_position is 0.01 in place"),
        (prsm.Scenario(1.0, 5e3, 0.1, initial_carrier_ratio=0.3), "initial_carrier_ratio is 0.3"),
        (
            prsm.TorqueScenario(1.0, 5e3, 0.1, initial_speed=50.0, initial_position=-0.02),
            "initial_speed is 50 in place of 0, initial_position is -0.02 in place of 0, which",
        ),
        (prsm.TorqueScenario(1.0, 5e3, 0.1, most_phases=64), "most_phases is 64 in place of 32"),
    ],
)
def test_a_state_at_the_start_is_not_lost_in_a_file(tmp_path, scenario, lost):
    path = tmp_path / "scenario.csv"
    with pytest.raises(ValueError, match=lost):
        write_scenario(path, scenario)
    assert not path.exists()


def test_other_profiles_are_written_at_the_samples(tmp_path):
    torque = SineProfile(amplitude=3.0, frequency=2.0, mean=1.0)
    scenario = prsm.TorqueScenario(torque, 5e3, 0.5, samples=6)
    table = _table(write_scenario(tmp_path / "sine.csv", scenario))
    assert list(table) == ["time [s]", "torque [N m]", "load [N]"]
    times = np.linspace(0, 0.5, 6)
    assert np.array_equal(table["time [s]"], times)
    assert table["torque [N m]"] == pytest.approx(1 + 3 * np.sin(4 * np.pi * times), abs=1e-14)
    assert set(table["load [N]"]) == {5e3}
    moved = dataclasses.replace(scenario, load=HingeLoad(0.0, 1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match="depends on the motion"):
        write_scenario(tmp_path / "hinge.csv", moved)
    assert [one.name for one in tmp_path.iterdir()] == ["sine.csv"]


def test_a_duty_cycle_in_and_out(tmp_path):
    path = _text(
        tmp_path / "cycle.csv", "duration [min],speed [rpm],load [kN]", "2,1200,4", "0.5,-300,-1.1"
    )
    cycle = read_duty_cycle(path)
    assert np.asarray(cycle.duration) == pytest.approx([120.0, 30.0], rel=ROUNDED)
    assert np.asarray(cycle.speed) == pytest.approx([40 * np.pi, -10 * np.pi], rel=ROUNDED)
    assert np.asarray(cycle.load) == pytest.approx([4e3, -1.1e3], rel=ROUNDED)
    odd = DutyCycle([1 / 3, 2.0], [0.1, np.pi], [-1e4 / 7, 0.0])
    again = read_duty_cycle(write_duty_cycle(tmp_path / "again.csv", odd))
    for name in ("duration", "speed", "load"):
        assert np.array_equal(getattr(again, name), getattr(odd, name))


def test_measurements_come_back_exactly_with_gaps(tmp_path):
    mechanism = prsm.load("wu2022")
    measured = Measurements(
        {"drive_torque": [1 / 3, np.nan, 2.5], "efficiency": [0.8, 0.9, np.nan]},
        {"operating_point.load": [1e3 / 3, 2e3, 3e3]},
    )
    path = write_measurements(tmp_path / "measured.csv", measured, mechanism)
    again = read_measurements(path, mechanism)
    for kind in ("values", "conditions"):
        written, read = getattr(measured, kind), getattr(again, kind)
        assert written.keys() == read.keys()
        for name, column in written.items():
            assert np.array_equal(read[name], column, equal_nan=True)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (("time [s],speed [rpm]", "0,1"), "needs time, load, and one of speed and torque"),
        (("time [s],speed [rpm],torque [N m],load [N]", "0,1,2,3"), "needs time, load, and one"),
        (("time [s],sped [rpm],load [N]", "0,1,2"), "row 1, column sped: unknown; did you mean"),
        (("time,speed [rpm],load [N]", "0,1,2"), "column time: has no unit"),
        (("time [s],speed [kg],load [N]", "0,1,2"), "row 1, column speed: unit 'kg'"),
        (("time [s],speed [rpm],load [N]", "0,1,2", "1,=1+1,2"), "row 3, column speed: '=1+1'"),
        (("time [s],speed [rpm],load [N]", "0,1,2", "1,,2"), "row 3, column speed: ''"),
        (("time [s],speed [rpm],load [N]", "0,1,2", "-1,1,2"), "row 3, column time"),
        (
            ("load [N],speed [rpm],time [ms]", "2,1,0", ",,", "2,1,200", "2,1,100"),
            "row 5, column time: 100 ms is not after 200 ms in the row before; give increasing",
        ),
        (("time [s],speed [rpm],load [N]", "0,1,2", "0,1,2"), "row 3, column time: 0 s is not"),
        (("time [s],speed [rpm],load [N]", "0,1,2"), "has one row of numbers; a scenario needs"),
        (("time [s],speed [rpm],load [N]", "0,1,2", "1,1"), "row 3 has 2 cells"),
        (("time [s],time [s],load [N]", "0,1,2"), "column time is there twice"),
    ],
)
def test_errors_name_row_and_column(lines, words, tmp_path):
    path = _text(tmp_path / "wrong.csv", *lines)
    with pytest.raises(prsm.FileError) as error:
        read_scenario(path)
    assert words in str(error.value)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there_and_a_duty_cycle_without_a_load(tmp_path):
    with pytest.raises(prsm.FileError, match="there is no such file"):
        read_duty_cycle(tmp_path / "absent.csv")
    path = _text(tmp_path / "short.csv", "duration [s],speed [rpm]", "1,2")
    with pytest.raises(prsm.FileError, match="has no column load"):
        read_duty_cycle(path)
