"""Forces on every part: Newton's equations against Lagrange's, and the balances of every body.

The balances are written out once more here, in NumPy and with cross products of positions and
forces in space, from nothing but the forces that are reported and the geometry of the contacts.
"""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import STEEL, array, example, simulate, stage as make_stage, steady_state

import prsm_jax as prsm
from prsm_jax.dynamics import Instant, stage_kinematics, states_at
from prsm_jax.dynamics.forces._power import losses
from prsm_jax.dynamics.forces._roller_balance import roller_support_forces
from prsm_jax.dynamics.forces._stage_forces import carrier_inertia
from prsm_jax.dynamics.friction._contact_losses import with_resistance
from prsm_jax.friction import (
    Drag,
    Friction,
    RollingHysteresis,
    SpinFriction,
    SplineFriction,
    StribeckFriction,
    ThrustBearingFriction,
)
from prsm_jax.mechanism import Carrier, Gear, Mechanism, Nut, Roller, Screw, Thread
from tests.present import present

STAGES = (1, 2, 4)
#: Mechanisms and motions for each number of stages.
CASES = 64


DERIVED = ("motor_torque", "housing_force", "ring_gear_force", "carrier_force")


class Ramp(eqx.Module):
    """A speed and its rate."""

    start: jax.Array
    rate: jax.Array

    def __call__(self, time):
        return self.start + self.rate * time


def _random_stage(rng, index):
    """Any stage that meshes, with every kind of friction that it can have."""

    def between(low, high):
        return array(rng.uniform(low, high))

    def about(value):
        return array(value * 10 ** rng.uniform(-1, 1))

    coefficient = rng.uniform(0, 0.15)
    friction = Friction(
        # Coulomb's and the viscous law are its limits.
        thread=StribeckFriction(
            array(coefficient * rng.uniform(1, 1.5)), array(coefficient), about(0.1), between(0, 20)
        ),
        spin=SpinFriction(between(0, 0.1)),
        rolling_hysteresis=RollingHysteresis(between(0, 0.02)),
        spline=SplineFriction(between(0, 0.2), between(8e-3, 20e-3)) if index else None,
        thrust_bearing=ThrustBearingFriction(between(0, 0.02), between(10e-3, 30e-3)),
        drag=Drag(between(0, 0.1), between(0, 1e-3)),
    )
    return make_stage(
        roller_count=7 + index,
        friction=friction,
        geometry=Thread(
            lead=between(3e-3, 15e-3),
            starts=array(rng.integers(4, 7)),
            roller_radius=between(3e-3, 8e-3),
            contact_angle=between(0.6, 1.0),
        ),
        screw=Screw(mass=about(0.8), inertia=about(2e-4)),
        roller=Roller(mass=about(0.03), inertia=about(4e-7)),
        nut=Nut(mass=about(5.0), inertia=about(1e-3)),
        carrier=Carrier(mass=about(0.05), inertia=about(1e-5)),
        gear=Gear(between(0.3, 0.45)),
        material=STEEL,
        engaged_threads=array(20.0),
    )


