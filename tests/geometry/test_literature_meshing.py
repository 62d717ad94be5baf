"""Meshing of screw and roller: contact positions of four published geometries and one more.

The geometries are those of Li et al. 2020 and 2021 and Wu et al. 2022; the numbers are an
independently computed reference (common normal of two helicoids, high precision).
"""

import numpy as np
import pytest
from scenes import mesh, thread


@pytest.mark.parametrize(
    ("roller_radius", "lead", "screw", "screw_angle", "roller", "roller_angle"),
    [
        (3.25, 10, 9.817301, 3.660514, 3.263483, 11.072969),
        (5.5, 10, 16.540519, 2.193602, 5.508109, 6.600232),
        (3.25, 5, 9.767192, 1.860180, 3.253440, 5.592365),
        (3.25, 15, 9.896338, 5.351715, 3.279380, 16.347545),
        (4.0, 10, 12.055213, 2.995858, 4.011055, 9.037368),
    ],
)
def test_contact_positions(roller_radius, lead, screw, screw_angle, roller, roller_angle):
    """Radii [mm] and angles [degrees] to the digits given; both angles are negative."""
    meshing = mesh(thread(roller_radius * 1e-3, lead * 1e-3))
    half_digit = 5.1e-7
    found = meshing.screw
    assert meshing.converged
    assert found.contact_radius * 1e3 == pytest.approx(screw, abs=half_digit)
    assert found.roller_contact_radius * 1e3 == pytest.approx(roller, abs=half_digit)
    assert np.degrees(found.contact_angle_position) == pytest.approx(-screw_angle, abs=half_digit)
    assert np.degrees(found.roller_angle_position) == pytest.approx(-roller_angle, abs=half_digit)


def test_axial_gap():
    """Teeth of half a pitch interfere by 0.08236 mm per flank; real teeth are thinned."""
    gap = mesh(thread(3.25e-3)).axial_gap
    assert gap * 1e3 == pytest.approx(-0.08236, abs=5e-6)


def test_helix_angles_of_wu_2022():
    """Wu et al. 2022, Table 3: 7.55° on the screw, 4.55° on roller and nut."""
    geometry = thread()
    assert np.degrees(geometry.screw_helix_angle) == pytest.approx(7.55, abs=0.005)
    assert np.degrees(geometry.roller_helix_angle) == pytest.approx(4.55, abs=0.005)
