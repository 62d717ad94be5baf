"""Unequal rollers, roller pins, anisotropic supports and damping: read, set, named, refused."""

import jax
import pytest

import prsm_jax.file as file
from prsm_jax._errors import FileError, UnknownNameError
from prsm_jax.mechanism import (
    RayleighDamping,
    all_parameters,
    check_independent,
    get_parameter,
    set_parameter,
)
from tests.present import present

TEXT = file.example_text("actuator").replace(
    "[stage.thread]",
    """[[stage.unequal_roller]]
number = 2
stiffness_factor = 0.9
mass_factor = 1.02

[[stage.unequal_roller]]
number = 3
position_offset = "0.5 deg"

[[stage.unequal_roller]]
number = 5
missing = true

[stage.damping]
law = "rayleigh"
mass_coefficient = "20 1/s"
stiffness_coefficient = "0.2 us"

[stage.roller.support]
radial_stiffness = "3 N/um"

[stage.thread]""",
    1,
)


@pytest.fixture(scope="module")
def mechanism():
    """The actuator with a softer, a displaced and a missing roller."""
    return file.loads(TEXT)


def test_what_a_file_says_is_what_the_stage_has(mechanism):
    stage = mechanism.stages[0]
    assert (stage.roller_count, stage.present_roller_count) == (10, 9)
    assert [roller.number for roller in stage.unequal_roller] == [2, 3, 5]
    assert [roller.missing for roller in stage.unequal_roller] == [False, False, True]
    assert isinstance(stage.damping, RayleighDamping)
    assert float(stage.damping.stiffness_coefficient) == 2e-7
    assert float(stage.roller.support.radial_stiffness) == 3e6


def test_what_is_written_reads_back(mechanism, identical):
    text = file.dumps(mechanism)
    assert text.count("[[stage.unequal_roller]]") == 3
    assert "missing = true" in text
    assert "missing = false" not in text
    assert identical(mechanism, file.loads(text))


def test_numbers_of_unequal_rollers_have_names(mechanism):
    path = "stage.1.unequal_roller.2.stiffness_factor"
    assert path in {parameter.path for parameter in all_parameters(mechanism)}
    for name in (path, "unequal_roller.2.stiffness_factor", "stiffness_factor"):
        moved = set_parameter(mechanism, name, 0.7)
        assert float(get_parameter(moved, path)) == 0.7
    moved = file.apply_settings(mechanism, ["unequal_roller.3.position_offset=-1 deg"])
    assert float(present(moved.stages[0].unequal_roller[1].position_offset)) < 0
    # Which roller it is, and whether it is there, is structure and not a number.
    assert not any(
        parameter.path.endswith((".number", ".missing")) for parameter in all_parameters(mechanism)
    )
    with pytest.raises(UnknownNameError, match=r"unequal_roller\.4"):
        get_parameter(mechanism, "stage.1.unequal_roller.4.stiffness_factor")


def test_numbers_of_unequal_rollers_are_differentiable(mechanism):
    name = "unequal_roller.2.mass_factor"
    rate = jax.jacfwd(lambda value: get_parameter(set_parameter(mechanism, name, value), name))
    assert float(rate(1.0)) == 1.0


def test_independence_is_checked_by_roller(mechanism):
    check_independent(mechanism, ["stiffness_factor", "mass_factor", "lead"])
    with pytest.raises(ValueError, match=r"both set stage\.1\.unequal_roller\.2\.mass_factor"):
        check_independent(mechanism, ["mass_factor", "unequal_roller.2.mass_factor"])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("number = 2", "number = 0", r"1: number = 0: must be a whole number from 1"),
        ("number = 2", "number = 12", "has number 12, but roller_count is 10; choose"),
        ("number = 2", "number = 3", "unequal_roller 3 is given twice"),
        ("number = 2\n", "", r"number: is missing; give the number of the roller"),
        ("stiffness_factor = 0.9", "stiffness_factor = 0",
         r"\[\[stage\]\] 1 \[\[stage.unequal_roller\]\] 1: stiffness_factor = 0: must be more"),
        ("mass_factor = 1.02", "mass_factor = -1", "mass_factor = -1: must be more than 0"),
        ("mass_factor", "mas", r"mas = 1.02: unknown key; known: .*mass_factor"),
        ('"0.5 deg"', '"100 deg"', "between -90 and 90 deg"),
        ("missing = true", "missing = 1", "missing = 1: must be true or false"),
        ("missing = true", "missing = true\nmass_factor = 1", "is missing and has mass_factor"),
        ("missing = true", "", "unequal_roller 5 has only its number; give"),
        ("missing = true", "missing = false", "unequal_roller 5 has only its number"),
        ('"3 N/um"', '"3 N/um"\ntorsional_stiffness = 1', "roller turns freely on its pins"),
        ('"3 N/um"', '"3 N/um"\nradial_stiffness_y = 1', "the pins of a roller are isotropic"),
        ("radial_stiffness = \"3 N/um\"", "radial_stiffness_y = 1", "but no radial_stiffness"),
        ('"20 1/s"', '"-20 1/s"', "mass_coefficient = .*must be 0 or more"),
        ('"20 1/s"', '"20 s"', "mass_coefficient = .*wrong unit"),
        ('"rayleigh"', '"reyleigh"', 'choose one of "modal", "rayleigh", "structural"'),
        ('law = "rayleigh"\nmass_coefficient = "20 1/s"\nstiffness_coefficient = "0.2 us"',
         'law = "modal"\nratio = 1', "ratio = 1: must be 0 or more and less than 1"),
        ('law = "rayleigh"\nmass_coefficient = "20 1/s"\nstiffness_coefficient = "0.2 us"',
         'law = "structural"\nloss_factor = -0.1', "loss_factor = -0.1: must be from 0 to 1"),
    ],
)  # fmt: skip
def test_one_line_says_what_is_wrong(old, new, message):
    assert old in TEXT
    with pytest.raises(FileError, match=message) as caught:
        file.loads(TEXT.replace(old, new, 1))
    assert str(caught.value).isprintable()


def test_no_roller_left_is_refused():
    rows = "".join(f"[[stage.unequal_roller]]\nnumber = {n}\nmissing = true\n" for n in (1, 2))
    text = file.example_text("actuator").replace("roller_count = 10", "roller_count = 2")
    with pytest.raises(FileError, match="all 2 rollers are missing"):
        file.loads(text.replace("[stage.thread]", rows + "[stage.thread]", 1))
