"""The Rosenbrock solver on problems whose solutions are known, and its small linear systems."""

import functools

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array

from prsm_jax.dynamics.solvers._step_control import _OF_THE_PAST, _OF_THE_REST
from prsm_jax.dynamics.solvers.rodasp._solver import Rodasp
from prsm_jax.numerics import solve_small

TIMES = np.linspace(0.0, 2.0, 41)


def _spiral(time, state, rate):
    """y' = A(t) y with y = e^{sin t} (cos rt, sin rt): not autonomous, with a closed form."""
    x, y = state["x"], state["y"]
    growth = jnp.cos(time)
    return {"x": growth * x - rate * y, "y": growth * y + rate * x}


@functools.partial(jax.jit, static_argnames=("steps",))
def _solve_spiral(steps, rate):
    return diffrax.diffeqsolve(
        diffrax.ODETerm(_spiral),
        Rodasp(),
        array(0.0),
        array(2.0),
        array(2.0) / steps,
        {"x": array(1.0), "y": array(0.0)},
        args=rate,
        saveat=diffrax.SaveAt(t1=True, ts=jnp.asarray(TIMES)),
        max_steps=4096,
    ).ys


def _error(steps):
    """Error at the end, and the largest one between the steps."""
    found = _solve_spiral(steps, array(3.0))
    size = np.exp(np.sin(TIMES))
    exact = np.stack([size * np.cos(3 * TIMES), size * np.sin(3 * TIMES)])
    errors = np.abs(np.stack([found["x"], found["y"]])[:, : len(TIMES)] - exact)
    return errors[:, -1].max(), errors.max()


def test_order_four_at_the_steps_and_between():
    """Halving the step divides both errors by 16, within what the next order adds."""
    errors = np.array([_error(steps) for steps in (40, 80, 160)])
    ratios = errors[:-1] / errors[1:]
    assert np.all((ratios > 13) & (ratios < 20))


def _stiff(time, state, rate):
    """Prothero and Robinson: y = cos t is smooth, whatever the rate."""
    return -rate * (state - jnp.cos(time)) - jnp.sin(time)


@jax.jit
def _solve_stiff(rate):
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(_stiff),
        Rodasp(),
        array(0.0),
        array(2.0),
        None,
        jnp.ones(1),
        args=rate,
        stepsize_controller=diffrax.PIDController(rtol=1e-8, atol=1e-10),
    )
    return solution.ys[-1, 0], solution.stats["num_steps"]


@pytest.mark.parametrize("rate", [1e2, 1e4, 1e6, 1e12])
def test_stiff_problems_cost_fewer_steps_the_stiffer_they_are(rate):
    """L-stable and stiffly accurate, without order reduction: the work falls with the stiffness.

    The first RODAS method takes 1105, 37 and 4 steps here.
    """
    found, steps = _solve_stiff(array(rate))
    assert abs(float(found) - np.cos(2.0)) < 1e-8
    assert int(steps) < 60


def test_derivatives():
    """Forward and reverse through the steps, against the closed form of ∂x/∂rate."""

    def end(rate):
        return _solve_spiral(160, rate)["x"][-1]

    exact = -np.exp(np.sin(2.0)) * 2.0 * np.sin(6.0)
    forward = jax.jvp(
        lambda rate: diffrax.diffeqsolve(
            diffrax.ODETerm(_spiral),
            Rodasp(),
            array(0.0),
            array(2.0),
            array(2.0) / 160,
            {"x": array(1.0), "y": array(0.0)},
            args=rate,
            adjoint=diffrax.ForwardMode(),
        ).ys["x"][-1],
        (array(3.0),),
        (array(1.0),),
    )[1]
    # The error of 160 steps of order 4.
    assert float(forward) == pytest.approx(exact, abs=1e-6)
    assert float(jax.jit(jax.grad(end))(array(3.0))) == pytest.approx(float(forward), rel=1e-10)


@pytest.mark.parametrize("size", [1, 2, 4, 8, 9])
def test_small_systems(size):
    """Against LAPACK, for matrices of the kind `I/(γh) − J`."""
    generator = np.random.default_rng(size)
    matrix = generator.normal(size=(size, size)) + 3 * size * np.eye(size)
    right = generator.normal(size=size)
    found = solve_small(jnp.asarray(matrix))(jnp.asarray(right))
    np.testing.assert_allclose(found, np.linalg.solve(matrix, right), rtol=1e-13)


def _approach(time, state, args):
    """Deviations of carriers next to a standstill at time 0: y′ = −k y / |t|."""
    return -args * state / jnp.abs(time)


@jax.jit
def _left_by_a_step(stiffness, start, end):
    """What one step leaves of a deviation of 1."""
    solver, terms = Rodasp(), diffrax.ODETerm(_approach)
    found = solver.step(terms, start, end, jnp.ones(1), stiffness, None, False)
    return found[0][0]


@pytest.mark.parametrize(
    ("start", "share", "limit", "too_long", "grown"),
    [
        # In the limit of stiff carriers, by the coefficients of the method.
        (-1.0, _OF_THE_REST, 0.54, 0.65, 40.1),
        (1.0, _OF_THE_PAST, 0.685, 9.0, 20.3),
    ],
)
def test_steps_next_to_a_standstill_leave_less_of_a_deviation(start, share, limit, too_long, grown):
    """Before it time constants shrink within the step, behind it they grow."""
    stiffness = jnp.logspace(-2, 9, 200)
    left = jax.vmap(_left_by_a_step, (0, None, None))

    def after(length):
        return np.abs(left(stiffness, array(start), array(start + length)))

    assert after(share).max() < 1
    assert after(share)[-1] == pytest.approx(limit, rel=2e-2)
    assert after(too_long)[-1] == pytest.approx(grown, rel=2e-2)


def _leaves(time, state, args):
    """A state that leaves 0 within a thousandth of the step."""
    return args * state


@pytest.mark.parametrize("compact", [False, True])
def test_a_step_in_which_a_state_grows_too_far_counts_as_wrong(compact):
    """Any L-stable method damps growth, so the estimate of the error alone would be next to 0."""
    solver, terms = Rodasp(compact=compact), diffrax.ODETerm(_leaves)

    @jax.jit
    def error(start, length, rate):
        small = 1e-9 * jnp.ones(2)
        end = start + length
        return solver.step(terms, start, end, small, rate, None, False)[1]

    one = array(1.0)
    assert np.all(error(array(0.0), one, array(800.0)) >= 1)
    assert np.all(np.abs(error(array(0.0), one, array(0.9))) < 1e-9)
    assert np.all(np.abs(error(array(0.0), one, array(-800.0))) < 1e-9)
    # A step that is as short as times can tell apart cannot be made shorter.
    assert np.all(np.abs(error(array(1e4), array(1e-11), array(1e12))) < 1e-7)
