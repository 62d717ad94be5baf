"""The `[tolerances]` table: what it means, what is written, and what is wrong in one line."""

import dataclasses
import math

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import prsm_jax.file as file
from prsm_jax import FileError
from prsm_jax.mechanism import DISTRIBUTIONS, Distribution, Tolerance

TEXT = file.example_text("wu2022")
SMALL = file.loads(
    "[[stage]]\nroller_count = 7\n[stage.thread]\nlead = 0.01\nstarts = 5\n"
    "roller_radius = 0.004\ncontact_angle = 0.8\n"
)


def _read(*lines):
    return file.loads("\n".join((TEXT, "[tolerances]", *lines)))


def test_each_form_of_a_tolerance():
    mechanism = _read(
        'lead = "±0.02 mm"',
        '"thread.coefficient" = "±0.01"',
        "load = 100",
        'contact_angle = { lower = "-0.5 deg", upper = "0.25 deg", distribution = "uniform" }',
        'speed = { lower = "-30 rpm", upper = "0 rpm", sigmas = 2 }',
        "[tolerances.cost]",
        "lead = 2.5",
    )
    found = mechanism.tolerances
    assert file.loads(file.dumps(mechanism)).tolerances == found
    degree, rpm = math.pi / 180, 2 * math.pi / 60
    assert found == (
        Tolerance("lead", -2e-5, 2e-5, cost=2.5),
        Tolerance("thread.coefficient", -0.01, 0.01),
        Tolerance("load", -100.0, 100.0),
        Tolerance("contact_angle", -0.5 * degree, 0.25 * degree, "uniform"),
        Tolerance("speed", -30 * rpm, 0.0, sigmas=2.0),
    )


def test_moments_of_the_distributions():
    """Of a zone of 12 units about 1: uniform 12/√12, triangular 12/√24, normal 6/sigmas."""
    deviations: dict[Distribution, float] = {
        "uniform": 12**0.5,
        "triangular": 6**0.5,
        "normal": 2.0,
    }
    for distribution, deviation in deviations.items():
        one = Tolerance("lead", -5.0, 7.0, distribution)
        assert (one.middle, one.half_width) == (1.0, 6.0)
        assert one.standard_deviation == pytest.approx(deviation, rel=1e-15)
    assert Tolerance("lead", -5.0, 7.0, sigmas=6.0).standard_deviation == 1.0


def test_a_file_without_the_table_has_no_trace_of_it():
    mechanism = file.load("wu2022")
    assert mechanism.tolerances is None
    assert "tolerances" not in file.dumps(mechanism)


_SIDES = st.floats(-1e-3, 1e-3, allow_subnormal=False)


@settings(max_examples=15, deadline=None, suppress_health_check=tuple(HealthCheck))  # pyright: ignore[reportArgumentType]
@given(
    st.tuples(_SIDES, _SIDES).filter(lambda b: b[0] < b[1]),
    st.floats(1e-6, 1e-3),
    st.sampled_from(DISTRIBUTIONS),
    st.floats(0.1, 10.0),
    st.floats(0.1, 1e6),
)
def test_any_table_survives_exactly(sides, half, distribution, sigmas, cost):
    normal = distribution == "normal"
    rows = (
        Tolerance("lead", sides[0], sides[1], distribution, sigmas if normal else 3.0),
        Tolerance("stage.1.thread.contact_angle", -half, half, cost=cost),
        Tolerance("starts", -half, half),
    )
    text = file.dumps(dataclasses.replace(SMALL, tolerances=rows))
    assert file.loads(text).tolerances == rows


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ('lead = "0.02 mm"', '[tolerances]: lead = "0.02 mm": not a tolerance; give "±0.02 mm"'),
        ('lead = "±0.02 kg"', '[tolerances]: lead = "±0.02 kg": wrong unit: a mass where a length'),
        ('lead = "±-1 mm"', "must be more than 0"),
        ("lead = true", "[tolerances]: lead = true: not a number"),
        ('leed = "±1 mm"', "[tolerances]: leed = \"±1 mm\": unknown parameter 'leed'; did you"),
        ('lead = "±20 mm"', "at its lower limit stage.1.thread.lead is out of range"),
        ('lead = "±1 mm"\n"thread.lead" = "±1 mm"', "sets the same number as 'lead'"),
        (
            'thread.lead = "±1 mm"',
            "[tolerances.thread]: give",
        ),
        ('roller_count = "±1"', "a whole number has no tolerance; sweep over it instead"),
        ('lead = { lower = "1 mm" }', "[tolerances.lead]: upper: is missing; give the upper"),
        ("lead = { lower = 0.0, upper = 1e-3, limit = 3 }", "limit = 3: unknown key"),
        ('lead = { lower = "1 mm", upper = "0 mm" }', "is not below upper deviation 0.0; swap"),
        ("lead = { lower = 0.0, upper = 1e-3, sigmas = 0 }", "sigmas = 0: must be more than 0"),
        (
            'lead = { lower = 0.0, upper = 1e-3, distribution = "uniform", sigmas = 2 }',
            "a uniform distribution ends at its limits; remove sigmas",
        ),
        ('lead = { lower = 0.0, upper = 1e-3, distribution = "gauss" }', 'one of "normal", "unif'),
        ("", "[tolerances]: is empty"),
        ('lead = "±1 mm"\ncost = { leed = 1 }', "[tolerances.cost]: leed = 1: unknown key; did"),
        ('lead = "±1 mm"\ncost = { lead = 0 }', "[tolerances.cost]: lead = 0: must be more than 0"),
        ('lead = "±1 mm"\ncost = 3', "must be a table of keys"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(lines, message):
    with pytest.raises(FileError) as error:
        _read(*lines.split("\n"))
    text = str(error.value)
    assert message in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"lower": 1.0, "upper": 1.0}, "lower deviation 1.0 is not below"),
        ({"lower": -math.inf, "upper": 1.0}, "must be finite"),
        ({"lower": -1.0, "upper": 1.0, "sigmas": math.nan}, "sigmas is nan"),
        ({"lower": -1.0, "upper": 1.0, "cost": 0.0}, "cost is 0"),
    ],
)
def test_a_tolerance_made_in_python_is_checked(arguments, message):
    with pytest.raises(ValueError, match=message):
        Tolerance("lead", **arguments)


def test_an_unknown_name_cannot_be_written():
    rows = (Tolerance("leed", -1e-5, 1e-5),)
    with pytest.raises(FileError, match=r"\[tolerances\] table cannot be written: unknown"):
        file.dumps(dataclasses.replace(file.load("wu2022"), tolerances=rows))


@pytest.mark.parametrize("value", ['"±5 %"', '{ lower = "-5 %", upper = "5 %" }'])
def test_a_share_of_a_number_is_no_tolerance(value):
    """5 % would be read as 0.05, of a coefficient of 0.08 more than a half."""
    with pytest.raises(FileError, match=r"5 %' does not say of what; give the deviation"):
        _read(f'"thread.coefficient" = {value}')
