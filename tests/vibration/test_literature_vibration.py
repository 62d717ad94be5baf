"""Wu et al. 2022: gear mesh stiffness and the frequencies that Table 4 really has."""

import equinox as eqx
import numpy as np
import pytest
from scenes import array, example, modal

from prsm_jax.mechanism import Gear
from prsm_jax.stiffness import gear_mesh_stiffness, tooth_flexibility

_gear_stiffness = eqx.filter_jit(gear_mesh_stiffness)

#: Table 3.
GEAR = Gear(
    np.radians(20),
    roller_teeth=16.0,
    face_width=10e-3,
    roller_profile_shift=1.0,
    ring_profile_shift=1.0,
)


def test_gear_mesh_stiffness_of_table_3():
    """ISO 6336-1: 16.429 N/(mm·µm), 1.6429e8 N/m on 10 mm of face width.

    The formula gives 16.42845, so the last digit is allowed to be one off.
    """
    stiffness = _gear_stiffness(GEAR, array(5.0))
    assert stiffness == pytest.approx(1.6429e8, abs=1e4)
    assert 0.8 / tooth_flexibility(GEAR, array(5.0)) == pytest.approx(16.429, abs=1e-3)


def test_gear_mesh_stiffness_of_table_4_is_one_and_a_half_times_that():
    """2.464e8 N/m: a mesh factor 0.75 ε_α + 0.25 with ε_α = 5/3, or 15 mm of face width."""
    with_factor = eqx.tree_at(lambda g: g.mesh_factor, GEAR, array(0.75 * 5 / 3 + 0.25))
    wider = eqx.tree_at(lambda g: g.face_width, GEAR, array(15e-3))
    assert _gear_stiffness(with_factor, array(5.0)) == pytest.approx(2.464e8, rel=2e-4)
    assert _gear_stiffness(wider, array(5.0)) == pytest.approx(2.464e8, rel=2e-4)


def test_frequencies_of_table_4_with_seven_rollers():
    """The positive semidefinite model with Table 4 as printed; independent reference [Hz].

    Table 5 of the paper has other numbers: they are magnitudes from an indefinite matrix.
    """
    modes = modal(example("wu2022"))
    expected = [
        293.3,
        # Closed form below; 838.9 follows from a rounded stiffness.
        839.13,
        *[2262.2] * 2,
        *[3604.0] * 2,
        4847.5,
        13856.5,
        *[21761.9] * 2,
        *[22838.8] * 4,
        27273.8,
        *[34523.4] * 2,
    ]
    np.testing.assert_allclose(modes.frequencies, expected, rtol=0, atol=0.051)
    assert modes.families == (
        "torsional",
        "carrier",
        *["transverse"] * 4,
        *["torsional"] * 2,
        *["transverse"] * 2,
        *["roller"] * 4,
        "torsional",
        *["transverse"] * 2,
    )
    assert modes.multiplicities == (1, 1, 2, 2, 2, 2, 1, 1, 2, 2, 4, 4, 4, 4, 1, 2, 2)


def test_carrier_frequency_in_closed_form():
    """√(K_cu/(J_c/r_c² + N m_R))/2π with Table 4: 839.13 Hz."""
    squared = 6.983e6 / (5.888e-6 / 16e-3**2 + 7 * 0.0326)
    closed = np.sqrt(squared) / (2 * np.pi)
    assert closed == pytest.approx(839.13, abs=5e-3)
    carrier = modal(example("wu2022")).group("carrier")
    assert carrier is not None
    np.testing.assert_allclose(carrier.frequencies, [closed], rtol=1e-14)