def _random_motion(rng, index):
    """Forward and backward, under loads of either sign, slowly or strongly accelerating."""
    speed = 10 ** rng.uniform(0, 2.5) * (-1) ** index
    load = 10 ** rng.uniform(2, 5) * (-1) ** (index // 2)
    acceleration = rng.normal() * 10 ** rng.uniform(1, 5.5)
    return array(speed), array(acceleration), array(load)


def _positions(kinematics, flank):
    """Contact of the screw from the axes of screw and roller, in the carrier's plane."""
    side = kinematics.meshing.screw
    screw, roller = flank * side.contact_angle_position, flank * side.roller_angle_position
    return (
        side.contact_radius * jnp.stack([jnp.cos(screw), jnp.sin(screw), 0 * screw]),
        side.roller_contact_radius * jnp.stack([-jnp.cos(roller), jnp.sin(roller), 0 * roller]),
    )


_stage_kinematics = eqx.filter_jit(stage_kinematics)


@functools.cache
def _kinematics():
    """Of many stages at once, the spline left out so that one program serves all stages."""

    def one(stage):
        return with_resistance((stage,), (stage_kinematics(stage),))[0]

    return eqx.filter_jit(jax.vmap(one))


def _kinematics_of(batch):
    bare = [
        eqx.tree_at(lambda s: s.friction.spline, s, None, is_leaf=lambda x: x is None)
        for s in batch.stages
    ]
    bare = [dataclasses.replace(s, roller_count=7) for s in bare]
    return tuple(_kinematics()(stage) for stage in bare)


def _both(mechanism, kinematics, speed, acceleration, load, carrier_speed):
    """One instant by both formulations, and what the balances need beside it."""
    scenario = prsm.Scenario(Ramp(speed, acceleration), load, array(1.0))
    states = states_at(mechanism, kinematics, scenario, array(0.0), carrier_speed)
    inertia = jnp.stack([carrier_inertia(stage) for stage in mechanism.stages])
    drive = jnp.stack([s.forces.carrier_drive for s in states])
    supports = [
        roller_support_forces(*row, drive[index] / inertia[index])
        for index, row in enumerate(zip(mechanism.stages, kinematics, states, strict=True))
    ]

    def turned(state, vector):
        return vector * jnp.stack(
            [jnp.ones_like(state.flank_sign), state.flank_sign, state.flank_sign]
        )

    zero = jnp.zeros_like(load)
    lagrange = {
        "carrier_acceleration": drive / inertia,
        "drive_torque": jnp.stack([s.screw.drive_torque for s in states]),
        "thrust_bearing_force": jnp.stack([s.screw.support_force for s in states]),
        "thrust_bearing_torque": jnp.stack([present(s.screw.bearing_torque) for s in states]),
        "drag_torque": jnp.stack([present(s.screw.drag_torque) for s in states]),
        "spline_friction": jnp.stack(
            [zero if s.screw.spline_friction is None else s.screw.spline_friction for s in states]
        ),
        "nut_load": jnp.stack([s.nut_load for s in states]),
        "screw_contact_force": jnp.stack([s.forces.contact_force for s in states]),
        "nut_contact_force": jnp.stack([s.forces.nut_contact_force for s in states]),
        "screw_friction_on_roller": jnp.stack([turned(s, s.forces.friction) for s in states]),
        "ring_gear_force": jnp.stack([s.ring_gear_force for s in supports]),
        "carrier_force": jnp.stack([s.carrier_force for s in supports]),
    }
    instant = Instant(speed, carrier_speed, load, acceleration)
    forces = prsm.dynamics.body_forces(mechanism, instant, kinematics)
    newton = {name: getattr(forces, name) for name in (*forces.__dataclass_fields__, *DERIVED)}
    at_screw, at_roller = zip(
        *(_positions(k, s.flank_sign) for k, s in zip(kinematics, states, strict=True)), strict=True
    )
    known = {
        "contact_at_screw": jnp.stack(at_screw),
        "contact_at_roller": jnp.stack(at_roller),
        "slip": jnp.stack([turned(s, s.motion.slip) for s in states]),
        "losses": sum(losses(mechanism, kinematics, states, speed).values()),
        "meshes": jnp.stack([k.meshing.converged for k in kinematics]).all(),
        "presses": jnp.stack([s.forces.contact_force > 0 for s in states]).all(),
    }
    return lagrange, newton, known


@functools.cache
def _cases(stages):
    """Random mechanisms in random motion, by both formulations."""
    rng = np.random.default_rng(stages)
    mechanisms = [
        Mechanism(tuple(_random_stage(rng, index) for index in range(stages))) for _ in range(CASES)
    ]
    batch = jax.tree.map(lambda *leaves: jnp.stack(leaves), *mechanisms)
    speed, acceleration, load = (
        jnp.stack(row)
        for row in zip(*(_random_motion(rng, index) for index in range(CASES)), strict=True)
    )
    carriers = speed[:, None] * array(rng.uniform(-0.2, 0.32, (CASES, stages)))
    kinematics = _kinematics_of(batch)
    found = eqx.filter_jit(jax.vmap(_both))(batch, kinematics, speed, acceleration, load, carriers)
    motion = (speed, acceleration, load, carriers)
    numbers = jax.tree.map(np.asarray, (batch, motion, found))
    assert np.all(numbers[2][2]["meshes"])
    assert np.all(numbers[2][1]["solved"])
    return numbers


def _close(found, expected, tolerance):
    """Relative to each case's largest component."""
    axes = tuple(range(1, expected.ndim))
    scale = np.max(np.abs(expected), axis=axes, keepdims=True)
    return np.all(np.abs(found - expected) <= tolerance * scale)


def _moments(stages, forces):
    """Forces of the screw on all rollers at the nut's radius, over the inertia of the carrier."""
    scale = []
    for k, stage in enumerate(stages.stages):
        thread, count = stage.thread, 7 + k
        distance = (thread.starts - 1) * thread.roller_radius
        inertia = 2 * stage.carrier.inertia + count * stage.roller.mass * distance**2
        inertia = inertia + count * stage.roller.inertia * (thread.starts - 1) ** 2
        parts = [forces[f"screw_{name}_on_roller"][:, k] for name in ("normal", "friction")]
        force = sum(np.linalg.norm(part, axis=-1) for part in parts)
        scale.append(count * force * thread.starts * thread.roller_radius / inertia)
    return np.stack(scale, axis=1)


@pytest.mark.parametrize("stages", STAGES)
def test_newton_accelerates_the_carriers_as_lagrange(stages):
    """Each carrier of each mechanism, to 1e-12 of its own acceleration: rounding of both.

    The acceleration is a difference of moments, which round as they are, however small it is.
    """
    batch, _, (lagrange, newton, _) = _cases(stages)
    expected = lagrange["carrier_acceleration"]
    assert np.min(np.abs(expected)) > 0
    apart = np.abs(newton["carrier_acceleration"] - expected)
    assert np.all(apart <= 1e-12 * np.abs(expected) + 1e-15 * _moments(batch, newton))


@pytest.mark.parametrize("stages", STAGES)
def test_newton_finds_the_same_forces_as_lagrange(stages):
    """All that both know: contacts, gear, pins, spline, bearings, and every screw's torque."""
    lagrange, newton, known = _cases(stages)[2]
    assert np.mean(known["presses"]) == 1
    for name, expected in lagrange.items():
        assert _close(newton[name], expected, 1e-12), name
    assert np.array_equal(newton["motor_torque"], newton["drive_torque"][:, 0])


def test_the_cases_are_of_all_kinds():
    """Driving and driven, on both flanks, with friction and inertia that matter."""
    (_, (speed, _, load, _), (_, newton, _)) = _cases(2)
    kinds = {(s > 0, f > 0) for s, f in zip(speed, load, strict=True)}
    assert len(kinds) == 4
    backward = newton["screw_normal_on_roller"][..., 2] > 0
    assert np.any(backward)
    assert not np.all(backward)
    # Inside one mechanism too: inertia pushes a nut against the load on the last.
    assert np.any(backward[:, 0] != backward[:, 1])


def _balances(numbers):
    """Sum of forces and torques minus inertia on each body, with what it is small against."""
    batch, (_, acceleration, load, carriers), (_, forces, known) = numbers
    found = {}
    stages = batch.stages
    travel = np.cumsum([s.thread.lead for s in stages], axis=0) / (2 * np.pi)
    axis = np.array([0, 0, 1.0])

    def add(name, terms, rate):
        """Terms along the last axis or scalars; relative to the largest of them."""
        terms = [np.asarray(term) for term in (*terms, -np.asarray(rate))]
        scale = np.max([np.max(np.abs(t).reshape(CASES, -1), axis=1) for t in terms], axis=0)
        found[name] = np.max(np.abs(sum(terms)).reshape(CASES, -1), axis=1) / scale

    def about_axis(position, force):
        return np.cross(position, force) @ axis

    momentum_rate = np.zeros(CASES)
    spin_rate = np.zeros(CASES)
    anti_rotation = np.sum(forces["anti_rotation_torque"], axis=1)
    for k, stage in enumerate(stages):
        thread, count = stage.thread, 7 + k
        nut_rate = -acceleration * travel[k]
        screw_rate = -acceleration * (travel[k - 1] if k else 0)
        rollers = (thread.starts - 1) * thread.roller_radius
        radius = thread.roller_radius
        zero = np.zeros(CASES)
        to_nut = np.stack([radius, zero, zero], axis=-1)
        to_roller = np.stack([rollers, zero, zero], axis=-1)
        carrier_rate = forces["carrier_acceleration"][:, k]
        centre = np.stack(
            [-(carriers[:, k] ** 2) * rollers, carrier_rate * rollers, nut_rate], axis=-1
        )
        spin = -(thread.starts - 1) * carrier_rate
        normal, friction = (
            forces["screw_normal_on_roller"][:, k],
            forces["screw_friction_on_roller"][:, k],
        )
        nut, gear = forces["nut_on_roller"][:, k], forces["ring_gear_on_roller"][:, k]
        pin = forces["pin_on_roller"][:, k]
        screw_moment = forces["screw_moment_on_roller"][:, k]
        nut_moment = forces["nut_moment_on_roller"][:, k]
        contact = known["contact_at_roller"][:, k]
        add(
            f"roller {k}",
            [normal, friction, nut, 2 * gear, 2 * pin],
            stage.roller.mass[:, None] * centre,
        )
        add(
            f"roller {k} about its axis",
            [
                about_axis(contact, normal),
                about_axis(contact, friction),
                about_axis(to_nut, nut),
                2 * about_axis(to_nut, gear),
                screw_moment,
                nut_moment,
            ],
            stage.roller.inertia * spin,
        )
        add(
            f"carriers {k} about the axis",
            [-2 * count * about_axis(to_roller, pin)],
            2 * stage.carrier.inertia * carrier_rate,
        )
        axial_of_carriers = forces["carrier_axial_force"][:, k]
        add(f"carriers {k} axial", [axial_of_carriers], 2 * stage.carrier.mass * nut_rate)
        add(
            f"nut {k} axial",
            [forces["nut_load"][:, k], -count * nut[:, 2], -axial_of_carriers],
            stage.nut.mass * nut_rate,
        )
        last = k + 1 == len(stages)
        add(
            f"nut {k} about the axis",
            [
                forces["anti_rotation_torque"][:, k],
                -count * about_axis(to_roller + to_nut, nut),
                -2 * count * about_axis(to_roller + to_nut, gear),
                -count * nut_moment,
                forces["drag_torque"][:, k],
                zero if last else forces["thrust_bearing_torque"][:, k + 1],
            ],
            zero,
        )
        contact = known["contact_at_screw"][:, k]
        add(
            f"screw {k} axial",
            [
                -forces["thrust_bearing_force"][:, k],
                forces["spline_friction"][:, k],
                zero if last else -forces["spline_friction"][:, k + 1],
                -count * normal[:, 2],
                -count * friction[:, 2],
            ],
            stage.screw.mass * screw_rate,
        )
        add(
            f"screw {k} about the axis",
            [
                forces["drive_torque"][:, k],
                zero if last else -forces["drive_torque"][:, k + 1],
                -forces["thrust_bearing_torque"][:, k],
                -forces["drag_torque"][:, k],
                -count * about_axis(contact, normal),
                -count * about_axis(contact, friction),
                -count * screw_moment,
            ],
            stage.screw.inertia * acceleration,
        )
        moved = count * stage.roller.mass + stage.nut.mass + 2 * stage.carrier.mass
        momentum_rate += moved * nut_rate + stage.screw.mass * screw_rate
        circling = 2 * stage.carrier.inertia + count * stage.roller.mass * rollers**2
        spin_rate += stage.screw.inertia * acceleration + circling * carrier_rate
        spin_rate += count * stage.roller.inertia * spin
    # From outside: load, motor, rods of the nuts, and the housing's thrust bearing.
    add("mechanism axial", [load, -forces["housing_force"]], momentum_rate)
    bearing = forces["thrust_bearing_torque"][:, 0]
    add(
        "mechanism about the axis",
        [forces["motor_torque"], -bearing, anti_rotation],
        spin_rate,
    )
    return found


def _power_balance(numbers):
    """Motor − load − every loss − rate of kinetic energy, from forces and velocities."""
    batch, (speed, acceleration, load, carriers), (_, forces, known) = numbers
    stages = batch.stages
    travel = np.cumsum([s.thread.lead for s in stages], axis=0) / (2 * np.pi)
    terms = [forces["motor_torque"] * speed, -load * travel[-1] * speed]
    lost = np.zeros(CASES)
    kinetic = np.zeros(CASES)
    for k, stage in enumerate(stages):
        count, carrier = 7 + k, carriers[:, k]
        rolling = (stage.thread.starts - 1) * carrier
        friction = forces["screw_friction_on_roller"][:, k]
        lost += count * np.sum(friction * known["slip"][:, k], axis=-1)
        lost += count * forces["screw_moment_on_roller"][:, k] * (speed + rolling)
        lost += count * forces["nut_moment_on_roller"][:, k] * rolling
        lost += (forces["thrust_bearing_torque"][:, k] + forces["drag_torque"][:, k]) * speed
        if k:
            lead = stages[k - 1].thread.lead
            lost += forces["spline_friction"][:, k] * speed * lead / (2 * np.pi)
        rate = forces["carrier_acceleration"][:, k]
        distance = (stage.thread.starts - 1) * stage.thread.roller_radius
        moved = count * stage.roller.mass + stage.nut.mass + 2 * stage.carrier.mass
        before = travel[k - 1] if k else 0 * speed
        screw = stage.screw.inertia + stage.screw.mass * before**2
        kinetic += (moved * travel[k] ** 2 + screw) * speed * acceleration
        turning = 2 * stage.carrier.inertia + count * stage.roller.mass * distance**2
        turning = turning + count * stage.roller.inertia * (stage.thread.starts - 1) ** 2
        kinetic += turning * carrier * rate
    terms += [-lost, -kinetic]
    return np.abs(sum(terms)) / np.max(np.abs(terms), axis=0), lost


@pytest.mark.parametrize("stages", STAGES)
def test_momentum_of_every_body(stages):
    """Axial and angular momentum of each body and of the whole mechanism, to rounding."""
    found = _balances(_cases(stages))
    assert len(found) == 8 * stages + 2
    for name, residual in found.items():
        assert np.max(residual) < 1e-12, name


@pytest.mark.parametrize("stages", STAGES)
def test_power_of_newton_and_of_lagrange(stages):
    """Newton's forces times velocities leave nothing over, and lose what Lagrange's lose."""
    numbers = _cases(stages)
    residual, lost = _power_balance(numbers)
    assert np.max(residual) < 1e-12
    np.testing.assert_allclose(lost, numbers[2][2]["losses"], rtol=1e-12)
    assert np.all(lost > 0)


#: Every force that is reported, once for the tooth forces of either end.
FORCES = [
    "screw_normal_on_roller",
    "screw_friction_on_roller",
    "nut_on_roller",
    "ring_gear_on_roller",
    "pin_on_roller",
    "screw_moment_on_roller",
    "nut_moment_on_roller",
    "carrier_acceleration",
    "carrier_axial_force",
    "nut_load",
    "thrust_bearing_force",
    "thrust_bearing_torque",
    "drive_torque",
    "spline_friction",
    "drag_torque",
    "anti_rotation_torque",
]


@pytest.mark.parametrize("name", FORCES)
def test_no_balance_closes_without_one_of_the_forces(name):
    """Half of a force lost (such as one of the two tooth forces) is seen in most mechanisms."""
    batch, motion, (lagrange, forces, known) = _cases(2)
    half = forces | {name: forces[name] / 2}
    found = _balances((batch, motion, (lagrange, half, known)))
    assert np.mean(np.max(list(found.values()), axis=0) > 1e-6) > 0.9


def test_through_standstill_and_reversal():
    """A run's forces by the other formulation, standstills with their onset of motion included."""
    two = example("li2020_two_stage")

    def speed(time):
        return 100.0 * jnp.sin(2 * jnp.pi * 5 * time)

    scenario = prsm.Scenario(speed, 7e3, 0.2, samples=81)
    run = simulate(two, scenario, method="quasi_steady")
    found = eqx.filter_jit(prsm.dynamics.body_forces)(two, run)
    assert found.screw_normal_on_roller.shape == (2, 81, 3)
    assert np.all(found.solved)
    for name, expected in (
        ("screw_contact_force", run.contact_force),
        ("ring_gear_force", run.ring_gear_force),
        ("carrier_force", run.carrier_force),
        ("spline_friction", run.spline_friction),
        ("drive_torque", run.stage_torque),
        ("carrier_acceleration", run.carrier_acceleration),
    ):
        assert _close(getattr(found, name), np.asarray(expected), 1e-11), name


def test_steady_state():
    """Without an acceleration no mass is needed, except for the rollers' centripetal force."""
    two = example("li2020_two_stage")
    steady = steady_state(two)
    found = eqx.filter_jit(prsm.dynamics.body_forces)(two, steady)
    assert bool(found.solved)
    for name, expected in (
        ("screw_contact_force", steady.contact_force),
        ("ring_gear_force", steady.ring_gear_force),
        ("carrier_force", steady.carrier_force),
        ("nut_load", steady.nut_load),
        ("spline_friction", steady.spline_friction),
    ):
        np.testing.assert_allclose(getattr(found, name), expected, rtol=1e-11)
    assert float(found.motor_torque) == pytest.approx(float(steady.drive_torque), rel=1e-13)
    assert np.all(np.asarray(found.carrier_acceleration) == 0)
    # Rods of the nuts and housing hold what the motor turns.
    held = np.sum(found.anti_rotation_torque) - found.thrust_bearing_torque[0]
    assert float(held) == pytest.approx(-float(found.motor_torque), rel=1e-12)


def test_nothing_loaded_and_nothing_rubbing():
    """No load and no friction: every force is that of inertia, and finite."""
    two = example("li2020_two_stage")
    smooth = eqx.tree_at(
        lambda m: [s.friction.thread.coefficient for s in m.stages], two, [array(0.0)] * 2
    )
    instant = Instant(array(100.0), array([0.0, 30.0]), array(0.0))
    for one in (two, smooth):
        found = jax.tree.map(np.asarray, eqx.filter_jit(prsm.dynamics.body_forces)(one, instant))
        assert bool(found.solved)
        assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(found))
        assert np.all(np.abs(found.carrier_acceleration) < 1e-12)
        inward = -(30.0**2) * 22e-3 * 0.039
        np.testing.assert_allclose(2 * found.pin_on_roller[:, 0], [0, inward], atol=1e-12)


