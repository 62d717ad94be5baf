"""The [scenario] table: any scenario survives, and what is wrong is one line."""

import dataclasses
import re
import typing
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from scenes import mechanism

import prsm_jax.file as file
from prsm_jax._errors import FileError
from prsm_jax.fields import ANY, POSITIVE, declared
from prsm_jax.mechanism import find_parameters, set_parameter
from prsm_jax.scenario import (
    ConstantProfile,
    HingeLoad,
    Profile,
    Scenario,
    SequenceProfile,
    SumLoad,
    TorqueScenario,
)
from prsm_jax.scenario._loads import LoadOfMotion
from tests.present import present

MISSION = file.example_text("actuator_mission")


def _limit(cls, name):
    (field,) = [field for field in declared(cls) if field.name == name]
    return field.limit


def _numbers(limit=ANY):
    return st.floats(max(limit.lower, -1e60), min(limit.upper, 1e60)).filter(limit.admits)


def _increasing():
    found = st.lists(st.floats(0, 1e6), min_size=2, max_size=5, unique=True).map(sorted)
    return found.filter(lambda times: np.all(np.diff(times) > 0)).map(np.array)


@st.composite
def _functions(draw, kinds, depth=2):
    """A profile or a load of some kind, with parts if it has them."""
    cls = draw(st.sampled_from(list(kinds)))
    values = {}
    for field in dataclasses.fields(cls):
        name = field.name
        if name == "part":
            values["part"] = tuple(draw(_parts(cls, kinds, depth)))
        elif name in ("times", "positions"):
            values[name] = draw(_increasing())
        elif name == "values":
            size = len(present(values.get("times", values.get("positions"))))
            values[name] = np.array(
                draw(st.lists(st.floats(-1e6, 1e6), min_size=size, max_size=size))
            )
        elif name == "interpolation":
            values[name] = draw(st.sampled_from(["linear", "cubic", "monotone"]))
        elif name == "repeats":
            values[name] = draw(st.integers(1, 5))
        elif name == "reversing":
            values[name] = draw(st.booleans())
        elif name == "angle_moved":
            values[name] = draw(
                st.floats(1e-3, 1e6).map(lambda a: a * draw(st.sampled_from([1, -1])))
            )
        elif name == "hold_time":
            values[name] = draw(st.floats(1e-9, 1e60))
        elif field.default is None and draw(st.booleans()):
            continue
        else:
            values[name] = draw(_numbers(_limit(cls, name)))
    return cls(**values)


def _parts(cls, kinds, depth):
    inner = [k for k in kinds if depth > 0 or k not in (SequenceProfile, SumLoad)]
    if cls is SequenceProfile:
        inner = [k for k in inner if hasattr(k, "duration")]
    one = _functions(tuple(inner), depth - 1)
    if cls is SumLoad:
        one = st.one_of(one, st.floats(-1e60, 1e60))
    return st.lists(one, min_size=1, max_size=2)


_OF_SPEED, _LOADS_OF_MOTION = typing.get_args(Profile), typing.get_args(LoadOfMotion)
_OF_OTHERS = tuple(cls for cls in _OF_SPEED if not cls.kind.endswith("_move"))
_LOADS = st.one_of(_numbers(), _functions(_OF_OTHERS + _LOADS_OF_MOTION))


@st.composite
def scenarios(draw):
    """Any scenario that a file can hold."""
    duration, samples = draw(_numbers(POSITIVE)), draw(st.integers(2, 1000))
    position = draw(_numbers())
    if draw(st.booleans()):
        speed = draw(st.one_of(_numbers(), _functions(_OF_SPEED)))
        return Scenario(speed, draw(_LOADS), duration, draw(_numbers()), samples, position)
    torque = draw(st.one_of(_numbers(), _functions(_OF_OTHERS)))
    start = draw(_numbers())
    phases = draw(st.integers(1, 1000))
    return TorqueScenario(torque, draw(_LOADS), duration, start, position, samples, phases)


@pytest.mark.filterwarnings("ignore:Do not use the `random` module inside strategies")
@settings(max_examples=40, deadline=None, suppress_health_check=tuple(HealthCheck))  # pyright: ignore[reportArgumentType]
@given(scenarios())
def test_any_scenario_survives_exactly(identical, scenario):
    whole = dataclasses.replace(mechanism(), scenario=scenario)
    assert identical(whole, file.loads(file.dumps(whole)))


def test_every_kind_can_be_written():
    """No profile or load whose fields the table does not know."""
    for cls in (*_OF_SPEED, *_LOADS_OF_MOTION):
        hints = typing.get_type_hints(cls)
        for field in dataclasses.fields(cls):
            known = "unit" in field.metadata or field.name == "part"
            assert known or hints[field.name] in (int, bool) or field.name == "interpolation"


