"""Gears that do not match their thread: migration of the rollers, and the finding."""

import numpy as np
import pytest
from scenes import stage

import prsm_jax as prsm
from prsm_jax.dynamics import roller_migration
from prsm_jax.mechanism import Gear
from tests.geometry.test_analytic_type_meshing import axial_velocities


def _of(kind, ring_teeth):
    gear = Gear(np.radians(20), roller_teeth=16.0, ring_teeth=ring_teeth)
    return stage(gear=gear, type=kind)


@pytest.mark.parametrize("kind", ["standard", "inverted"])
@pytest.mark.parametrize("ring_teeth", [79.0, 80.0, 82.0])
def test_travel_per_turn_of_the_carrier_by_rigid_bodies(kind, ring_teeth):
    """p (n − z_r/z_R); with 80 teeth, five times those of a roller, it vanishes."""
    one = _of(kind, ring_teeth)
    ratio = ring_teeth / 16
    # Speeds at which the carrier makes one turn over the body with the teeth, which is at rest.
    carrier = 2 * np.pi
    spin = carrier * (ratio if kind == "inverted" else -ratio)
    # The other body may turn at any speed: the rollers' place does not depend on it.
    for other in (0.0, 3.0):
        speeds = (
            (0.0, carrier + spin, other) if kind == "inverted" else (other, carrier + spin, 0.0)
        )
        screw, roller, nut = axial_velocities(one.thread, *speeds, carrier)
        moved = roller - (screw if kind == "inverted" else nut)
        np.testing.assert_allclose(float(roller_migration(one)), moved, rtol=1e-12, atol=1e-17)


def test_the_finding_names_gear_thread_and_travel():
    """79 teeth in place of 80: 2 mm/16 per turn of the carrier."""
    found = {f.name: f for f in prsm.check(prsm.Mechanism((_of("standard", 79.0),)))}
    mismatch = found["gear_mismatch"]
    assert mismatch.severity == "warning"
    assert mismatch.value == pytest.approx(0.125e-3, rel=1e-9)
    assert "ratio 4.9375, the thread at 5: they creep 0.125 mm along the nut" in mismatch.message
    matched = prsm.check(prsm.Mechanism((_of("standard", 80.0),)))
    assert "gear_mismatch" not in {f.name for f in matched}


def test_the_quantity():
    one = prsm.Mechanism((_of("standard", 79.0),))
    found = prsm.compute(one, ["roller_migration"])["roller_migration"]
    np.testing.assert_allclose(found, [0.125e-3], rtol=1e-12)
