"""Every unit that numbers are shown in, at every size, turned back by `pint`."""

import pytest
from reading_units import same_dimension, to_si

from prsm_jax.text._display_units import _SHOWN, display_unit, show


@pytest.mark.parametrize("si_unit", _SHOWN)
def test_a_shown_number_is_the_number(si_unit):
    labels = set()
    for power in range(-8, 13):
        value = 1.7 * 10.0**power
        shown = display_unit(si_unit, value)
        labels.add(shown.label)
        assert same_dimension(shown.label, si_unit)
        found = float(to_si(shown(value), shown.label))
        assert found == pytest.approx(float(to_si(value, si_unit)), rel=1e-12)
    # No unit of the table is out of reach.
    assert labels == {one.label for one in _SHOWN[si_unit]}


def test_efficiencies_are_per_cent():
    shown = display_unit("1", 0.85, "efficiency")
    assert (shown(0.85), shown.label) == (pytest.approx(85.0), "%")


@pytest.mark.parametrize("name", ["rating_life", "rating_life[2]", "modified_rating_life"])
def test_lives_are_turns(name):
    """10⁶ (C/F)³ at C/F = 5 is 1.25·10⁸ turns; shares and lives in time have other units."""
    shown = display_unit("1", 1.25e8, name)
    assert (shown(1.25e8), shown.label) == (1.25e8, "turns")
    assert show(1.25e8, "1", name) == "1.250·10⁸\N{NARROW NO-BREAK SPACE}turns"
    assert display_unit("1", 1.25e8, "duty_cycle_damage").label == ""
    assert display_unit("s", 3.6e6, "rating_life_time").label == "h"


@pytest.mark.parametrize(
    ("si_unit", "label"),
    [("m", "mm"), *((one, one) for one in ("N", "N·m", "W", "J", "Hz", "s", "m/s", "kg"))],
)
def test_zero_is_in_the_plain_unit(si_unit, label):
    """0 N beside 100 N and 0 W beside 6 W; only lengths are in the unit of a drawing."""
    for zero in (0.0, -0.0, [0.0, 0.0]):
        assert display_unit(si_unit, zero).label == label
