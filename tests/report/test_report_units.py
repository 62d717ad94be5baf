"""Numbers as engineers write them."""

import math

import pytest

from prsm_jax.quantities import catalogue
from prsm_jax.text._display_units import display_unit, number, show, trimmed


@pytest.mark.parametrize(
    ("value", "unit", "quantity", "expected"),
    [
        (0.024, "m", "", "24.00\u202fmm"),
        (3.956e-6, "m", "", "3.956\u202fµm"),
        (math.pi / 4, "rad", "", "45.00\u202fdeg"),
        (1500 * math.pi / 30, "rad/s", "", "1500\u202frpm"),
        (12e3, "N", "", "12.00\u202fkN"),
        (85.22, "N", "", "85.22\u202fN"),
        (2.092e9, "Pa", "", "2092\u202fMPa"),
        (3e8, "N/m", "", "300.0\u202fN/µm"),
        (293.3, "Hz", "", "293.3\u202fHz"),
        (22838.8, "Hz", "", "22.84\u202fkHz"),
        (0.8526, "1", "efficiency", "85.26\u202f%"),
        (0.374, "1", "carrier_ratio", "0.3740"),
        (-0.3521, "m/s", "", "\N{MINUS SIGN}352.1\u202fmm/s"),
        (2.3e-4, "s", "", "0.2300\u202fms"),
        (0.0197, "kg", "", "19.70\u202fg"),
        (0.0, "m", "", "0\u202fmm"),
    ],
)
def test_display(value, unit, quantity, expected):
    assert show(value, unit, quantity) == expected


def test_numbers_that_cannot_be_shown_plainly():
    assert number(math.nan) == "not defined"
    assert number(math.inf) == "∞"
    assert number(1.23e-15, 3) == "1.23·10⁻¹⁵"
    assert number(-4.5e9, 2) == "\N{MINUS SIGN}4.5·10⁹"
    assert trimmed(16.0) == "16"
    assert trimmed(5.65685) == "5.657"


def test_every_unit_of_the_catalogue_can_be_shown():
    for quantity in catalogue():
        unit = display_unit(quantity.unit, 1.0, quantity.name)
        assert math.isfinite(unit(1.0))
        # Nothing falls back to the bare SI unit because the table forgot it.
        assert quantity.unit == "1" or unit.label
