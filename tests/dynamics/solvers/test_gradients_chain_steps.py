"""Derivatives of states in a chain follow the variational equation along the solution."""

from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from chains import ANY, IN_CHAIN, drive, leader
from scenes import example

import prsm_jax as prsm
from prsm_jax.dynamics.histories._integration import Settings, integrated
from prsm_jax.dynamics.solvers import DrivenRate, Rodasp, gradient_of
from prsm_jax.dynamics.solvers.rodasp._solver import Rodasp as Solved
from prsm_jax.scenario import SineProfile

_POINT = jnp.array([30.0, 6.0, -0.7])


def _states(rate, gradient="forward", rtol=1e-6, constant=False):
    settings = Settings(Rodasp(), gradient_of(gradient), rtol, 0.01 * rtol, 20_000)

    def states(point):
        args = {"stiffness": point[0], "frequency": point[1], "share": point[2]}
        start, end = jnp.array([0.2, 0.1]), jnp.asarray(2.0)
        found, report = integrated(
            rate, start, end, jnp.zeros(0), 21, settings, args=args, autonomous=constant
        )
        return jnp.where(report.code == 0, found, jnp.nan)

    return states


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_errors_are_of_the_size_of_the_tolerance(rtol):
    """Derivatives of the steps' arithmetic have a third to a half of these errors."""
    exact = jax.jit(jax.jacfwd(_states(ANY, rtol=1e-12)))(_POINT)
    scale = jnp.abs(exact).max((0, 1), keepdims=True)
    found = jax.jit(jax.jacfwd(_states(IN_CHAIN, rtol=rtol)))(_POINT)
    # 3.3, 2.4 and 2.0 tolerances.
    assert float(jnp.max(jnp.abs(found - exact) / scale)) < 5 * rtol


def test_values_are_those_of_the_same_steps():
    found = [jax.jit(_states(rate))(_POINT) for rate in (IN_CHAIN, ANY)]
    np.testing.assert_allclose(*found, rtol=1e-11, atol=1e-13)


def test_reverse_mode_is_the_transpose_of_forward_mode():
    weights = jnp.linspace(1.0, 2.0, 42).reshape(21, 2)

    def total(gradient):
        return lambda point: jnp.sum(weights * _states(IN_CHAIN, gradient)(point))

    forward = jax.jit(jax.jacfwd(total("both")))(_POINT)
    for gradient in ("both", "reverse"):
        reverse = jax.jit(jax.grad(total(gradient)))(_POINT)
        np.testing.assert_allclose(reverse, forward, rtol=1e-10)


def test_second_derivatives_are_differences_of_the_first():
    def total(point):
        return jnp.sum(_states(IN_CHAIN, rtol=1e-10)(point)[:, 0] ** 2)

    slope = jax.jit(jax.jacfwd(total))
    second = jax.jit(jax.jacfwd(jax.jacfwd(total)))(_POINT)
    for k, step in enumerate((1e-2, 1e-4, 1e-4)):
        ahead = jnp.zeros(3).at[k].set(step)
        differences = (slope(_POINT + ahead) - slope(_POINT - ahead)) / (2 * step)
        # Slopes have errors of 1e-10 of their scale, which differences divide by their step.
        scale = jnp.sqrt(jnp.abs(second[k, k]) * jnp.abs(jnp.diagonal(second)))
        np.testing.assert_allclose(second[k] / scale, differences / scale, atol=3e-6)


def test_a_constant_drive_is_evaluated_once_for_a_step():
    args = {"stiffness": _POINT[0], "frequency": jnp.asarray(0.0), "share": _POINT[2]}
    time, times = jnp.asarray(0.3), jnp.linspace(0.3, 0.4, 5)
    constant = IN_CHAIN.with_constant_drive().closed(time, jnp.zeros(2), args)
    drives, change = constant.drives_at(times, args)
    assert len(drives) == 1
    assert change is None
    drives, change = IN_CHAIN.closed(time, jnp.zeros(2), args).drives_at(times, args)
    assert len(drives) == 5
    assert change is not None


def test_a_constant_drive():
    """The frequency has no effect then, and a parameter acts through the rates alone."""
    found = jax.jit(jax.jacfwd(_states(IN_CHAIN, rtol=1e-9, constant=True)))
    still = _POINT.at[1].set(0.0)
    exact = jax.jit(jax.jacfwd(_states(ANY, rtol=1e-12, constant=True)))(still)
    np.testing.assert_allclose(found(still)[..., ::2], exact[..., ::2], atol=2e-9)


