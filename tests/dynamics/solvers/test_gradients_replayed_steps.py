"""Reverse mode through runs whose steps are taken again: torques that jump, stages, batches."""

import functools
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
from prsm_jax.dynamics.torque_drive._stick_slip import _Law, follow_carriers
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
#: Two such points, whose runs have different numbers of steps.
_POINTS = np.array(_POINT) * np.array([[1.0, 1.0, 1.0], [0.95, 1.6, 2.0]])
#: Time at which the torque jumps, and duration of the scene [s].
_JUMP, _DURATION = 0.0123, 0.05


def _problem(values, stages):
    """A torque that jumps between two samples.

    The screw breaks away at once, is braked by friction and a quarter of the torque after the jump,
    and stops.
    """
    friction = Friction(thread=CoulombFriction(0.7))
    parts = [stage(friction=friction, geometry=thread(contact_angle=np.pi / 3))] * stages
    chain = mechanism(*parts)
    chain = prsm.set_parameter(chain, "friction.thread.coefficient", values[0])
    chain = prsm.set_parameter(chain, "roller.inertia", values[2] * 1e-6)
    times = array([0.0, _JUMP, _JUMP + 1e-9, _DURATION])
    torque = jnp.stack([values[1], values[1], values[1] / 4, values[1] / 4])
    scenario = prsm.TorqueScenario(
        prsm.scenario.TableProfile(times, torque),
        prsm.scenario.HingeLoad(array(300.0)),
        array(_DURATION),
        samples=5,
        most_phases=3,
    )
    return torque_problem(chain, scenario)


def _end(values, gradient):
    """Screw and carrier at the end, and the phases."""
    settings = Settings(Rodasp(), gradient_of(gradient), 1e-9, 1e-11, 1024)
    run = follow_carriers(_problem(values, 1), jnp.linspace(0.0, _DURATION, 5), settings)
    speeds = [run.speed[2], run.carrier_speed[1, 0]]
    found = jnp.stack([run.angle[-1], *speeds, run.solution.phases.end[0]])
    weights = jnp.asarray([1.0, -0.6e-2, 0.5e-2, 2.0])
    return jnp.where(run.solution.code == 0, weights @ found, jnp.nan)


def test_forward_reverse_and_differences_agree_in_a_batch():
    """Through a jump of the torque and a stop; runs of a batch have different numbers of steps."""
    moves = 1e-4 * _POINTS[:, None] * np.eye(3)
    moved = np.stack([_POINTS[:, None] + moves, _POINTS[:, None] - moves])
    batch = jnp.asarray(np.concatenate([_POINTS, moved.reshape(-1, 3)]))

    def along(values):
        slopes, value = jax.jacfwd(lambda v: (_end(v, "forward"),) * 2, has_aux=True)(values)
        return value, slopes

    def back(values):
        return jax.value_and_grad(lambda v: _end(v, "reverse"))(values)

    found, forward = (np.asarray(one) for one in jax.jit(jax.vmap(along))(batch))
    values, reverse = (np.asarray(one) for one in jax.jit(jax.vmap(back))(batch))
    assert np.all(np.isfinite(forward))
    assert np.all(np.abs(forward) > 1e-6)
    np.testing.assert_allclose(values, found, rtol=1e-7)
    # Each to some tens of the solver's tolerance: forward mode moves the lengths of steps as well.
    np.testing.assert_allclose(reverse, forward, rtol=1e-7, atol=1e-8 * np.max(np.abs(forward)))
    above, below = found[len(_POINTS) :].reshape(2, len(_POINTS), 3)
    differences = (above - below) / (2 * np.diagonal(moves, axis1=1, axis2=2))
    np.testing.assert_allclose(forward[: len(_POINTS)], differences, rtol=1e-3)


#: Share of the duration, then angle and speeds of the screw and of both carriers: at the start with
#: the carriers in the ratio in which they settle, turning, and with one that coasts.
_MOTIONS = (
    (0.0, 0.0, 0.4, np.inf, np.inf),
    (0.1, 0.02, 0.4, 0.12, 0.13),
    (0.3, 0.05, 0.1, 0.6, 0.02),
)


def test_two_stages_agree_in_what_is_integrated():
    """How a phase begins, its rate, its margin and its end, by forward, reverse and differences."""

    def laws(values, motion):
        law = _Law(_problem(values, 2), array(_DURATION), array(500.0))
        share, persistent = motion[0], motion[1:]
        label, state = law.begin(share, persistent)
        rate, margin = law.rate(share, state, label), law.margin(share, state, label)
        end = law.end(state + 1e-3 * rate, label, jnp.asarray(False))
        return jnp.concatenate([state, rate, end, margin[None]])

    def of_all(values):
        def of(motion):
            at = functools.partial(laws, motion=motion)
            return at(values), jax.jacfwd(at)(values), jax.jacrev(at)(values)

        return jax.vmap(of)(jnp.asarray(_MOTIONS))

    point, run = np.array(_POINT), jax.jit(of_all)
    _, forward, reverse = (np.asarray(one) for one in run(point))
    sizes = np.max(np.abs(forward), axis=1)
    assert np.all(sizes > 1e-6)
    np.testing.assert_allclose(
        reverse / sizes[:, None], forward / sizes[:, None], rtol=0, atol=1e-11
    )
    for index in range(3):
        move = 1e-5 * point[index] * np.eye(3)[index]
        above, below = (np.asarray(run(point + way * move)[0]) for way in (1, -1))
        expected = (above - below) / (2 * move[index])
        missed = np.max(np.abs(forward[..., index] - expected), axis=1)
        # The tangent at the start is found by a search, whose rounding the differences see.
        assert np.all(missed < 1e-5 * sizes[:, index])


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
