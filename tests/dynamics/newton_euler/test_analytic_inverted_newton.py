"""Forces on every part of an inverted roller screw: Newton against Lagrange, and each body's own
balance in NumPy with cross products, from the forces that are reported and the contacts' places.
"""

import dataclasses
import functools

import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from scenes import Swing, array, mesh, simulate, steady_state
from type_motion import mechanism

import prsm_jax as prsm
from prsm_jax.dynamics import body_forces, travel_per_radian
from prsm_jax.friction import RollingHysteresis, SpinFriction
from prsm_jax.mechanism import Carrier, body_inertia, body_mass

LOADS = (5e3, -5e3)


@functools.cache
def _one(spin=False):
    one = mechanism("inverted")
    (stage,) = one.stages
    friction = present(stage.friction)
    if spin:
        friction = dataclasses.replace(
            friction, spin=SpinFriction(0.06), rolling_hysteresis=RollingHysteresis(0.01)
        )
    stage = dataclasses.replace(
        stage, friction=friction, carrier=Carrier(mass=0.02, inertia=1e-6), sharing="equal"
    )
    return dataclasses.replace(one, stages=(stage,))


@functools.cache
def _run(load, spin=False):
    speed = Swing(array(80.0), array(40.0), array(900.0))
    scenario = prsm.Scenario(speed, load, 1e-3, initial_carrier_ratio=0.2, samples=21)
    run = simulate(_one(spin), scenario, method="rosenbrock")
    return run, body_forces(_one(spin), run)


@pytest.mark.parametrize("spin", [False, True])
@pytest.mark.parametrize("load", LOADS)
def test_newton_finds_what_lagrange_finds(load, spin):
    run, forces = _run(load, spin)
    assert np.asarray(forces.solved).all()
    for found, expected in (
        (forces.screw_contact_force, run.contact_force),
        (forces.ring_gear_force, run.ring_gear_force),
        (forces.carrier_force, run.carrier_force),
        (forces.carrier_acceleration, run.carrier_acceleration),
        (forces.motor_torque, run.drive_torque),
    ):
        # Relative to the largest number over time; the tooth force passes through zero.
        size = np.abs(np.asarray(expected)).max()
        np.testing.assert_allclose(np.asarray(found), np.asarray(expected), atol=1e-11 * size)


@pytest.mark.parametrize("load", LOADS)
def test_every_body_is_in_balance(load):
    """Looked at from the end from which the load pushes the screw along z: half a turn about x.

    The nut is "screw" in the names of the forces: the body that turns.
    """
    run, forces = _run(load)
    (stage,) = _one().stages
    thread, meshing, count = stage.thread, mesh(stage.thread), stage.roller_count
    distance, roller = float(thread.centre_distance), float(thread.roller_radius)
    nut, lead = meshing.nut, float(travel_per_radian((stage,), 1))
    # Contact of the nut: beyond the roller's axis, turned with the flank that carries.
    flank = np.sign(load)
    angle = -flank * float(nut.contact_angle_position)
    at_nut = float(nut.contact_radius) * np.array([np.cos(angle), np.sin(angle), 0.0])
    at_screw = np.array([float(thread.screw_radius), 0.0, 0.0])
    axis = np.array([distance, 0.0, 0.0])
    assert at_nut[0] > distance > at_screw[0]
    by_nut = np.asarray(forces.screw_normal_on_roller + forces.screw_friction_on_roller)[0]
    by_screw = np.asarray(forces.nut_on_roller)[0]
    teeth, pin = (
        2 * np.asarray(one)[0] for one in (forces.ring_gear_on_roller, forces.pin_on_roller)
    )
    mass, inertia = (float(law(stage, "roller")) for law in (body_mass, body_inertia))
    carriers = stage.carrier.count * float(body_inertia(stage, "carrier"))
    rate, speed = np.asarray(run.carrier_acceleration)[0], np.asarray(run.carrier_speed)[0]
    turning = np.asarray(run.screw_acceleration)
    largest = np.abs(by_nut).max()

    def closes(residual, arm=1.0):
        np.testing.assert_allclose(residual, 0.0, atol=1e-11 * largest * arm)

    advance = -lead * turning
    centre = np.stack([-distance * speed**2, distance * rate, advance], axis=1)
    closes(by_nut + by_screw + teeth + pin - mass * centre)
    # About the roller's axis: it rolls around the screw, so it turns with the carrier and more.
    spin = (1 + float(thread.screw_radius) / roller) * rate
    moments = (
        np.cross(at_nut - axis, by_nut)[:, 2] + np.cross(at_screw - axis, by_screw + teeth)[:, 2]
    )
    closes(moments - inertia * spin, roller)
    closes(-count * distance * pin[:, 1] - carriers * rate, distance)
    # The screw, held against turning, moves along the axis with the carriers; the load pushes it.
    moved = float(body_mass(stage, "screw")) + stage.carrier.count * 0.02
    closes(load - count * by_screw[:, 2] - moved * advance)
    held = np.asarray(forces.anti_rotation_torque)[0] + np.asarray(forces.drag_torque)[0]
    about = np.cross(at_screw, -count * (by_screw + teeth))[:, 2]
    closes(held + about, distance)
    # The nut in its bearing, driven by the motor.
    closes(-count * by_nut[:, 2] - np.asarray(forces.thrust_bearing_force)[0])
    torque = np.asarray(forces.drive_torque)[0] - np.asarray(forces.thrust_bearing_torque)[0]
    torque = torque - np.asarray(forces.drag_torque)[0]
    about = np.cross(at_nut, -count * by_nut)[:, 2]
    closes(torque + about - float(body_inertia(stage, "nut")) * turning, distance)
    # Teeth of the screw push the rollers outwards, at the pressure angle.
    pressure = np.tan(float(present(stage.gear).pressure_angle))
    np.testing.assert_allclose(teeth[:, 0], np.abs(teeth[:, 1]) * pressure, rtol=1e-12)


def test_steady_state():
    state = steady_state(_one(), 100.0, 5e3)
    forces = body_forces(_one(), state)
    found, expected = float(forces.screw_contact_force[0]), float(state.contact_force[0])
    assert found == pytest.approx(expected, rel=1e-12)
    assert float(forces.motor_torque) == pytest.approx(float(state.drive_torque), rel=1e-12)
    assert float(jnp.max(jnp.abs(forces.carrier_acceleration))) == 0.0
