"""Reverse mode through runs whose steps are taken again: torques that jump, stages, batches."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, mechanism, stage, thread

import prsm_jax as prsm
from prsm_jax.dynamics.histories._integration import Settings
from prsm_jax.dynamics.solvers import Rodasp, gradient_of
from prsm_jax.dynamics.solvers._recorded_steps import Again, Steps
from prsm_jax.dynamics.torque_drive._phases import PhaseLaws, follow_phases
from prsm_jax.dynamics.torque_drive._stick_slip import follow_carriers
from prsm_jax.dynamics.torque_drive._torque_balance import torque_problem
from prsm_jax.friction import CoulombFriction, Friction
from tests.roots import root_between


def _brake(values, gradient):
    """x′ = −a − 0.3 x + 0.1 sin 3t from b until x = 0; x half way, and when it ends."""
    deceleration, start = values
    laws = PhaseLaws(
        begin=lambda share, kept: ({"mode": jnp.ones(())}, kept),
        rate=lambda share, state, label: -deceleration - 0.3 * state + 0.1 * jnp.sin(3 * share),
        margin=lambda share, state, label: state[0] + 1e-12,
        end=lambda state, label, ended: state,
        longest=lambda label: array(0.25),
    )
    settings = Settings(Rodasp(), gradient_of(gradient), 1e-8, 1e-10, 256)
    solver = Rodasp().make_solver(1e-8, 1e-10, compact=True)
    times = jnp.linspace(0.0, 1.0, 5)
    found = follow_phases(laws, start[None], times, jnp.zeros(0), 1, solver, settings)
    return found.states[1, 0] + 2 * found.phases.end[0]


def test_reverse_in_a_batch_of_different_numbers_of_steps():
    """Some stop and some do not: those that have arrived wait for the others."""
    points = jnp.asarray([[2.0, 1.0], [0.5, 1.0], [0.1, 1.0], [3.0, 1.0]])

    def slopes(transform, gradient):
        evaluate = lambda values: _brake(values, gradient)  # noqa: E731
        return np.asarray(jax.jit(jax.vmap(transform(evaluate)))(points))

    forward, reverse = slopes(jax.jacfwd, "forward"), slopes(jax.grad, "reverse")
    assert np.all(np.isfinite(forward))
    np.testing.assert_allclose(reverse, forward, rtol=1e-6)
    step = 1e-5
    for row, point in zip(forward, np.asarray(points), strict=True):
        for index in range(2):
            move = step * np.eye(2)[index]
            above, below = (_brake_exactly(*(point + way * move)) for way in (1, -1))
            assert row[index] == pytest.approx((above - below) / (2 * step), rel=1e-6)


def _brake_exactly(deceleration, start):
    """The same in closed form, and its root by bisection."""
    sine, cosine = 0.03 / 9.09, -0.3 / 9.09
    constant = -deceleration / 0.3
    free = start - constant - cosine

    def at(time):
        waves = sine * np.sin(3 * time) + cosine * np.cos(3 * time)
        return free * np.exp(-0.3 * time) + constant + waves

    end = 1.0 if at(1.0) > 0 else root_between(at, 0.0, 1.0, xtol=1e-15)
    return at(0.25) + 2 * end


#: Friction of the first stage, torque before its jump, and inertia of the rollers.
_POINT = (0.7, 4.0, 0.4)


def _end(values, stages, gradient, rtol=1e-7):
    """Screw and carriers at the end, and the phases, of a torque that jumps between two samples.

    It breaks away at once, is braked from 12.3 ms on by friction and half the torque, and stops.
    """
    friction = Friction(thread=CoulombFriction(0.7))
    parts = [stage(friction=friction, geometry=thread(contact_angle=np.pi / 3))] * stages
    chain = mechanism(*parts)
    chain = prsm.set_parameter(chain, "friction.thread.coefficient", values[0])
    chain = prsm.set_parameter(chain, "roller.inertia", values[2] * 1e-6)
    times = array([0.0, 0.0123, 0.0123 + 1e-9, 0.05])
    torque = jnp.stack([values[1], values[1], values[1] / 4, values[1] / 4])
    scenario = prsm.TorqueScenario(
        prsm.scenario.TableProfile(times, torque),
        prsm.scenario.HingeLoad(array(300.0)),
        array(0.05),
        samples=5,
        most_phases=3,
    )
    problem = torque_problem(chain, scenario)
    settings = Settings(Rodasp(), gradient_of(gradient), rtol, 1e-2 * rtol, 1024)
    run = follow_carriers(problem, jnp.linspace(0.0, 0.05, 5), settings)
    found = jnp.stack(
        [run.angle[-1], run.speed[2] / 1e2, *run.carrier_speed[1] / 1e2, run.solution.phases.end[0]]
    )
    weights = jnp.asarray([1.0, -0.6, 0.5, 0.3])[: stages + 2]
    weights = jnp.concatenate([weights, jnp.asarray([2.0])])
    return jnp.where(run.solution.code == 0, weights @ found, jnp.nan)


@pytest.mark.parametrize("stages", [2])
def test_reverse_agrees_with_forward_in_a_batch(stages):
    """Torques of either size in one batch, whose runs have different numbers of steps."""
    points = jnp.asarray(np.array(_POINT) * np.array([[1.0, 1.0, 1.0], [0.95, 1.6, 2.0]]))

    def slopes(transform, gradient):
        evaluate = lambda values: _end(values, stages, gradient)  # noqa: E731
        return np.asarray(jax.jit(jax.vmap(transform(evaluate)))(points))

    forward, reverse = slopes(jax.jacfwd, "forward"), slopes(jax.grad, "reverse")
    assert np.all(np.isfinite(forward))
    assert np.all(np.abs(forward) > 1e-6)
    # Each to some tens of the solver's tolerance: forward mode moves the lengths of steps as well.
    np.testing.assert_allclose(reverse, forward, rtol=1e-5, atol=1e-6 * np.max(np.abs(forward)))


def test_forward_agrees_with_differences():
    """Through a jump of the torque and a stop."""
    point = np.array(_POINT)
    evaluate = jax.jit(lambda values: _end(values, 1, "forward", 1e-9))
    forward = np.asarray(jax.jit(jax.jacfwd(lambda v: _end(v, 1, "forward", 1e-9)))(point))
    for index in range(3):
        move = 1e-4 * point[index] * np.eye(3)[index]
        above, below = float(evaluate(point + move)), float(evaluate(point - move))
        assert forward[index] == pytest.approx((above - below) / (2 * move[index]), rel=1e-3)


def test_steps_taken_again_move_with_the_start_as_far_as_a_jump():
    """A jump of what drives stays at its time, and so do the steps behind it."""
    behind = np.nextafter(1.0, 2.0)
    none = [np.inf]
    steps = Steps(
        jnp.asarray([0.0, 0.5, behind, 1.5, *none]),
        jnp.asarray([0.5, 1.0, 1.5, 2.0, *none]),
        jnp.asarray(4),
    )

    def times(start):
        controller = Again(steps)
        nothing: Any = (None,) * 6
        end, state = controller.init(None, start, array(2.0), *nothing[:5])
        found = [start, end]
        for _ in range(3):
            _, start, end, _, state, _ = controller.adapt_step_size(
                start, end, *nothing[:5], controller_state=state
            )
            found += [start, end]
        return jnp.stack(found)

    values, slopes = jax.jvp(times, (array(0.0),), (array(1.0),))
    assert values.tolist() == [0.0, 0.5, 0.5, 1.0, behind, 1.5, 1.5, 2.0]
    assert slopes.tolist() == [1, 1, 1, 0, 0, 0, 0, 0]
