"""Transients of a differential roller screw: its carriers move the nut along the axis.

The reference integrates virtual power in NumPy and SciPy: slips and travel of the rigid bodies come
from `type_motion`, the normal force from the axial balance of nut and rollers, which
holds the acceleration of the carriers.
"""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
from present import present
from scenes import Swing, array, mesh, simulate, steady_state
from type_motion import mechanism, reversal, slips_of, with_law

import prsm_jax as prsm
from prsm_jax.dynamics import axial_inertia, carrier_inertia
from prsm_jax.friction import LuGreFriction, RegularisedCoulombFriction
from prsm_jax.report.motion_charts import power_history, travel_of

MEAN, SWING, RATE, LOAD, FRICTION = 100.0, 60.0, 900.0, 5e3, 0.06


@functools.cache
def _one(friction=FRICTION):
    return mechanism("differential", friction=friction, extra=False)


@functools.cache
def _parts(side_speed):
    """Slip at the screw and travel per radian, for screw and carrier speeds of 1."""
    one = _one()
    thread = one.stages[0].thread
    slips, travel = slips_of(thread, mesh(thread), [side_speed], "differential")
    return slips["screw"], travel


def _reference(speed_at, times, load, start):
    one = _one()
    (stage,) = one.stages
    count, mass = stage.roller_count, float(axial_inertia(stage))
    inertia = float(carrier_inertia(stage))
    (base, travel), (moved, further) = _parts(0.0), _parts(1.0)
    per_carrier, per_travel = moved - base, further - travel
    share = abs(float(mesh(stage.thread).screw.normal_parts[2]))

    def rates(time, state):
        speed, rate = speed_at(time)
        slip = speed * base + state[0] * per_carrier
        unit = slip / np.linalg.norm(slip)
        # Unknown: ω̇ and the normal force of one roller. The screw's friction acts along its slip.
        # Axial balance: N F (n_z − μ u_z) = F_load − m z̈, with z̈ = travel Ω̇ + travel' ω̇ of the
        # nut, which the load opposes. Virtual power of a turn of the carrier: friction on the
        # roller, load and inertia of the nut.
        matrix = np.array(
            [
                [mass * per_travel, count * (share - FRICTION * unit[2])],
                [inertia + mass * per_travel**2, count * FRICTION * unit @ per_carrier],
            ]
        )
        right = np.array(
            [load - mass * travel * rate, load * per_travel - mass * per_travel * travel * rate]
        )
        return [np.linalg.solve(matrix, right)[0]]

    solved = scipy.integrate.solve_ivp(
        rates, (0.0, times[-1]), [start], t_eval=times, rtol=1e-10, atol=1e-10, method="LSODA"
    )
    return solved.y[0]


