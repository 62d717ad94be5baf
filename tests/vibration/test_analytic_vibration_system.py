"""Masses and springs of a stage that its vibrations are made of, counted by hand."""

import numpy as np
import pytest
from scenes import array, stage, thread

from prsm_jax.mechanism import Carrier, Gear, Nut, RingGear, Roller, Screw, Support, UnequalRoller
from prsm_jax.stiffness import ThreadStiffness
from prsm_jax.vibration import vibration_system
from tests.present import present

THREADS = ThreadStiffness(array(2e8), array(3e8))


def _stage(pins=None, unequal=(), **more):
    """Every number differs from all others."""
    bodies = {
        "screw": Screw(mass=0.7, inertia=1.7e-4, support=Support(1.1e8, 1.2e7, 1.3e8)),
        "roller": Roller(mass=0.03, inertia=4e-7, support=pins),
        "nut": Nut(mass=2.2, inertia=9e-4, support=Support(radial_stiffness=1.4e8)),
        "carrier": Carrier(mass=0.11, inertia=1.3e-5, count=2, support=Support(1.5e8, 1.6e7)),
    }
    return stage(9, unequal_roller=unequal, **(bodies | more))


def test_central_bodies_are_seen_at_their_nominal_radii():
    one = _stage(ring_gear=RingGear(mass=0.4, inertia=5e-5), gear=Gear(np.radians(20), 22.0, 8e-3))
    system = vibration_system(one, THREADS)
    geometry = one.thread
    named = {body.name: body for body in system.bodies}
    assert list(named) == ["screw", "ring_gear", "nut"]
    assert [body.roller_sign for body in system.bodies] == [1, -1, -1]
    masses = [(0.7, 1.7e-4), (0.4, 5e-5), (2.2, 9e-4)]
    radii = [float(geometry.screw_radius), *[float(geometry.nut_radius)] * 2]
    for body, (mass, inertia), radius in zip(system.bodies, masses, radii, strict=True):
        assert float(body.mass) == mass
        assert float(body.equivalent_mass) == pytest.approx(inertia / radius**2, rel=1e-14)
    # Thread forces lean by the roller's helix; those of teeth do not.
    lead, radius = float(geometry.lead), float(geometry.roller_radius)
    per_turn = lead / float(geometry.starts)
    shallow = 1 / (1 + (per_turn / (2 * np.pi * radius)) ** 2)
    assert float(named["screw"].mesh_stiffness) == pytest.approx(2e8 * shallow, rel=1e-12)
    assert float(named["nut"].mesh_stiffness) == pytest.approx(3e8 * shallow, rel=1e-12)
    supports = [
        (float(body.radial_support), float(body.torsional_support)) for body in system.bodies
    ]
    assert supports == [(1.1e8, 1.2e7), (0.0, 0.0), (1.4e8, 0.0)]
    assert float(present(named["screw"].radial_support_y)) == 1.3e8
    assert named["nut"].radial_support_y is None
    assert float(system.roller_equivalent_mass) == pytest.approx(4e-7 / radius**2, rel=1e-14)
    np.testing.assert_allclose(system.roller_positions, 2 * np.pi * np.arange(9) / 9, rtol=1e-15)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_carriers_take_the_rollers_along_or_hold_them_by_springs(count):
    """Rigid pins: I/a² of all carriers and the mass of all rollers. On springs: those apart."""
    carrier = Carrier(mass=0.11, inertia=1.3e-5, count=count, support=Support(1.5e8, 1.6e7))
    one = _stage(carrier=carrier)
    axes = float(one.thread.screw_radius + one.thread.roller_radius)
    turning = count * 1.3e-5 / axes**2
    rigid = vibration_system(one, THREADS).carrier
    assert float(rigid.equivalent_mass) == pytest.approx(turning + 9 * 0.03, rel=1e-14)
    assert float(rigid.torsional_support) == 1.6e7
    held = vibration_system(_stage(Support(radial_stiffness=4e7), carrier=carrier), THREADS)
    assert float(held.carrier.equivalent_mass) == pytest.approx(turning, rel=1e-14)
    assert float(held.carrier.torsional_support) == 1.6e7
    assert float(present(held.carrier.mass)) == pytest.approx(count * 0.11, rel=1e-15)
    assert float(present(held.carrier.radial_support)) == 1.5e8
    assert float(held.translation.mass) == 0.03
    assert float(held.translation.pin_stiffness) == 4e7


def test_a_missing_roller_and_a_heavy_one():
    """Eight of nine places; the carrier takes along what is there."""
    unequal = (UnequalRoller(3, missing=True), UnequalRoller(5, mass_factor=1.5))
    one = _stage(unequal=unequal)
    system = vibration_system(one, THREADS)
    assert system.roller_count == 8
    turning = 2 * 1.3e-5 / float(one.thread.centre_distance) ** 2
    assert float(system.carrier.equivalent_mass) == pytest.approx(turning + 8.5 * 0.03, rel=1e-14)
    places = np.delete(2 * np.pi * np.arange(9) / 9, 2)
    np.testing.assert_allclose(system.roller_positions, places, rtol=1e-14, atol=1e-16)
    without = _stage(unequal=(UnequalRoller(1, missing=True),), carrier=None, geometry=thread())
    assert vibration_system(without, THREADS).carrier is None
