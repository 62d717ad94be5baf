"""Masses and inertias from dimensions follow the design variables."""

import numpy as np
import pytest
from scenes import STEEL, stage

import prsm_jax as prsm
from prsm_jax.mechanism import (
    Carrier,
    Nut,
    RingGear,
    Roller,
    Screw,
    body_inertia,
    body_mass,
    nut_outer_radius,
    nut_unit_mass,
    stage_mass,
)

BODIES = {
    "screw": Screw(length=0.35, bore_radius=4e-3),
    "roller": Roller(length=0.05),
    "nut": Nut(length=0.08, wall_thickness=10e-3),
    "ring_gear": RingGear(length=6e-3, wall_thickness=4e-3),
    "carrier": Carrier(length=4e-3, radial_width=7e-3),
}


def _annuli(roller_radius):
    """Inner radius, outer radius, length of every body for n = 5."""
    r = roller_radius
    return {
        "screw": (4e-3, 3 * r, 0.35),
        "roller": (0.0, r, 0.05),
        "nut": (5 * r, 5 * r + 10e-3, 0.08),
        "ring_gear": (5 * r, 5 * r + 4e-3, 6e-3),
        "carrier": (4 * r - 3.5e-3, 4 * r + 3.5e-3, 4e-3),
    }


@pytest.mark.parametrize("roller_radius", [3e-3, 4e-3, 5.5e-3])
def test_masses_and_inertias_follow_the_roller_radius(roller_radius):
    mechanism = prsm.Mechanism((stage(material=STEEL, **BODIES),))
    moved = prsm.set_parameter(mechanism, "roller_radius", roller_radius).stages[0]
    total, of_screw = 0.0, 0.0
    for body, (inner, outer, length) in _annuli(roller_radius).items():
        mass = np.pi * 7850 * length * (outer**2 - inner**2)
        assert body_mass(moved, body) == pytest.approx(mass, rel=1e-13)
        inertia = mass * (outer**2 + inner**2) / 2
        assert body_inertia(moved, body) == pytest.approx(inertia, rel=1e-13)
        total += mass * {"roller": 10, "carrier": 2}.get(body, 1)
        of_screw += mass * (body == "screw")
    assert stage_mass(moved) == pytest.approx(total, rel=1e-13)
    assert nut_unit_mass(moved) == pytest.approx(total - of_screw, rel=1e-13)
    assert nut_outer_radius(moved) == pytest.approx(5 * roller_radius + 10e-3, rel=1e-14)


def test_given_masses_stay_as_given():
    mechanism = prsm.Mechanism((stage(),))
    moved = prsm.set_parameter(mechanism, "roller_radius", 6e-3).stages[0]
    assert body_mass(moved, "roller") == 0.03
    assert body_inertia(moved, "roller") == 4e-7


def test_a_given_mass_still_gives_the_inertia_from_dimensions():
    one = stage(roller=Roller(mass=0.03))
    with pytest.raises(prsm.MissingDataError, match="roller has neither inertia nor length"):
        body_inertia(one, "roller")
    sized = stage(roller=Roller(mass=0.03, length=0.05))
    assert body_inertia(sized, "roller") == pytest.approx(0.03 * 16e-6 / 2, rel=1e-14)


def test_own_material_wins_over_the_stages():
    light = prsm.mechanism.Material(70e9, 0.33, 2700.0)
    one = stage(roller=Roller(length=0.05, material=light))
    assert body_mass(one, "roller") == pytest.approx(np.pi * 2700 * 0.05 * 16e-6, rel=1e-13)


def test_screws_that_ride_on_nuts_move_along_the_axis():
    stages = tuple(
        stage(
            screw=Screw(mass=mass),
            nut=Nut(mass=0.7),
            roller=Roller(mass=0.03),
            ring_gear=None,
            carrier=Carrier(mass=0.05),
        )
        for mass in (1.1, 1.3, 1.7)
    )
    mechanism = prsm.Mechanism(stages)
    count = float(stages[0].roller_count)
    expected = 3 * (0.7 + 0.03 * count + 2 * 0.05) + 1.3 + 1.7
    found = prsm.compute(mechanism, ["nut_unit_mass"])["nut_unit_mass"]
    assert float(found) == pytest.approx(expected, rel=1e-14)
