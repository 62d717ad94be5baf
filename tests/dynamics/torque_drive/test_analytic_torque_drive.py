"""Prescribed torque: stick and slip with exact Coulomb friction, against closed forms."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import Swing, array, mechanism, stage, steady_state, thread

import prsm_jax as prsm
from prsm_jax.friction import CoulombFriction, Friction, StribeckFriction
from prsm_jax.mechanism import body_inertia, body_mass
from tests.present import present

LOAD = 300.0
AMPLITUDE, FREQUENCY = 3.0, 2.0


def _one(coefficient=0.08):
    """Flanks at 30°: self-locking above a coefficient of tan 30° = 0.577."""
    geometry = thread(contact_angle=np.pi / 3)
    return mechanism(
        stage(friction=Friction(thread=CoulombFriction(coefficient)), geometry=geometry)
    )


def _scenario(mean=0.0, amplitude=0.0, frequency=FREQUENCY, load=None, duration=1.0, start=0.0):
    torque = Swing(array(mean), array(amplitude), array(frequency))
    hinge = prsm.scenario.HingeLoad(array(LOAD)) if load is None else load
    position = array(start)
    return prsm.TorqueScenario(torque, hinge, array(duration), initial_position=position)


@eqx.filter_jit
def _run(one, scenario):
    return prsm.simulate(one, scenario, throw=False)


@eqx.filter_jit
def _run_forward(one, scenario):
    return prsm.simulate(one, scenario, throw=False, gradient="forward")


def _swinging(amplitude=AMPLITUDE):
    return _scenario(0.0, amplitude)


def _limits(one, load=LOAD):
    """Torque of steady motion backward and forward [N·m]: the limits of sticking."""
    return tuple(float(steady_state(one, sense * 1.0, load).drive_torque) for sense in (-1, 1))


@pytest.fixture(scope="module")
def swinging():
    # Self-locking: the load alone cannot turn the screw back.
    return _run(_one(0.7), _swinging())


def test_sticks_until_a_limit_is_passed(swinging):
    """Event times of a sine in closed form, as long as it starts from rest."""
    lower, upper = _limits(_one(0.7))
    assert lower < 0 < upper
    modes = np.asarray(swinging.phases.mode)
    starts = np.asarray(swinging.phases.start)
    assert int(swinging.solver.code) == 0
    assert modes[0] == 0.0
    assert modes[1] == 1.0
    # Located to 1e-10 of the duration.
    expected = np.arcsin(upper / AMPLITUDE) / (2 * np.pi * FREQUENCY)
    assert starts[1] == pytest.approx(expected, abs=1e-9)
    sticking = np.asarray(swinging.sticking)
    assert 0.1 < sticking.mean() < 0.9
    applied = np.asarray(swinging.drive_torque)
    np.testing.assert_allclose(
        applied, AMPLITUDE * np.sin(2 * np.pi * FREQUENCY * np.asarray(swinging.time)), atol=1e-12
    )
    # Complementarity: at rest the torque lies between the limits, in motion slip opposes friction.
    assert np.all(np.asarray(swinging.screw_speed)[sticking] == 0)
    assert np.all((applied[sticking] >= lower - 1e-9) & (applied[sticking] <= upper + 1e-9))
    lost = np.asarray(swinging.losses["thread_sliding"])
    assert np.all(lost[~sticking] > 0)
    assert np.all(lost[sticking] == 0)


def test_speed_after_breaking_away():
    """J Ω = ∫(A sin ωt − M₊) dt from the breakaway on, until the first phase of turning ends.

    With rollers and carriers without inertia, which would turn the slip a little and with it the
    friction: then one inertia holds for all times, to the tolerance of the integration.
    """
    one = _one(0.7)
    for name in ("roller.mass", "roller.inertia", "carrier.inertia"):
        one = prsm.set_parameter(one, name, 1e-9 * prsm.get_parameter(one, name))
    run = _run(one, _swinging())
    _, upper = _limits(one)
    omega = 2 * np.pi * FREQUENCY
    start, end = (float(getattr(run.phases, name)[1]) for name in ("start", "end"))
    time = np.asarray(run.time)
    turning = (time > start) & (time < end)
    impulse = AMPLITUDE * (np.cos(omega * start) - np.cos(omega * time)) / omega
    impulse = (impulse - upper * (time - start))[turning]
    travel = float(prsm.get_parameter(one, "lead")) / (2 * np.pi)
    inertia = float(body_inertia(one.stages[0], "screw"))
    # What moves axially resists through the thread, with its friction: torque per axial force.
    axial = float(body_mass(one.stages[0], "nut")) * travel
    carriers = one.stages[0].carrier
    if carriers is not None and carriers.mass is not None:
        axial += carriers.count * float(carriers.mass) * travel
    inertia += axial * upper / LOAD
    expected = impulse / inertia
    speed = np.asarray(run.screw_speed)[turning]
    assert len(speed) > 5
    np.testing.assert_allclose(speed, expected, rtol=1e-6, atol=1e-6 * expected.max())
    # It stops when the impulse is used up.
    rest = AMPLITUDE * (np.cos(omega * start) - np.cos(omega * end)) / omega - upper * (end - start)
    assert rest == pytest.approx(0.0, abs=1e-8)


def test_power_balance(swinging):
    """Drive, load, losses and kinetic energy close while it turns, to the root's tolerance."""
    turning = ~np.asarray(swinging.sticking)
    assert np.max(np.asarray(swinging.power_balance_residual)[turning]) < 1e-9
    assert np.max(swinging.newton_residual) < 1e-9