def test_a_function_that_a_file_cannot_hold():
    whole = dataclasses.replace(mechanism(), scenario=Scenario(lambda t: t, HingeLoad(), 1.0))
    with pytest.raises(FileError, match=r"scenario\.speed is a function, which a file cannot hold"):
        file.dumps(whole)


#: What is replaced in the mission's text, by what, and what the error says after the file name.
CASES = [
    ('duration = "2 s"', "", r"\[scenario\]: duration: is missing; give the length"),
    ('duration = "2 s"', 'duration = "0 s"', r"\[scenario\]: duration = .* more than 0"),
    ('duration = "2 s"', 'duration = "2 s"\ntorque = 1', "either speed or torque; found both"),
    ("samples = 401", "samples = 1", r"samples = 1: must be a whole number from 2"),
    ("samples = 401", "sample = 401", r"\[scenario\]: sample = 401: unknown key; did you mean s"),
    ('kind = "sequence"', 'kind = "sequense"', r'\[scenario.speed\]: kind = .*: choose one of "si'),
    ('kind = "sequence"', "", r"\[scenario.speed\]: kind: is missing; choose one of"),
    ("repeats = 2", "repeats = 0", "repeats = 0: must be a whole number from 1"),
    ("reversing = true", "reversing = 1", "reversing = 1: must be true or false"),
    ('angle_moved = "3 turn"', 'angle_moved = "3 mm"',
     r"\[\[scenario.speed.part\]\] 1: angle_moved = .*: wrong unit: a length where an angle"),
    ('angle_moved = "3 turn"', "angle_moved = 0",
     r"speed.part\]\] 1: angle_moved = 0: must be finite and not 0"),
    ('speed_limit = "1500 rpm"', "speed_limit = -1", "speed_limit = -1: must be more than 0"),
    ('jerk_limit = "100000 rad/s^3"', 'jerk_limit = "1 rad/s^2"', "an angular acceleration where"),
    ('stiffness_per_pressure = "20 m"', "", "1: stiffness_per_pressure: is missing; give"),
    ('dynamic_pressure = "20 kPa"', 'dynamic_pressure = "20 kN"', "a force where a pressure"),
    ('dynamic_pressure = "20 kPa"', 'dynamic_pressure = {kind = "hinge"}', 'choose one of "sine"'),
    ('mass = "40 kg"', 'mass = "-40 kg"', r"mass = .* 0 or more"),
    ('amplitude = "1 kN"', 'amplitude = "1 Nm"', "there is no unit 'Nm' here"),
    ('kind = "sum"', 'kind = "s_curve_move"', r"\[scenario.load\]: kind = .*: choose one of"),
    ("[scenario.load] ", "[scenario.lode] ", r"\[scenario.lode\]: unknown key; did you mean lo"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), CASES)
def test_one_line_says_what_is_wrong(old, new, message):
    at = MISSION.index("[scenario]")
    rest = MISSION[at:]
    assert old in rest
    with pytest.raises(FileError) as caught:
        file.loads(MISSION[:at] + rest.replace(old, new, 1), name="my.toml")
    line = str(caught.value)
    assert line.startswith("my.toml: ")
    assert line.isprintable()
    assert re.search(message, line), line


def test_numbers_of_a_scenario_have_full_names():
    """Short names stay those of stages and operating point."""
    mission = file.load("actuator_mission")
    name = "scenario.speed.part.1.speed_limit"
    moved = set_parameter(mission, name, 10.0)
    scenario: Any = moved.scenario
    assert float(scenario.speed.part[0].speed_limit) == 10.0
    assert find_parameters(mission, name)[0].unit == "rad/s"
    assert find_parameters(mission, "scenario.load.part.2.amplitude")[0].unit == "N"
    (speed,) = find_parameters(mission, "speed")
    assert speed.path == "operating_point.speed"
    longer = file.apply_settings(mission, ["scenario.duration=3 s", "scenario.samples=11"])
    assert float(longer.scenario.duration) == 3.0
    assert longer.scenario.samples == 11


def test_a_sequence_in_a_sequence():
    part = SequenceProfile((ConstantProfile(1.0, 0.5),), 2, True)
    whole = dataclasses.replace(mechanism(), scenario=Scenario(SequenceProfile((part,)), 1.0, 1.0))
    text = file.dumps(whole)
    assert "[[scenario.speed.part.part]]" in text
    scenario: Any = file.loads(text).scenario
    assert scenario.speed.part[0].reversing
