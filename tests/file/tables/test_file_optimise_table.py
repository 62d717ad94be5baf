"""Keys of `[optimise]`: series of choices, a range of operating points, options of the method."""

import pytest
import scenes

from prsm_jax import file
from prsm_jax._errors import FileError
from prsm_jax.mechanism import (
    Choice,
    OperatingCase,
    operating_range,
    preferred_numbers,
    standard_leads,
    standard_modules,
)

_TEXT = """[optimise]
maximise = "efficiency"
{}

[[optimise.variable]]
name = "contact_angle"
lower = "35 deg"
upper = "55 deg"
"""


def _whole(keys):
    return file.example_text("wu2022") + "\n" + _TEXT.format(keys)


def _problem(keys):
    """The problem of these keys, which is the same after writing and reading."""
    read = file.loads(_whole(keys))
    assert file.loads(file.dumps(read)).design_problem == read.design_problem
    return read.design_problem


def test_a_series_between_limits():
    problem = _problem(
        "choices = {"
        'gear_module = { series = "modules", lower = "0.3 mm", upper = 0.6e-3 },'
        "roller_teeth = [16, 18],"
        'lead = { series = "leads", lower = "8 mm", upper = "1 cm" },'
        'face_width = { series = "R20", lower = "9 mm", upper = "12 mm" } }'
    )
    assert problem is not None
    assert problem.choices == (
        Choice("gear_module", standard_modules(0.3e-3, 0.6e-3)),
        Choice("roller_teeth", (16.0, 18.0)),
        Choice("lead", standard_leads(8e-3, 10e-3)),
        Choice("face_width", preferred_numbers(9e-3, 12e-3, "R20")),
    )


def test_a_range_is_the_grid_of_operating_points():
    problem = _problem(
        'operating_range = { speeds = [10, 30.0], loads = ["5 kN", "9 kN"], points = 2 }'
    )
    assert problem is not None
    grid = operating_range((10.0, 30.0), (5e3, 9e3), points=2)
    assert problem.operating_points == tuple(OperatingCase(*one) for one in grid)
    # Three points in each direction, unless given; one number is no range.
    problem = _problem('operating_range = { speeds = [10, 30], loads = "5 kN" }')
    assert problem is not None
    assert problem.operating_points == tuple(OperatingCase(v, 5e3) for v in (10.0, 20.0, 30.0))


def test_options_of_the_method():
    problem = _problem('method = "multi-start"\nmethod_options = { steps = 300, keep = 4 }')
    assert problem is not None
    assert problem.method == "multi-start"
    assert problem.method_options == (("steps", 300), ("keep", 4))
    # A whole number stays one: a number of iterations is refused otherwise.
    assert all(isinstance(value, int) for _, value in problem.method_options)
    problem = _problem('method = "adam"\n[optimise.method_options]\nlearning_rate = 0.1')
    assert problem is not None
    assert problem.method_options == (("learning_rate", 0.1),)


_MODULES = 'choices = {{ gear_module = {{ series = "modules", {} }} }}'
_R10 = 'choices = {{ {} = {{ series = "R10", lower = 1, upper = 10 }} }}'
_RANGE = "operating_range = {{ {} }}"
_TWO = "speeds = [10, 30], loads = [5e3, 9e3]"


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ('choices = { lead = "leads" }', r'must be a list of values, or { series = "modules"'),
        (_MODULES.format("lower = 1e-4"), "upper.*is missing; give the upper limit"),
        (_MODULES.format('lower = "1 s", upper = 1'), "lower.*1 s"),
        (_MODULES.format("lower = 1e-3, upper = 1e-4"), "limits of standard modules are 0.001 an"),
        (_MODULES.format("lower = 0.3, upper = 0.4"), "no standard module from 0.3 to 0.4 m"),
        (_MODULES.format("lower = 1e-4, upper = 1e-3, step = 1"), "step.*unknown key"),
        (_R10.replace("R10", "R11").format("lead"), "choose one of .*modules.*leads.*R5.*R40"),
        (_R10.format("roller_count"), "is a whole number, .* list values"),
        (_R10.format("contact_angle"), "moves the same number|is an angle"),
        (_R10.format("pressure_angle"), "is an angle"),
        (_R10.replace("R10", "leads").format("roller_teeth"), "has lengths; list values"),
        (_RANGE.format("speeds = [10, 30]"), "loads.*is missing; give the least and largest load"),
        (_RANGE.format("speeds = [30, 10], loads = 5e3"), "speeds are .*give the lower one first"),
        (_RANGE.format("speeds = [1, 2, 3], loads = 5e3"), "speeds.*must be two numbers"),
        (_RANGE.format('speeds = "5 kN", loads = 5e3'), "speeds.*5 kN"),
        (_RANGE.format(_TWO + ", points = 1"), "points.*a whole number from 2 to 100"),
        (_RANGE.format(_TWO) + "\nnut_speed = 0.1", "operating_range.*both set the speed"),
        (
            _RANGE.format(_TWO) + '\noperating_points = "duty_cycle"',
            "operating_range.*is given beside operating_points; give one",
        ),
        (
            _RANGE.format(_TWO) + "\n[[optimise.operating_point]]\nspeed = 1\nload = 1",
            r"operating_range.*is given beside \[\[optimise.operating_point\]\]",
        ),
        ("method_options = 3", "method_options.*must be a table of options"),
        ('method_options = { steps = "many" }', "steps.*must be a number without a unit"),
        ("method_options = { steps = true }", "steps.*must be a number without a unit"),
        ("method_options = { steps = inf }", "steps.*must be a number without a unit"),
        ('method_options = { "a b" = 1 }', "must be a name of letters"),
        ('method = "multi start"', "method.*must be a name of letters"),
    ],
)
def test_what_is_wrong_is_named(keys, words):
    with pytest.raises(FileError, match=words):
        file.loads(_whole(keys))


def test_an_edited_file_keeps_its_series():
    """Another number changes; the words of the series stay as they were written."""
    row = 'choices = { gear_module = { series = "modules", lower = "0.3 mm", upper = "0.6 mm" } }'
    text = _whole(row)
    moved = file.apply_settings(file.loads(text), ["lead=12 mm"])
    edited = file.edit(text, moved)
    assert row in edited
    assert 'lead = "12 mm"' in edited
    assert scenes.example("wu2022").design_problem is None
