"""LuGre friction: bristles between the threads, against closed forms."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, mechanism, stage, steady_state, thread

import prsm_jax as prsm
from prsm_jax.dynamics import free_carrier_ratio, stage_kinematics
from prsm_jax.dynamics.friction._bristles import bristle_friction
from prsm_jax.dynamics.friction._thread_friction import thread_friction
from prsm_jax.dynamics.steady._carrier_balance import slip_per_turn
from prsm_jax.friction import (
    CoulombFriction,
    Deflected,
    Friction,
    FrictionLaw,
    LuGreFriction,
    SplineFriction,
    StribeckFriction,
)

LAW = LuGreFriction(
    static_coefficient=0.1,
    coefficient=0.08,
    stribeck_speed=0.1,
    bristle_stiffness=1e5,
    bristle_damping=4.0,
    damping_speed=0.01,
)


class Cosine(eqx.Module):
    """a cos 2πft; one structure for all tests, so that they share a program."""

    amplitude: jax.Array
    frequency: jax.Array

    def __call__(self, time):
        return self.amplitude * jnp.cos(2 * jnp.pi * self.frequency * time)


def _one(law: FrictionLaw = LAW, **more):
    return mechanism(stage(friction=Friction(thread=law), **more))


def _with(**numbers):
    one = _one()
    for name, value in numbers.items():
        one = prsm.set_parameter(one, f"friction.thread.{name}", value)
    return one


def _scenario(amplitude, frequency, duration, ratio=0.0):
    speed = Cosine(array(amplitude), array(frequency))
    return prsm.Scenario(speed, array(7e3), array(duration), array(ratio), samples=201)


@eqx.filter_jit
def _run(one, scenario):
    return prsm.simulate(one, scenario, method="rosenbrock", rtol=1e-8, atol=1e-10, throw=False)


@pytest.fixture(scope="module")
def reversing():
    return _run(_one(), _scenario(100.0, 5.0, 0.2))


def test_steady_slip_is_stribecks_law():
    slip = jnp.asarray([0.03, -0.2, 0.1])
    direction = slip / jnp.linalg.norm(slip)
    stribeck = StribeckFriction(0.1, 0.08, 0.1, 3.0)
    law = eqx.tree_at(
        lambda w: w.viscous_coefficient, LAW, array(3.0), is_leaf=lambda leaf: leaf is None
    )
    expected = thread_friction(stribeck, slip, direction)
    bent = expected[0] / law.bristle_stiffness
    contact = Deflected(slip, bent)
    for found in (bristle_friction(law, contact), thread_friction(law, slip, direction)):
        np.testing.assert_allclose(found[0], expected[0], rtol=1e-14)
        np.testing.assert_allclose(found[1], expected[1], rtol=1e-14)


def test_settles_at_the_steady_state():
    """To the solver's tolerance; the steady states of both laws agree to rounding."""
    run = _run(_one(), _scenario(100.0, 0.0, 2e-3))
    steady = steady_state(_one(), 100.0)
    stribeck = steady_state(_one(StribeckFriction(0.1, 0.08, 0.1)), 100.0)
    assert float(steady.efficiency) == pytest.approx(float(stribeck.efficiency), rel=1e-14)
    assert float(run.efficiency[-1]) == pytest.approx(float(steady.efficiency), rel=1e-8)
    assert float(run.carrier_ratio[0, -1]) == pytest.approx(
        float(steady.carrier_ratio[0]), rel=1e-8
    )


def test_before_slip_the_contact_is_a_spring():
    """Friction per force is σ₀ θ v₀ while the deflection is far below that of breaking away.

    Left out are the bristles' creep and damping, of relative size z/z₀ and σ₁ω/σ₀.
    """
    one, frequency, amplitude = _one(), 5.0, 2e-5
    geometry = stage_kinematics(one.stages[0])
    ratio = free_carrier_ratio(geometry)
    run = _run(one, _scenario(amplitude, frequency, 0.2, float(ratio)))
    angle = amplitude * np.sin(2 * np.pi * frequency * run.time) / (2 * np.pi * frequency)
    turn, normal = (
        (turns := slip_per_turn(geometry)).at(turns.free_ratio - ratio),
        geometry.meshing.screw.normal,
    )
    held = 1e5 * angle * float(turn[2])
    assert 1e-4 < np.max(held) < 1e-2
    # F = F_a / (|n_z| − σ₀ z_z)
    expected = 700.0 / (-float(normal[2]) - held)
    change, predicted = np.asarray(run.contact_force[0]) - 700.0 / -float(normal[2]), expected
    predicted = predicted - 700.0 / -float(normal[2])
    np.testing.assert_allclose(change, predicted, atol=0.02 * np.max(np.abs(predicted)))


def test_passes_standstill_and_reversal(reversing):
    """The power balance closes with the bristles' energy as a term of its own, to rounding."""
    assert int(reversing.solver.code) == 0
    assert np.max(reversing.power_balance_residual) < 1e-12
    assert np.max(reversing.newton_residual) < 1e-12
    lost, stored = reversing.losses["thread_sliding"], np.asarray(reversing.bristle_power)
    # Passive: the threads never give energy, beyond what damping borrows.
    assert np.min(lost) > -1e-6 * np.max(lost)
    assert np.max(np.abs(stored)) > 1e-3
    # Where the speed is greatest and nothing accelerates: screw-driven and load-driven.
    for sample, speed in ((100, -100.0), (200, 100.0)):
        expected = float(steady_state(_one(), speed).efficiency)
        assert float(reversing.efficiency[sample]) == pytest.approx(expected, rel=1e-4)


