"""The axis in a report: its table against SI numbers, converted by `pint`."""

import dataclasses
import json
import math
from pathlib import Path

import jax.numpy as jnp
import pytest
import reading_scenes as made
import scenes
from expectations import reads
from present import present
from reading_tables import assert_table

from prsm_jax.report import ReportData
from prsm_jax.report.document._sections import report_sections
from prsm_jax.report.results import _analyse

#: Words, units and numbers at odds, of the axis before and after an optimisation.
_ROWS = {
    "first_axial_frequency": ("first axial frequency", "Hz", 202.31, 0.31e3),
    "first_torsional_frequency": ("first torsional frequency", "Hz", 1138.2, 2211.0),
    "antiresonance_frequency": ("anti-resonance, motor held", "Hz", 97.13, 103.7),
    "position_loop_frequency": ("position loop", "Hz", 31.77, 29.13),
    "servo_stiffness": ("servo stiffness at the load", "N/m", 1.8677e8, 2.213e8),
    "held_motor_stiffness": ("stiffness with the motor held", "N/m", 3.311e7, 4.417e7),
}


def _vibration(data):
    return {one.anchor: one for one in report_sections(data)}.get("vibration")


def _numbers(at):
    return {name: jnp.asarray(row[at]) for name, row in _ROWS.items()}


@pytest.fixture(scope="module")
def mechanism():
    return scenes.example("actuator_axis")


@reads("section", "vibration_section")
def test_table_of_the_axis(mechanism):
    data = ReportData(mechanism=mechanism, title="A title", axis=_numbers(2))
    section = present(_vibration(data))
    (table,) = section.tables
    assert table.caption == "Axis"
    rows = [(words, (value, unit)) for words, unit, value, _ in _ROWS.values()]
    assert_table(table, ("", "value"), rows)
    assert "[axis]" in section.paragraphs[0]
    # With the bending–torsional model, behind its table.
    both = present(_vibration(dataclasses.replace(data, modes=(made.modes(),))))
    assert [one.caption for one in both.tables] == ["Natural frequencies", "Axis"]


def test_table_of_the_axis_before_and_after_an_optimisation(mechanism):
    after = ReportData(mechanism=mechanism, title="after", axis=_numbers(3))
    data = ReportData(mechanism=mechanism, title="x", axis=_numbers(2), improved=after)
    rows = [(words, (one, unit), (two, unit)) for words, unit, one, two in _ROWS.values()]
    (table,) = present(_vibration(data)).tables
    assert_table(table, ("", "value", "after the optimisation"), rows)


def test_a_frequency_without_a_mode_is_none(mechanism):
    axis = {"first_axial_frequency": jnp.asarray(math.inf)}
    data = ReportData(mechanism=mechanism, title="x", axis=axis)
    assert present(_vibration(data)).tables[0].rows == (("first axial frequency", "none"),)


def test_the_axis_of_an_analysis_has_the_numbers_of_the_example(mechanism):
    found = present(_analyse._axis(mechanism))
    assert set(_ROWS) < set(found)
    stored = json.loads((Path(__file__).parents[1] / "golden/actuator_axis.json").read_text())
    for name, value in found.items():
        assert float(value) == pytest.approx(stored[name], rel=1e-6)


def test_nothing_is_computed_without_an_axis(mechanism, monkeypatch):
    def fails(*_):
        raise AssertionError

    monkeypatch.setattr(_analyse, "compute", fails)
    monkeypatch.setattr(_analyse, "available_quantities", fails)
    bare = dataclasses.replace(mechanism, axis=None)
    assert _analyse._axis(bare) is None
    assert _vibration(ReportData(mechanism=bare, title="x")) is None


def test_data_that_the_axis_lacks_are_told(mechanism):
    stage = mechanism.stages[0]
    stage = dataclasses.replace(stage, screw=dataclasses.replace(stage.screw, length=None))
    parts = _analyse._Parts()
    assert (
        parts.attempt("axis", _analyse._axis, dataclasses.replace(mechanism, stages=(stage,)))
        is None
    )
    ((part, reason),) = parts.left_out
    assert part == "axis"
    assert "stage.screw.length" in reason