def test_self_locking_holds_without_torque():
    """Friction above the locking limit: no torque, full load, nothing moves."""
    run = _run(_one(0.7), _scenario(duration=0.1))
    assert np.all(run.sticking)
    assert np.all(np.asarray(run.screw_speed) == 0)
    free = _run(_one(0.01), _scenario(duration=0.1))
    # Below it the load drives the screw back.
    assert not np.any(free.sticking)
    assert float(free.screw_speed[-1]) < 0


def test_spring_load_swings_and_sticks():
    """A nut on a preloaded spring, released beside the balance of a constant torque.

    It swings with exact friction, each time less far, and rests where the torque lies between the
    two limits of the load that it has there.
    """
    one = _one(0.02)
    lower, upper = _limits(one, 2000.0)
    load = prsm.scenario.HingeLoad(array(2000.0), array(5e5))
    balance = (lower + upper) / 2
    run = _run(one, _scenario(balance, load=load, duration=0.2, start=1e-3))
    assert int(run.solver.code) == 0
    position = 1e-3 + np.asarray(run.position)
    assert bool(run.sticking[-1])
    modes = np.asarray(run.phases.mode)
    turns = np.asarray(run.phases.end) - np.asarray(run.phases.start) > 0
    swings = modes[turns & (modes != 0)]
    assert len(swings) >= 3
    # Forward and backward in turn: it does not pause until it stays.
    assert np.all(swings[1:] == -swings[:-1])
    assert np.max(np.abs(position[50:])) < 1e-3
    low, high = _limits(one, float(2000.0 + 5e5 * position[-1]))
    assert low <= balance <= high


def test_derivative_through_events():
    """Speed and position at the end, and the time of breaking away, by friction and amplitude."""

    def evaluate(values):
        one = prsm.set_parameter(_one(0.7), "friction.thread.coefficient", values[0])
        run = prsm.simulate(one, _swinging(values[1]), throw=False)
        return jnp.stack([run.screw_speed[40], run.position[60] * 1e3, run.phases.start[1] * 1e3])

    point, step = jnp.asarray([0.7, 3.0]), 1e-4
    forward = np.asarray(jax.jit(jax.jacfwd(evaluate))(point))
    value = jax.jit(evaluate)
    for index in range(2):
        move = step * point[index] * jnp.eye(2)[index]
        difference = (value(point + move) - value(point - move)) / (2 * step * point[index])
        np.testing.assert_allclose(forward[:, index], difference, rtol=1e-5, atol=1e-6)
    assert np.all(np.abs(forward[1:]) > 1e-3)


def test_running_out_of_phases_is_reported():
    """Forty reversals in a second are more than the 32 phases that are followed by default."""
    run = _run(_one(0.7), _scenario(0.0, AMPLITUDE, 40.0))
    assert int(run.solver.code) == 5
    assert "most_phases" in run.solver.result


