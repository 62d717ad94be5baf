"""Loads that push the other way: symmetry, balances through no load, flanks of single stages."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import (
    ALL_LOSSES,
    array,
    mechanism,
    simulate,
    stage,
    steady_state,
    thread,
)

import prsm_jax as prsm
from prsm_jax.dynamics import all_kinematics, states_at
from prsm_jax.friction import (
    CoulombFriction,
    Drag,
    Friction,
    SplineFriction,
    StribeckFriction,
    ThrustBearingFriction,
)
from prsm_jax.scenario import SineProfile


def _two():
    friction = Friction(
        CoulombFriction(0.05),
        spline=SplineFriction(0.1, 12e-3),
        thrust_bearing=ThrustBearingFriction(0.005, 20e-3),
    )
    return mechanism(stage(), stage(geometry=thread(5e-3), friction=friction))


def _wave(amplitude, frequency, mean=0.0):
    return SineProfile(array(amplitude), array(frequency), array(mean), array(0.0))


def _scenario(sign, load_mean=0.0):
    speed = _wave(20.0 * sign, 50.0, 100.0 * sign)
    load = _wave(3000.0 * sign, 30.0, load_mean * sign)
    return prsm.Scenario(speed, load, array(0.05), array(0.37), samples=101)


@pytest.mark.parametrize("method", ["rosenbrock", "quasi_steady"])
def test_reflection_and_power_through_no_load(method):
    """A half turn about a radial axis: speeds, torques and axial forces change their sign only."""
    run, other = (simulate(_two(), _scenario(sign), method=method) for sign in (1.0, -1.0))
    assert int(run.solver.code) == int(other.solver.code) == 0
    # Exactly, but for what the integrator makes of another order of sums.
    tolerance = 0.0 if method == "quasi_steady" else 1e-7
    for name in ("contact_force", "ring_gear_force", "carrier_force", "carrier_ratio"):
        same = np.asarray(getattr(other, name))
        largest = float(np.max(np.abs(same)))
        np.testing.assert_allclose(getattr(run, name), same, rtol=0, atol=tolerance * largest)
    for name in ("drive_torque", "load", "carrier_speed", "spline_friction"):
        turned = -np.asarray(getattr(other, name))
        scale = np.max(np.abs(turned))
        np.testing.assert_allclose(getattr(run, name), turned, rtol=0, atol=tolerance * scale)
    # Without load the carriers coast for an instant, and stay near where they were.
    assert np.all(np.abs(np.asarray(run.carrier_ratio) - 0.374) < 0.2)
    # Passages of zero; every loss takes power at every instant.
    assert np.sum(np.diff(np.sign(run.load[1:])) != 0) >= 2
    assert np.min(run.contact_force) >= 0
    assert np.min(run.losses["thread_sliding"]) >= 0
    assert np.max(run.power_balance_residual) < 1e-12
    assert np.max(run.newton_residual) < 1e-10


def test_a_stage_changes_flank_by_itself():
    """The inertia of a heavy first nut wins over a small load, that of the second does not."""
    two = prsm.set_parameter(_two(), "stage.1.nut.mass", array(40.0))
    # At 6300 rad/s² the first nut takes 40 kg · 1.6 mm/rad of that, 400 N, the second 40 N.
    scenario = prsm.Scenario(
        _wave(20.0, 50.0, 100.0), _wave(0.0, 30.0, 200.0), array(0.05), array(0.37), samples=101
    )
    run = simulate(two, scenario, method="quasi_steady")
    kinematics = all_kinematics(two)

    @jax.jit
    def flanks(times, speeds):
        def at(time, speed):
            states = states_at(two, kinematics, scenario, time, speed)
            return jnp.stack([state.flank_sign for state in states])

        return jax.vmap(at)(times, speeds)

    found = np.asarray(flanks(run.time, run.carrier_speed.T))
    patterns = {tuple(row) for row in found.tolist()}
    assert patterns == {(1.0, 1.0), (-1.0, 1.0)}
    assert int(run.solver.code) == 0
    assert np.max(run.power_balance_residual) < 1e-12


@pytest.mark.usefixtures("memory_for_large_programs")
def test_at_no_load_everything_is_finite_and_its_derivative_too():
    """Losses in the contact ellipses included; past zero the other efficiency begins.

    A second stage can have all of them: the first one's screw slides in no spline.
    """
    first = Friction(CoulombFriction(0.06), drag=Drag(0.05))
    two = mechanism(stage(friction=first), stage(friction=ALL_LOSSES, geometry=thread(5e-3)))

    @jax.jit
    def everything(load):
        def torque(value):
            scenario = prsm.Scenario(array(100.0), value, array(1e-3), samples=2)
            run = prsm.simulate(two, scenario, method="quasi_steady", throw=False)
            finite = [jnp.isfinite(leaf).all() for leaf in jax.tree.leaves(run)]
            return run.drive_torque[0], (jnp.stack(finite).all(), run.solver.code)

        (value, flags), reverse = jax.value_and_grad(torque, has_aux=True)(load)
        _, forward, _ = jax.jvp(torque, (load,), (jnp.ones_like(load),), has_aux=True)
        return value, reverse, forward, flags

    at = {load: everything(array(load)) for load in (-1e3, -1e-3, 0.0, 1e-3, 1e3)}
    for _, reverse, forward, (finite, code) in at.values():
        assert bool(finite)
        assert int(code) == 0
        assert float(forward) == pytest.approx(float(reverse), rel=1e-12)
    # Drag alone is left.
    assert float(at[0.0][0]) == pytest.approx(0.1, rel=1e-2)
    assert float(at[0.0][1]) == pytest.approx(float(at[1e-3][1]), rel=1e-3)
    # The slope is a finite difference: the load is a line on either side but for the ellipses.
    for low, high in ((-1e3, -1e-3), (1e-3, 1e3)):
        rise = (float(at[high][0]) - float(at[low][0])) / (high - low)
        ends = sorted((float(at[low][1]), float(at[high][1])))
        assert ends[0] * (1 - 1e-6) <= rise <= ends[1] * (1 + 1e-6)
    # Screw-driven it takes more than what comes back when the load pushes along.
    assert float(at[1e3][1]) > float(at[-1e3][1]) > 0


def test_viscous_part_helps_to_carry():
    """Friction that needs no normal force shifts the load at which the flanks change."""
    law = StribeckFriction(0.06, 0.05, 0.1, 25.0)
    one = mechanism(stage(friction=Friction(thread=law)))
    shift = -10 * 25.0 * 100.0 * 10e-3 / (2 * np.pi)
    below, above = (steady_state(one, 100.0, shift + side) for side in (-1.0, 1.0))
    for state in (below, above):
        assert bool(state.valid)
        assert float(state.power_balance_residual) < 1e-12
        # One newton in ten rollers, through a flank of 45°.
        assert float(state.contact_force[0]) == pytest.approx(0.1 * np.sqrt(2), rel=0.15)
    # A load that pushes the other way, and still the usual flanks carry.
    middle = steady_state(one, 100.0, shift / 2)
    assert bool(middle.valid)
    assert float(middle.contact_force[0]) == pytest.approx(-shift / 20 * np.sqrt(2), rel=0.15)


def test_derivatives_of_a_transient_through_no_load():
    """Forward, reverse and finite differences of what comes after two changes of flanks."""
    one = mechanism(stage())

    def evaluate(value):
        load = eqx.tree_at(lambda s: s.load.amplitude, _scenario(1.0, 500.0), value)
        run = prsm.simulate(one, load, method="rosenbrock", rtol=1e-9, atol=1e-11, throw=False)
        return run.drive_torque[70] + run.drive_torque[30]

    at = array(3000.0)
    pushed = jax.jit(lambda value: jax.jvp(evaluate, (value,), (jnp.ones_like(value),)))
    above, below = (float(pushed(at * (1 + way * 1e-5))[0]) for way in (1, -1))
    difference = (above - below) / (2e-5 * float(at))
    forward, reverse = float(pushed(at)[1]), float(jax.jit(jax.grad(evaluate))(at))
    # The steps of both are the same, their sums are not.
    assert reverse == pytest.approx(forward, rel=1e-7)
    assert forward == pytest.approx(difference, rel=1e-4)
