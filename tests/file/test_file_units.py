"""Numbers with units: exact both ways, strict about dimensions."""

import contextlib
import math
from fractions import Fraction

import pytest
from hypothesis import given, settings, strategies as st
from scenes import example

from prsm_jax.fields import ANY, NOT_NEGATIVE, limit_of
from prsm_jax.file.numbers._numbers import bare_number, read_number, read_quantity, write_number
from prsm_jax.file.numbers._units import WRITTEN_UNITS, unit_factor
from prsm_jax.mechanism import all_parameters

_FINITE = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("24 mm", "m", 0.024),
        ("24mm", "m", 0.024),
        ("  24   mm ", "m", 0.024),
        ("0.325 mm", "m", 0.000325),
        ("1 in", "m", 0.0254),
        ("45 deg", "rad", math.pi / 4),
        ("45°", "rad", math.pi / 4),
        ("1000 rpm", "rad/s", 1000 * 2 * math.pi / 60),
        ("-1500 rpm", "rad/s", -50 * math.pi),
        ("7 kN", "N", 7000.0),
        ("51.94 kg mm^2", "kg·m²", 51.94e-6),
        ("51.94 kg*mm**2", "kg·m²", 51.94e-6),
        ("51.94 kg·mm²", "kg·m²", 51.94e-6),
        ("25 N s/m", "N·s/m", 25.0),
        ("25 N·s / m", "N·s/m", 25.0),
        ("25 N s m^-1", "N·s/m", 25.0),
        ("7.85 g/cm^3", "kg/m³", 7850.0),
        ("207.8 N/µm", "N/m", 2.078e8),
        ("207.8 N/um", "N/m", 2.078e8),
        ("5e-3 ms", "s", 5e-6),
        ("1 1/s", "Hz", 1.0),
        ("0.5", "1", 0.5),
        ("5 percent", "1", 0.05),
        ("5 %", "1", 0.05),
        ("91%", "1", 0.91),
    ],
)
def test_units_read(text, unit, value):
    assert read_quantity(text, unit) == pytest.approx(value, rel=2.3e-16)


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        ("10 kg", "m", "wrong unit: a mass where a length is expected"),
        ("10", "m", "wrong unit: a plain number where a length is expected"),
        ("25 Hz", "rad/s", "wrong unit: a frequency where an angular speed is expected"),
        ("1 N m/rad", "N/m", "wrong unit: a stiffness in rotation where a stiffness is expected"),
        ("1 deg", "1", "wrong unit: an angle where a plain number is expected"),
        ("1 m^9/s", "m", r"wrong unit: length\^9 time\^-1 where"),
        ("10 furlong", "m", "there is no unit 'furlong' here"),
        ("mm", "m", "not a number with a unit"),
        ("", "m", "not a number with a unit"),
        ("nan mm", "m", "not a number with a unit"),
        ("1_000 mm", "m", "cannot read the unit"),
        ("9**9**9**9 mm", "m", "cannot read the unit"),
        ("1 mm^99999999", "m", "cannot read the unit"),
        ("1 mm*", "m", "cannot read the unit"),
        ("1 (mm)", "m", "cannot read the unit"),
        ("1 " + "mm*" * 100, "m", "not a number with a unit"),
        ("1 " + "mm*" * 30, "m", "too long"),
        ("1" * 100 + " mm", "m", "not a number with a unit"),
        ("1e99999 mm", "m", "there is no unit 'e' here"),
        ("1 __import__", "m", "cannot read the unit"),
        ("10,5 mm", "m", r"^decimal comma; write 10\.5 mm$"),
        ("0,05", "1", r"^decimal comma; write 0\.05$"),
        ("1,500 rpm", "rad/s", "write 1.500 rpm, or 1500 rpm if the comma separates thousands"),
        ("1 m%", "m", "cannot read the unit"),
        ("1,234.5 N", "N", r"^comma between digits; write 1234\.5 N$"),
        ("-12,345,678", "1", r"^comma between digits; write -12345678$"),
        *(
            (text, "m", r"^commas between digits; give one number, with a decimal point$")
            for text in ("1,2,3 mm", "0,5,10", "9,81,", "1,23.4 mm", "1,234.5.6", "12,5 N,m")
        ),
    ],
)
def test_units_refused(text, unit, message):
    with pytest.raises(ValueError, match=message):
        read_quantity(text, unit)


@settings(max_examples=500, deadline=None)
@given(_FINITE, st.sampled_from([*WRITTEN_UNITS, "1"]))
def test_any_double_survives_in_any_unit(value, unit):
    text = bare_number(value) if unit == "1" else write_number(value, unit)
    read = read_number(text[1:-1] if text[0] == '"' else float(text), unit, ANY)
    assert read.hex() == value.hex()
    assert len(text) < 50


@settings(max_examples=200, deadline=None)
@given(st.decimals(-1000, 1000, places=3), st.sampled_from(list(WRITTEN_UNITS)))
def test_reading_is_correctly_rounded(number, unit):
    for written in WRITTEN_UNITS[unit]:
        exact = Fraction(number) * unit_factor(written)[0]
        assert read_quantity(f"{number} {written}", unit) == float(exact)


@settings(max_examples=300, deadline=200)
@given(st.text(max_size=300))
def test_any_text_is_read_or_refused(text):
    with contextlib.suppress(ValueError):
        assert isinstance(read_quantity(text, "m"), float)


@settings(max_examples=200, deadline=200)
@given(
    st.from_regex(
        r"[0-9e.+-]{1,12} ?[a-zµ°]{1,4}([*/ ^²·-]{1,2}[a-z0-9]{1,3}){0,4}", fullmatch=True
    )
)
def test_near_units_are_read_or_refused(text):
    with contextlib.suppress(ValueError):
        assert isinstance(read_quantity(text, None), float)


def test_limits_are_those_that_a_field_declares_or_its_unit_has():
    limits = {p.path: p.limit for p in all_parameters(example("li2020_two_stage"))}

    def admits(name, value):
        return limits[name if name in limits else f"stage.1.{name}"].admits(value)

    assert not admits("thread.lead", 0.0)
    assert not admits("thread.pitch", 1.1)
    assert not admits("thread.flank_angle", math.pi / 2)
    assert not admits("thread.contact_angle", math.pi / 2)
    assert not admits("thread.starts", 2.0)
    assert admits("operating_point.load", -1.0)
    assert not admits("operating_point.load", math.inf)
    assert not admits("material.poisson_ratio", 0.5)
    assert not limit_of("m").admits(0.0)
    assert limit_of("m", NOT_NEGATIVE).admits(0.0)


def test_every_unit_is_defined_once(caplog):
    """Pint only logs a second definition, and a log record would end up on stderr."""
    from prsm_jax.file.numbers import _units

    _units._registry.__wrapped__()
    assert caplog.text == ""