def test_stiff_bristles_approach_coulomb_friction():
    """The force that is missing after a start, integrated over time, falls as 1/σ₀."""
    ratio = float(free_carrier_ratio(stage_kinematics(_one().stages[0])))
    missing = []
    for stiffness in (1e5, 4e5, 1.6e6):
        one = _with(bristle_stiffness=stiffness, static_coefficient=0.08, bristle_damping=0.0)
        duration = 20 * 0.08 / (stiffness * 0.2)
        run = _run(one, _scenario(100.0, 0.0, duration, ratio))
        coulomb = steady_state(_one(CoulombFriction(0.08)), 100.0)
        deficit = float(coulomb.drive_torque) - np.asarray(run.drive_torque)
        assert abs(deficit[-1]) < 1e-3 * deficit[0]
        missing.append(np.trapezoid(deficit, run.time))
    # Carriers that begin at the steady ratio hardly move; trapezoids of width τ/10 err by 1e-3.
    np.testing.assert_allclose(np.array(missing[:-1]) / missing[1:], 4.0, rtol=0.02)


def test_derivatives_in_both_modes():
    """Half way through the run-up, one parameter at a time, against central differences."""
    one = _one()
    names = ("friction.thread.coefficient", "friction.thread.bristle_stiffness", "lead")
    base = jnp.stack([prsm.get_parameter(one, name) for name in names])

    def evaluate(changes):
        moved = one
        for name, value, change in zip(names, base, changes, strict=True):
            moved = prsm.set_parameter(moved, name, value * (1 + change))
        scenario = prsm.Scenario(array(100.0), array(5e3), array(3e-5), samples=3)
        run = prsm.simulate(
            moved, scenario, method="rosenbrock", rtol=1e-9, atol=1e-11, max_steps=512, throw=False
        )
        return jnp.stack([run.efficiency[1], 10 * run.carrier_ratio[0, 1]])

    forward = jax.jit(lambda at, direction: jax.jvp(evaluate, (at,), (direction,)))
    nothing, step, weights = jnp.zeros(3), 2e-3, jnp.asarray([1.0, -0.4])
    gradient = jax.jit(jax.grad(lambda changes: weights @ evaluate(changes)))(nothing)
    for direction in jnp.eye(3):
        _, slope = forward(nothing, direction)
        ahead, behind = (forward(s * step * direction, direction)[0] for s in (1, -1))
        differences = (ahead - behind) / (2 * step)
        assert np.max(np.abs(differences)) > 1e-3
        # A central difference errs by the third derivative times step²/6.
        np.testing.assert_allclose(slope, differences, rtol=1e-4, atol=1e-5)
        assert float(gradient @ direction) == pytest.approx(float(weights @ slope), rel=1e-8)


@eqx.filter_jit
def _driven(one, torque, duration):
    scenario = prsm.TorqueScenario(
        torque, prsm.scenario.HingeLoad(array(300.0)), duration, samples=101
    )
    return prsm.simulate(one, scenario, rtol=1e-7, atol=1e-9, method="rosenbrock", throw=False)


def test_prescribed_torque_without_events():
    """It holds a load where exact friction sticks, and runs up against the steady friction."""
    law = LuGreFriction(0.7, 0.7, 0.1, 1e5, 300.0, 0.01)
    one = _one(law, geometry=thread(contact_angle=np.pi / 3))
    for name in ("roller.mass", "roller.inertia", "carrier.inertia"):
        one = prsm.set_parameter(one, name, 1e-3 * prsm.get_parameter(one, name))
    held = _driven(one, array(0.0), array(0.1))
    assert int(held.solver.code) == 0
    assert np.max(held.power_balance_residual) < 1e-11
    # A spring: after it has settled nothing creeps, unlike regularised friction.
    assert abs(float(held.position[-1])) > 1e-6
    assert abs(float(held.position[-1] - held.position[50])) < 1e-9
    # J Ω̇ = T − M₊, what moves axially resisting through the thread with its friction. Left over
    # are rollers and carriers, a thousandth of themselves.
    run, upper = (
        _driven(one, array(3.0), array(0.1)),
        float(steady_state(one, 1.0, 300.0).drive_torque),
    )
    inertia = 1.7e-4 + 2.2 * float(prsm.get_parameter(one, "lead")) / (2 * np.pi) * upper / 300.0
    speed = np.asarray(run.screw_speed)
    gained = (speed[100] - speed[50]) / 0.05
    assert int(run.solver.code) == 0
    assert gained == pytest.approx((3.0 - upper) / inertia, rel=1e-3)


def test_other_friction_that_jumps_is_refused():
    first = stage(friction=Friction(thread=LAW))
    second = stage(friction=Friction(thread=LAW, spline=SplineFriction(0.1, 12e-3)))
    scenario = prsm.TorqueScenario(array(1.0), prsm.scenario.HingeLoad(array(300.0)), array(1.0))
    with pytest.raises(ValueError, match=r"stage 2: friction\.spline jumps there"):
        prsm.simulate(mechanism(first, second), scenario)