@jax.custom_jvp
def _once(x):
    return jnp.tanh(x)


@jax.custom_jvp
def _slope_of_once(x):
    return 1 - jnp.tanh(x) ** 2


@_once.defjvp
def _(primals, tangents):
    return _once(*primals), _slope_of_once(*primals) * tangents[0]


@_slope_of_once.defjvp
def _(primals, tangents):
    raise AssertionError("a second derivative")


@pytest.mark.parametrize("constant", [False, True])
def test_first_derivatives_need_no_second_derivatives_of_the_rates(constant):
    def chain(drive, state, args):
        return [args["stiffness"] * (_once(args["share"] * drive[0] + 0.1 * y) - y) for y in state]

    def rate(drive, state, args):
        return jnp.stack(chain(drive, list(state), args))

    for gradient, mode in (("forward", jax.jacfwd), ("reverse", jax.jacrev)):
        in_chain = DrivenRate(drive, rate, leader, chain)
        slopes = mode(_states(in_chain, gradient, constant=constant))(_POINT)
        assert bool(jnp.all(jnp.isfinite(slopes)))
    with pytest.raises(AssertionError, match="a second derivative"):
        jax.jacfwd(_states(DrivenRate(drive, rate, leader), constant=constant))(_POINT)


def test_derivatives_stay_bounded_over_reversals_with_exact_friction():
    """At a tolerance of 1e-5, derivatives of the steps' arithmetic grew up to 1e33."""
    chain = example("li2021_two_stage")

    def ratio(amplitude, rtol):
        swing = SineProfile(amplitude=amplitude, frequency=jnp.asarray(5.0))
        scenario = prsm.Scenario(swing, jnp.asarray(1e3), jnp.asarray(0.45), samples=30)
        run = prsm.simulate(
            chain, scenario, method="rosenbrock", gradient="forward", rtol=rtol, atol=0.01 * rtol
        )
        return run.carrier_speed[:, 1:] / 100.0

    amplitude = jnp.asarray(100.0)
    of = jax.jit(jax.jacfwd(ratio))
    found = of(amplitude, 1e-5)
    value, step = jax.jit(ratio), 1e-3
    differences = value(amplitude + step, 1e-10) - value(amplitude - step, 1e-10)
    exact = differences / (2 * step)
    # 2.4e-5 was measured.
    assert float(jnp.abs(found - exact).max()) < 1e-4 * float(jnp.abs(exact).max())


def _moved_step(point):
    """The end of one step whose start and end, state and parameters move with three numbers."""
    args = {"stiffness": 30.0 * point[1], "frequency": jnp.asarray(6.0), "share": jnp.asarray(-0.7)}
    closed: Any = IN_CHAIN.closed(point[0], point[:2], args)
    start = jnp.array([0.2, 0.1]) * point[1]
    y1, *_ = Solved().step(
        diffrax.ODETerm(closed), point[0], point[2], start, args, None, made_jump=False
    )
    return y1


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
def test_ends_of_steps_that_move(direction):
    """Start, parameters and end of a step of 0.002, each alone, against differences of the step."""
    point, ahead = jnp.array([0.5, 1.0, 0.502]), 1e-5 * jnp.asarray(direction)
    _, found = jax.jvp(_moved_step, (point,), (jnp.asarray(direction),))
    differences = (_moved_step(point + ahead) - _moved_step(point - ahead)) / 2e-5
    # The step has an error of order five.
    np.testing.assert_allclose(found, differences, atol=3e-6)
    _, transposed = jax.vjp(_moved_step, point)
    back = jnp.stack([transposed(one)[0] for one in jnp.eye(2)])
    np.testing.assert_allclose(back @ jnp.asarray(direction), found, rtol=1e-12, atol=1e-14)


def test_steps_of_no_length_in_a_batch_are_finite():
    points = jnp.array([[0.5, 1.0, 0.5], [0.5, 1.0, 0.502]])
    slopes = jax.jit(jax.vmap(jax.jacfwd(_moved_step)))(points)
    assert bool(jnp.all(jnp.isfinite(slopes)))
    np.testing.assert_allclose(slopes[1], jax.jacfwd(_moved_step)(points[1]), rtol=1e-12)