@functools.cache
def _run(swings=True):
    one = _one()
    speed = Swing(array(MEAN), array(SWING), array(RATE)) if swings else MEAN
    scenario = prsm.Scenario(speed, LOAD, 4e-3, initial_carrier_ratio=0.1, samples=81)
    return simulate(one, scenario, method="rosenbrock", rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("swings", [False, True])
def test_carrier_speed_is_that_of_virtual_power(swings):
    run = _run(swings)
    speed = Swing(array(MEAN), array(SWING), array(RATE))

    def speed_at(time):
        if not swings:
            return MEAN, 0.0
        value, rate = jax.jvp(speed, (jnp.asarray(time),), (jnp.ones(()),))
        return float(value), float(rate)

    times = np.asarray(run.time)
    start = 0.1 * speed_at(0.0)[0]
    expected = _reference(speed_at, times, LOAD, start)
    # Of the tolerances of both integrations; the carriers change by 0.3 of the screw's speed.
    np.testing.assert_allclose(np.asarray(run.carrier_speed)[0], expected, rtol=2e-7)


@pytest.mark.parametrize("swings", [False, True])
def test_power_and_moments_balance(swings):
    run = _run(swings)
    # Of the largest power; the balance holds the kinetic energy of the nut's own travel.
    assert float(jnp.max(run.power_balance_residual)) < 1e-10
    # Lagrange's carrier acceleration satisfies the roller's own moment balance.
    assert float(jnp.max(run.newton_residual)) < 1e-10


def test_it_settles_to_the_steady_state():
    run, state = _run(False), steady_state(_one(), MEAN, LOAD)
    last = float(run.carrier_ratio[0, -1])
    assert last == pytest.approx(float(state.carrier_ratio[0]), rel=1e-8)
    assert float(run.drive_torque[-1]) == pytest.approx(float(state.drive_torque), rel=1e-8)
    assert float(run.efficiency[-1]) == pytest.approx(float(state.efficiency), rel=1e-8)
    assert float(run.contact_force[0, -1]) == pytest.approx(float(state.contact_force[0]), rel=1e-8)


def test_travel_and_power_of_the_load_follow_the_carriers():
    one, run = _one(), _run(True)
    reduced = float(one.stages[0].thread.lead) / (2 * np.pi)
    speed = np.asarray(run.screw_speed) - np.asarray(run.carrier_speed)[0]
    np.testing.assert_allclose(np.asarray(run.load_power), LOAD * reduced * speed, rtol=1e-13)
    powers = power_history(one, run)
    np.testing.assert_allclose(powers.load, -LOAD * reduced * speed, rtol=1e-13)
    steps = np.diff(np.asarray(run.time))
    expected = reduced * np.sum(steps * (speed[1:] + speed[:-1]) / 2)
    assert travel_of(one, run)[-1] == pytest.approx(expected, rel=1e-13)
    # The remainder of the powers is the rate of the kinetic energy, with the nut's own speed.
    mass, inertia = float(axial_inertia(one.stages[0])), float(carrier_inertia(one.stages[0]))
    screw = float(prsm.mechanism.body_inertia(one.stages[0], "screw"))
    kinetic = 0.5 * mass * (reduced * speed) ** 2
    kinetic += 0.5 * inertia * np.asarray(run.carrier_speed)[0] ** 2
    kinetic += 0.5 * screw * np.asarray(run.screw_speed) ** 2
    # Simpson's rule on the second half, in which the carriers have settled: 22 samples a period.
    half = slice(40, None)
    gained = -scipy.integrate.simpson(powers.kinetic[half], x=np.asarray(run.time)[half])
    assert gained == pytest.approx(kinetic[-1] - kinetic[40], rel=1e-3)


@pytest.mark.parametrize("load", [LOAD, -LOAD])
@pytest.mark.usefixtures("memory_for_large_programs")
def test_losses_inside_the_ellipses_and_both_flanks(load):
    """Spin makes the forces depend on the normal force otherwise than in proportion."""
    (stage,) = _one().stages
    friction = dataclasses.replace(present(stage.friction), spin=prsm.friction.SpinFriction(0.06))
    one = dataclasses.replace(
        _one(), stages=(dataclasses.replace(stage, friction=friction, sharing="equal"),)
    )
    speed = Swing(array(MEAN), array(SWING), array(RATE))
    run = simulate(one, prsm.Scenario(speed, load, 1e-3, initial_carrier_ratio=0.1, samples=21))
    assert run.solver.name == "RODASP"
    assert float(jnp.max(run.power_balance_residual)) < 1e-9
    assert float(jnp.max(run.newton_residual)) < 1e-9


def test_reversal_with_friction_that_is_smooth_at_standstill():
    one = with_law(_one(), RegularisedCoulombFriction(FRICTION, 1e-3))
    run = simulate(one, reversal(LOAD))
    assert float(jnp.max(run.power_balance_residual)) < 1e-10
    assert run.solver.name == "RODASP"


def test_derivatives_are_central_differences():
    one = _one()

    def last(friction):
        stage = one.stages[0]
        law = dataclasses.replace(present(present(stage.friction).thread), coefficient=friction)
        losses = dataclasses.replace(present(stage.friction), thread=law)
        moved = dataclasses.replace(one, stages=(dataclasses.replace(stage, friction=losses),))
        speed = Swing(array(MEAN), array(SWING), array(RATE))
        scenario = prsm.Scenario(speed, array(LOAD), 1e-3, initial_carrier_ratio=0.1, samples=9)
        run = prsm.simulate(moved, scenario, method="rosenbrock", rtol=1e-10, atol=1e-12)
        return run.carrier_ratio[0, -3]

    at, step = array(FRICTION), 1e-5
    value = jax.jit(last)
    forward = float(jax.jit(jax.jacfwd(last))(at))
    reverse = float(jax.jit(jax.grad(last))(at))
    difference = float(value(at + step) - value(at - step)) / (2 * step)
    assert forward == pytest.approx(difference, rel=1e-5)
    assert reverse == pytest.approx(forward, rel=1e-6)


def test_what_is_not_known_is_refused():
    one = _one()
    torque = prsm.TorqueScenario(1.0, LOAD, 1e-3)
    with pytest.raises(prsm.MissingDataError, match=r"torque are not known for type = .diff"):
        prsm.simulate(one, torque)
    with pytest.raises(ValueError, match=r"'quasi_steady' is not for type = .differential"):
        prsm.simulate(one, prsm.Scenario(MEAN, LOAD, 1e-3), method="quasi_steady")
    lugre = with_law(one, LuGreFriction(0.08, 0.06, 0.1, 1e7, 10.0))
    with pytest.raises(prsm.MissingDataError, match="LuGre friction of the threads is not known"):
        prsm.simulate(lugre, prsm.Scenario(MEAN, LOAD, 1e-3))
    # Other types hold none of it.
    standard = mechanism("standard")
    scenario = prsm.Scenario(MEAN, LOAD, 1e-3)
    traced = prsm.programs.traced_physics
    names = traced(lambda m: prsm.simulate(m, scenario, method="rosenbrock").efficiency, standard)
    assert "nut_moved_by_carriers" not in names
    names = traced(lambda m: prsm.simulate(m, scenario, method="rosenbrock").efficiency, one)
    assert "nut_moved_by_carriers" in names


def test_a_load_that_depends_on_the_motion_is_refused():
    """Friction changes the travel of the nut, which is not that of the turns of the screw."""
    load = prsm.scenario.HingeLoad(constant=3000.0, stiffness=2e5)
    scene = prsm.Scenario(speed=60.0, load=load, duration=0.05)
    with pytest.raises(prsm.MissingDataError, match=r"type 'differential'.*function of time"):
        prsm.simulate(_one(), scene)
