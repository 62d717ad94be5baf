"""A file with some numbers changed keeps its order, and the comments of the other lines."""

import difflib

import numpy as np
import pytest
from tomlkit.exceptions import TOMLKitError

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
    assert changed[1].partition("#")[::2] == (changed[1], "")
    assert '"7.25 mm"' in changed[1]
    assert file.dumps(file.loads(edited)) == file.dumps(mechanism)


def test_nothing_to_change_is_the_same_text():
    text = file.example_text("actuator")
    assert edit(text, file.loads(text), by="prsm optimise") == text


def test_a_number_that_the_file_left_to_follow_is_added_in_its_table():
    text = file.example_text("actuator")
    assert "roller_profile_radius =" not in text
    mechanism = apply_settings(file.loads(text), ["roller_profile_radius=7.5 mm", "speed=700 rpm"])
    edited = edit(text, mechanism)
    assert file.dumps(file.loads(edited)) == file.dumps(mechanism)
    # Only the comment that the speed of 1500 rpm had is gone.
    comments, before = (
        [x.partition("#")[2] for x in one.splitlines() if "#" in x] for one in (edited, text)
    )
    before.remove(" 250 mm/s at a lead of 10 mm")
    assert comments == before
    assert 'roller_profile_radius = "7.5 mm"' in edited


#: A screw with comments at every kind of place.
COMMENTED = """# A screw of 24 mm.
title = "Small screw"   # by hand

[operating_point]       # of the rudder
# Hot.
speed = "1500 rpm"      # 250 mm/s
load = "12 kN"          # a fifth of the capacity

[[stage]]
roller_count = 10
[stage.thread]          # five starts
lead = "10 mm"          # pitch 2 mm
starts = 5
roller_radius = "4 mm"  # screw 24 mm in diameter
contact_angle = "45 deg"

[[duty_cycle]]
duration = "10 s"
speed = "150 rpm"
load = "3 kN"           # cruise

[[duty_cycle]]
duration = "2 s"
speed = "1500 rpm"
load = "12 kN"          # gusts

[tolerances]
lead = { lower = "-5 um", upper = "5 um", distribution = "normal", sigmas = 3 }  # +-5 um
"""


def test_a_changed_line_loses_its_comment_and_the_head_names_it():
    mechanism = apply_settings(
        file.loads(COMMENTED), ["lead=11.25 mm", "roller_radius=3.8 mm", "speed=700 rpm"]
    )
    edited = edit(COMMENTED, mechanism, by="prsm optimise")
    assert file.dumps(file.loads(edited)) == file.dumps(mechanism)
    head, body = edited.split("\n\n", 1)
    assert head.splitlines() == [
        "# Changed by prsm optimise: operating_point.speed, stage.thread.lead, "
        "stage.thread.roller_radius.",
        "# The comments of the changed lines were removed; other comments may describe the former "
        "numbers.",
    ]
    expected = COMMENTED
    for old, new in (
        ('speed = "1500 rpm"      # 250 mm/s', 'speed = "700 rpm"'),
        ('lead = "10 mm"          # pitch 2 mm', 'lead = "11.25 mm"'),
        ('roller_radius = "4 mm"  # screw 24 mm in diameter', 'roller_radius = "3.8 mm"'),
    ):
        assert expected.count(old) == 1
        expected = expected.replace(old, new)
    assert body == expected
    # All of these names can be set, and the next edit adds its own head.
    again = edit(edited, apply_settings(mechanism, ["stage.thread.lead=9 mm"]), by="prsm studio")
    assert again.splitlines()[0] == "# Changed by prsm studio: stage.thread.lead."
    assert "# Changed by prsm optimise: operating_point.speed" in again


def test_rows_and_tables_in_one_line_lose_their_comments():
    text = COMMENTED.replace('"12 kN"          # gusts', '"13 kN"').replace("5 um", "6 um")
    edited = edit(COMMENTED, file.loads(text), by="it")
    assert edited.startswith("# Changed by it: duty_cycle.2.load, tolerances.lead.")
    assert "gusts" not in edited
    assert "+-5 um" not in edited
    assert "# cruise" in edited


def test_rows_are_named_by_their_own_number():
    """By the place of a roller, not by its row, as --set names it; else by the row."""
    text = (
        COMMENTED.partition("[[duty_cycle]]")[0]
        + """
[[duty_cycle]]
duration = "10 s"
speed = "150 rpm"
load = "3 kN"

[[stage.unequal_roller]]
number = 3
stiffness_factor = 0.9  # soft
"""
    )
    other = text.replace("factor = 0.9", "factor = 0.8").replace("3 kN", "4 kN")
    edited = edit(text, file.loads(other), by="it")
    names = edited.splitlines()[0].removeprefix("# Changed by it: ").removesuffix(".").split(", ")
    assert names == ["stage.unequal_roller.3.stiffness_factor", "duty_cycle.1.load"]
    apply_settings(file.loads(text), [f"{names[0]}=0.7"])
    assert "soft" not in edited


def test_what_the_library_of_edits_cannot_read_is_written_anew(monkeypatch):
    def refuse(_):
        raise TOMLKitError("Key already exists.")

    monkeypatch.setattr("tomlkit.parse", refuse)
    mechanism = apply_settings(file.loads(COMMENTED), ["lead=11.25 mm"])
    edited = edit(COMMENTED, mechanism, by="it")
    assert "# The file was written anew, without the comments" in edited
    assert file.dumps(file.loads(edited)) == file.dumps(mechanism)


def test_a_truth_value_loses_its_comment():
    text = COMMENTED + "\n[optimise]\nmaximise = 'efficiency'\navoid_warnings = false  # yet\n"
    text += "\n[[optimise.variable]]\nname = 'lead'\nlower = '9 mm'\nupper = '11 mm'\n"
    edited = edit(text, file.loads(text.replace("false", "true")))
    assert "avoid_warnings = true\n" in edited
    assert "yet" not in edited


def test_a_file_written_anew_says_that_its_comments_are_gone(monkeypatch):
    monkeypatch.setattr("prsm_jax.file._edit._change", lambda *_: None)
    mechanism = apply_settings(file.loads(COMMENTED), ["lead=11.25 mm"])
    assert edit(COMMENTED, mechanism, by="it") == (
        "# Changed by it: stage.thread.lead.\n"
        "# The file was written anew, without the comments that it had.\n\n" + file.dumps(mechanism)
    )


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
