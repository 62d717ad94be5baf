"""A file with some numbers changed keeps its comments and its order."""

import difflib

import numpy as np
import pytest

from prsm_jax import file
from prsm_jax.file import apply_settings, edit, round_in_unit


@pytest.mark.parametrize("name", file.example_names())
def test_only_the_changed_line_differs(name):
    text = file.example_text(name)
    mechanism = apply_settings(file.loads(text), ["stage.1.lead=7.25 mm"])
    edited = edit(text, mechanism)
    changed = [
        line
        for line in difflib.ndiff(text.splitlines(), edited.splitlines())
        if line.startswith(("+", "-"))
    ]
    assert len(changed) == 2
    assert '"7.25 mm"' in changed[1]
    assert file.dumps(file.loads(edited)) == file.dumps(mechanism)


def test_nothing_to_change_is_the_same_text():
    text = file.example_text("actuator")
    assert edit(text, file.loads(text)) == text


def test_a_number_that_the_file_left_to_follow_is_added_in_its_table():
    text = file.example_text("actuator")
    assert "roller_profile_radius =" not in text
    mechanism = apply_settings(file.loads(text), ["roller_profile_radius=7.5 mm", "speed=700 rpm"])
    edited = edit(text, mechanism)
    assert file.dumps(file.loads(edited)) == file.dumps(mechanism)
    assert [x.partition("#")[2] for x in edited.splitlines() if "#" in x] == [
        x.partition("#")[2] for x in text.splitlines() if "#" in x
    ]
    assert 'roller_profile_radius = "7.5 mm"' in edited


def test_another_number_of_stages_is_written_anew():
    one, two = (file.example_text(n) for n in ("li2020_single_stage_viscous", "li2020_two_stage"))
    edited = edit(one, file.loads(two))
    assert file.dumps(file.loads(edited)) == file.dumps(file.loads(two))


def test_a_text_that_says_something_else_is_not_kept(monkeypatch):
    """Whatever goes wrong with single keys, the text describes the mechanism."""
    monkeypatch.setattr("prsm_jax.file._edit._change", lambda *_: None)
    text = file.example_text("actuator")
    mechanism = apply_settings(file.loads(text), ["stage.1.lead=7.25 mm"])
    assert edit(text, mechanism) == file.dumps(mechanism)


@pytest.mark.parametrize(
    ("value", "unit", "digits", "expected"),
    [
        (0.0112071234567, "m", 6, 11.2071e-3),
        (np.deg2rad(48.21834567), "rad", 6, np.deg2rad(48.2183)),
        (1.23456789e-4, "1", 6, 1.23457e-4),
        (0.0, "m", 6, 0.0),
    ],
)
def test_digits_are_those_of_the_unit_that_is_written(value, unit, digits, expected):
    assert round_in_unit(value, unit, digits) == pytest.approx(expected, rel=1e-15, abs=0)
