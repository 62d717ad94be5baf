"""The inputs of a report: every number of the file, converted by `pint`, and what was assumed."""

import dataclasses
import tomllib

import pint
import pytest

from prsm_jax import file, set_parameter
from prsm_jax.report import Origin, ReportData, origin_of_file
from prsm_jax.report.document._inputs_section import inputs_section

_REGISTRY = pint.UnitRegistry()
_UNITS = {"mm·rpm": "mm*rpm", "N/µm": "N/µm", "kg·mm²": "kg*mm**2", "kg/m³": "kg/m**3"}


def _si(text: str) -> float | None:
    """A printed number in SI; `None` for words."""
    number, _, label = text.replace("\N{MINUS SIGN}", "-").partition("\N{NARROW NO-BREAK SPACE}")
    try:
        value = float(number)
    except ValueError:
        return None
    words = _UNITS.get(label, label.replace("·", "*"))
    return float(_REGISTRY.Quantity(value, words or "dimensionless").to_base_units().magnitude)


def _leaves(table, path=()):
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _leaves(value, (*path, key))
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            continue
        else:
            yield (*path, key), value


def _shown(mechanism, name, **more):
    data = ReportData(mechanism, "x", source=name, origin=origin_of_file(name), **more)
    found = {}
    for table in inputs_section(data).tables:
        if table.head == ("input", "value", "meaning", "source"):
            for key, value, meaning, source in table.rows:
                place = (*table.caption.strip("[]").split("."), key.replace(" ", "_"))
                found[place] = (value, meaning, source)
    return found


@pytest.mark.parametrize("name", ["actuator", "wu2022", "li2020_two_stage", "ring_roller"])
def test_every_input_of_the_file_is_shown(name):
    """Read by `tomllib` and converted by `pint`, neither by the package."""
    mechanism, shown = file.load(name), _shown(file.load(name), name)
    raw = tomllib.loads(file.example_text(name))
    count = len(raw["stage"])
    tables = {("stage" if count == 1 else f"stage {i}",): s for i, s in enumerate(raw["stage"], 1)}
    tables |= {(key,): raw[key] for key in ("operating_point",) if key in raw}
    compared = 0
    for prefix, table in tables.items():
        for path, value in _leaves(table):
            place = (*prefix, *path)
            assert place in shown, f"{place} is not shown"
            cell, _, source = shown[place]
            assert source == "file", place
            expected = value
            if isinstance(value, str) and value[:1] in "0123456789-+.":
                expected = float(_REGISTRY.Quantity(value).to_base_units().magnitude)
            if isinstance(expected, int | float) and not isinstance(expected, bool):
                # Nine digits are printed.
                assert _si(cell) == pytest.approx(float(expected), rel=1e-8), place
                compared += 1
            elif isinstance(expected, str):
                assert cell == expected, place
    assert compared >= 10
    assert mechanism.title


def test_defaults_are_marked_and_have_their_meaning():
    shown = _shown(file.load("actuator"), "actuator")
    value, meaning, source = shown["stage", "strength", "shaft", "permissible_speed_share"]
    assert (value, source) == ("0.8", "default")
    assert meaning == "permissible share of the critical speed"
    assert shown["stage", "strength", "play", "arrangement"][2] == "default"
    assert shown["stage", "friction", "thread", "coefficient"][2] == "file"


def test_a_changed_setting_is_marked():
    changed = set_parameter(file.load("wu2022"), "lead", 0.012)
    shown = _shown(changed, "wu2022")
    value, _, source = shown["stage", "thread", "lead"]
    assert _si(value) == pytest.approx(0.012)
    assert source == "--set"
    others = {s for place, (*_, s) in shown.items() if place != ("stage", "thread", "lead")}
    assert others == {"file", "default"}


def test_duty_cycle_and_optimisation_are_inputs():
    mechanism = file.load("actuator")
    data = ReportData(mechanism, "x", source="actuator", origin=origin_of_file("actuator"))
    tables = {table.caption: table for table in inputs_section(data).tables}
    cycle = tables["[[duty_cycle]]"]
    assert cycle.head == ("phase", "duration in s", "speed in rpm", "load in kN")
    raw = tomllib.loads(file.example_text("actuator"))
    for row, phase in zip(cycle.rows, raw["duty_cycle"], strict=True):
        wanted = [
            _REGISTRY.Quantity(phase[key]).to(unit).magnitude
            for key, unit in (("duration", "s"), ("speed", "rpm"), ("load", "kN"))
        ]
        assert [float(cell) for cell in row[1:]] == pytest.approx(wanted, rel=1e-8)
    limits = {row[0]: row[1] for row in tables["[optimise] constraints"].rows}
    words, _, cell = limits["max pressure shared"].rpartition("most ")
    assert words == "at "
    assert _si(cell) == pytest.approx(2.1e9)
    bounds = {row[0]: row[1:] for row in tables["[optimise] variables"].rows}
    assert [_si(cell) for cell in bounds["lead"]] == pytest.approx([0.005, 0.02])


def test_without_a_file_there_is_no_source():
    data = ReportData(file.load("wu2022"), "x", origin=Origin())
    section = inputs_section(data)
    assert {table.head for table in section.tables} == {("input", "value", "meaning")}
    assert "the sources of its values are not known" in " ".join(section.paragraphs)
    assert dataclasses.replace(data).source == ""
