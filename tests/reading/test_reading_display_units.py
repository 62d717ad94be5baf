"""Every unit that numbers are shown in, at every size, turned back by `pint`."""

import pytest
from reading_units import same_dimension, to_si

from prsm_jax.text._display_units import _SHOWN, display_unit


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