def test_spring_load_through_no_load():
    """A nut between two springs, swung by the torque: the flanks change as it passes the middle."""
    one, load = _one(0.02), prsm.scenario.HingeLoad(array(0.0), array(5e5), array(50.0))
    run, other = (
        _run(one, _scenario(0.0, sign * AMPLITUDE, load=load, duration=0.5)) for sign in (1, -1)
    )
    assert int(run.solver.code) == int(other.solver.code) == 0
    position = np.asarray(run.position)
    assert position.min() < -1e-4
    assert position.max() > 1e-4
    # A half turn about a radial axis.
    np.testing.assert_allclose(present(other.position), -position, atol=1e-9 * np.max(position))
    turning = ~np.asarray(run.sticking)
    assert np.max(np.asarray(run.power_balance_residual)[turning]) < 1e-9
    assert np.min(run.contact_force) >= 0
    assert np.min(np.asarray(run.losses["thread_sliding"])) >= 0


def test_two_hundred_phases():
    """Dither at 20 Hz for 5 s: every phase of sticking ends where the torque is at a limit."""
    one, frequency = _one(0.7), 20.0
    scenario = _scenario(0.0, AMPLITUDE, frequency, duration=5.0)
    scenario = dataclasses.replace(scenario, samples=1001, most_phases=256)
    run = _run_forward(one, scenario)
    assert int(run.solver.code) == 0
    start, end, mode = (np.asarray(getattr(run.phases, name)) for name in ("start", "end", "mode"))
    there = end > start
    assert np.sum(there) > 200
    assert start[0] == 0
    assert end[there][-1] == pytest.approx(5.0, rel=1e-12)
    # No gap between one and the next.
    np.testing.assert_array_equal(start[there][1:], end[there][:-1])
    ended = end[there & (mode == 0) & (end < 5.0 - 1e-9)]
    assert len(ended) > 90
    torque = AMPLITUDE * np.sin(2 * np.pi * frequency * ended)
    limits = np.array(_limits(one))
    # Located to 1e-10 of the duration, in which the torque changes by 2π f A · 5e-10 N·m.
    distance = np.min(np.abs(torque[:, None] - limits[None, :]), axis=1)
    assert np.max(distance) < 1e-6


def test_a_phase_that_is_passed_over_is_reported():
    """A torque that is zero at every step, and beyond the limits in between."""
    run = _run(_one(0.7), _scenario(0.0, AMPLITUDE, 800.0))
    assert int(run.solver.code) == 8
    assert "raise samples" in run.solver.result


def test_static_friction_holds_and_sliding_friction_moves():
    """Stribeck's law: it breaks away at the static coefficient, and then needs less."""
    law = StribeckFriction(0.7, 0.5, 1e-3)
    one = mechanism(stage(friction=Friction(thread=law), geometry=thread(contact_angle=np.pi / 3)))
    scenario = dataclasses.replace(_swinging(), samples=21)
    run = _run_forward(one, scenario)
    _, static = _limits(_one(0.7))
    _, sliding = _limits(_one(0.5))
    assert sliding < static
    first = np.arcsin(static / AMPLITUDE) / (2 * np.pi * FREQUENCY)
    assert float(run.phases.start[1]) == pytest.approx(first, abs=1e-9)


def test_a_pulse_much_shorter_than_a_step():
    """J Ω = (T − M₊) w − M₊ (t − t_end) after a pulse of torque T and width w, as in one step.

    Steps end where the torque jumps; otherwise a pulse between two steps of 1 ms is not seen.
    """
    one = _one(0.7)
    for name in ("roller.mass", "roller.inertia", "carrier.inertia"):
        one = prsm.set_parameter(one, name, 1e-9 * prsm.get_parameter(one, name))
    _, upper = _limits(one)
    size, begin, edge, samples = 1e4, 0.105 - 2e-4, 1e-9, 41

    @eqx.filter_jit
    def run(width):
        times = jnp.stack([0 * width, begin + 0 * width, begin + edge, begin + width])
        times = jnp.concatenate([times, times[-1:] + edge])
        torque = prsm.scenario.TableProfile(times, array([0.0, 0.0, size, size, 0.0]))
        load = prsm.scenario.HingeLoad(array(LOAD))
        scenario = prsm.TorqueScenario(torque, load, array(0.2), samples=samples)
        return prsm.simulate(one, scenario, throw=False)

    speeds, impulses = [], []
    for width in (1e-4, 1e-6):
        found = run(array(width))
        assert int(found.solver.code) == 0
        speeds.append(float(found.screw_speed[21]))
        rest = float(found.time[21]) - begin - width
        impulses.append(size * width - upper * (width + rest))
    assert speeds[1] > 0
    assert speeds[0] / speeds[1] == pytest.approx(impulses[0] / impulses[1], rel=1e-5)