def test_derivatives_of_forces():
    """Forward, reverse and central differences along a random change of every number at once.

    The geometry of the contacts is one of them: its own derivatives are tested elsewhere.
    """
    one = example("li2020_two_stage")
    instant = Instant(array(100.0), array([20.0, 30.0]), array(7e3), array(5e3))
    kinematics = tuple(_stage_kinematics(stage) for stage in one.stages)
    start, rest = eqx.partition((one, instant, kinematics), eqx.is_inexact_array)
    rng = np.random.default_rng(0)
    along = jax.tree.map(lambda leaf: leaf * array(rng.uniform(-1, 1)), start)

    def forces(numbers):
        found = prsm.dynamics.body_forces(*eqx.combine(numbers, rest))
        parts = (found.ring_gear_on_roller[0, 1], found.pin_on_roller[1, 0])
        return jnp.stack([*parts, found.anti_rotation_torque[0], found.carrier_acceleration[1]])

    @jax.jit
    def everything(numbers):
        step = 1e-5

        def beside(share):
            return jax.tree.map(lambda leaf, change: leaf + share * change, numbers, along)

        sides = [forces(beside(share)) for share in (step, -step)]
        value, forward = jax.jvp(forces, (numbers,), (along,))
        _, pull = jax.vjp(forces, numbers)

        def pulled(cotangent):
            parts = jax.tree.map(lambda a, b: jnp.sum(a * b), pull(cotangent)[0], along)
            return sum(jax.tree.leaves(parts))

        reverse = jax.vmap(pulled)(jnp.eye(len(value)))
        return value, forward, reverse, (sides[0] - sides[1]) / (2 * step)

    value, forward, reverse, difference = everything(start)
    assert np.all(np.abs(forward) > 0.01 * np.abs(value))
    np.testing.assert_allclose(reverse, forward, rtol=1e-10)
    # Truncation: the square of the step.
    np.testing.assert_allclose(difference, forward, rtol=1e-7)


@pytest.mark.parametrize("settled", [True, False])
def test_masses_are_asked_for_only_where_they_matter(settled):
    two = example("li2020_two_stage")
    bare = eqx.tree_at(lambda m: m.stages[0].roller, two, Roller())
    if settled:
        found = eqx.filter_eval_shape(prsm.dynamics.body_forces, bare, steady_state(bare))
        assert found.pin_on_roller.shape == (2, 3)
        return
    with pytest.raises(prsm.MissingDataError, match="roller has neither mass"):
        prsm.dynamics.body_forces(bare, Instant(array(1.0), array([0.0, 0.0]), array(1.0)))
