"""Nothing that a file can contain raises anything but FileError, or takes long."""

import json
from datetime import timedelta

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import prsm_jax.file as file
from prsm_jax._errors import FileError
from prsm_jax.mechanism import Mechanism

TEXTS = {name: file.example_text(name) for name in file.example_names()}
KEYS = sorted(
    {
        line.split("=")[0].strip()
        for text in TEXTS.values()
        for line in text.splitlines()
        if "=" in line
    }
)
fuzz = settings(
    max_examples=150,
    # Generous for a loaded machine with every annotation checked: against hanging, not slowness.
    deadline=timedelta(seconds=10),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)


@pytest.fixture(scope="module", autouse=True)
def actuator():
    """Read once: the first reading builds the schema."""
    return file.load("actuator")


def complaint(call) -> str:
    """The text of the FileError of a call; empty if the call gives a mechanism."""
    try:
        result = call()
    except FileError as error:
        return str(error)
    assert isinstance(result, Mechanism)
    return ""


def read_or_refuse(text: str):
    said = complaint(lambda: file.loads(text, name="fuzz.toml"))
    assert not said or (said.startswith("fuzz.toml: ") and said.isprintable())


@fuzz
@given(st.text())
def test_any_text(text):
    read_or_refuse(text)


@fuzz
@given(st.binary())
def test_any_bytes(tmp_path, data):
    path = tmp_path / "fuzz.toml"
    path.write_bytes(data)
    with pytest.raises(FileError):
        file.load(path)


@st.composite
def mutated(draw):
    """An example with lines dropped, doubled, swapped, or characters replaced."""
    lines = draw(st.sampled_from(sorted(TEXTS.values()))).splitlines()
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(lines) - 1))
        match draw(st.integers(0, 4)):
            case 0:
                lines[at] = ""
            case 1:
                lines.insert(at, lines[draw(st.integers(0, len(lines) - 1))])
            case 2:
                start = draw(st.integers(0, len(lines[at])))
                stop = draw(st.integers(start, len(lines[at])))
                lines[at] = lines[at][:start] + draw(st.text(max_size=5)) + lines[at][stop:]
            case 3:
                key = lines[at].partition("=")[0]
                value = draw(st.one_of(st.floats(), st.integers(), st.booleans(), st.text()))
                lines[at] = f"{key}= {json.dumps(value)}"
            case 4:
                number = draw(st.floats(allow_nan=False))
                unit = draw(st.sampled_from(["mm", "kg", "rpm", "deg", "N/um", "GPa", "x", ""]))
                lines[at] = f'{draw(st.sampled_from(KEYS))} = "{number} {unit}"'
    return "\n".join(lines)


@fuzz
@given(mutated())
def test_mutated_examples(text):
    read_or_refuse(text)


def _toml(value) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {_toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


_KEY = st.one_of(
    st.sampled_from([*KEYS, "stage", "thread", "screw", "support", "friction", "optimise"]),
    st.text(max_size=5),
)
_VALUE = st.recursive(
    st.one_of(st.integers(), st.floats(), st.booleans(), st.text(max_size=8)),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(_KEY, inner, max_size=4)),
    max_leaves=12,
)


@fuzz
@given(st.dictionaries(_KEY, _VALUE, max_size=5))
def test_any_tables(tables):
    text = "\n".join(f"{json.dumps(key)} = {_toml(value)}" for key, value in tables.items())
    read_or_refuse(text)


@fuzz
@given(_KEY, _VALUE)
def test_any_value_in_a_thread(key, value):
    read_or_refuse(
        f"[[stage]]\nroller_count = 7\n[stage.thread]\n{json.dumps(key)} = {_toml(value)}"
    )


@fuzz
@given(st.text())
def test_any_setting(actuator, setting):
    said = complaint(lambda: file.apply_settings(actuator, [setting]))
    assert said.isprintable()


# Few, because the shape checks of the tests make each look-up of a name a thousand times slower.
@settings(fuzz, max_examples=8)
@given(st.sampled_from(KEYS), st.text(max_size=10), st.floats())
def test_any_value_of_a_setting(actuator, key, text, number):
    for value in (text, number, f"{number} mm", f"{number} {text}"):
        said = complaint(lambda value=value: file.apply_settings(actuator, [f"{key}={value}"]))
        assert said.isprintable()
