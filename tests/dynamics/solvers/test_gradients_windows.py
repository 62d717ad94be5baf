"""Derivatives along an integration in windows: however many windows it has, and what they cost."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from chains import ANY, IN_CHAIN

from prsm_jax.dynamics.histories._integration import Settings, integrated
from prsm_jax.dynamics.solvers import DrivenRate, ReverseMode, Rodasp, gradient_of
from prsm_jax.dynamics.solvers.rodasp import _windows

#: Stiffness, frequency, share, scale of the start, and the end of the integration.
_POINT = jnp.array([30.0, 6.0, -0.7, 1.0, 2.0])


def _states(gradient, rtol=1e-6, samples=21, breaks=(), moves=False, most=4096, rate=IN_CHAIN):
    mode = gradient_of(gradient)
    settings = Settings(Rodasp(), mode, rtol, 0.01 * rtol, most)

    def never(time):
        return jnp.full_like(time, jnp.inf), jnp.full_like(time, jnp.inf)

    def states(point):
        args = {"stiffness": point[0], "frequency": point[1], "share": point[2]}
        start = point[3] * jnp.array([0.2, 0.1])
        found, report = integrated(
            rate,
            start,
            point[4],
            jnp.asarray(breaks, float),
            samples,
            settings,
            args=args,
            standstills=never if moves else None,
        )
        return found, report

    return states


def _scaled(found, exact):
    """Largest difference of the derivatives by each number, over the largest derivative by it."""
    axes = tuple(range(exact.ndim - 1))
    return jnp.max(jnp.abs(found - exact), axes) / jnp.max(jnp.abs(exact), axes)


_SCENES = {
    "plain": {},
    "breaks": {"breaks": (0.33, 1.13)},
    "reversals": {"moves": True},
    "breaks and reversals": {"breaks": (0.33, 1.13), "moves": True},
    "many samples": {"samples": 300},
}


@pytest.mark.parametrize("scene", list(_SCENES))
def test_forward_and_reverse_agree_in_one_window_and_in_many(scene, monkeypatch):
    """106 to 118 steps; in many windows the states at their ends are integrated again."""
    weights = jnp.linspace(1.0, 2.0, 2 * _SCENES[scene].get("samples", 21)).reshape(-1, 2)

    def of(gradient, mode):
        states = _states(gradient, **_SCENES[scene])
        return jax.jit(mode(lambda point: jnp.sum(weights * states(point)[0])))(_POINT)

    exact = of("forward", jax.jacfwd)
    for tried in (125, 11):
        monkeypatch.setattr(_windows, "_TRIED", tried)
        forward, reverse = of("both", jax.jacfwd), of("both", jax.grad)
        np.testing.assert_allclose(reverse, forward, rtol=1e-13)
        # Forward mode alone differentiates the same steps while it takes them.
        np.testing.assert_allclose(forward, exact, rtol=1e-13)


@pytest.mark.parametrize("gradient", ["forward", "both"])
def test_steps_next_to_a_reversal_move_with_it(gradient):
    """Steps that follow them stay: errors were 25 tolerances where they moved, too."""
    scene = _SCENES["breaks and reversals"]

    def by_frequency(gradient, rtol):
        states = _states(gradient, rtol, **scene)
        return jax.jit(jax.jacfwd(lambda f: states(_POINT.at[1].set(f))[0]))(_POINT[1])

    exact = by_frequency("forward", 1e-11)
    for rtol in (1e-6, 1e-8):
        error = jnp.max(jnp.abs(by_frequency(gradient, rtol) - exact)) / jnp.max(jnp.abs(exact))
        # 1.1 and 0.9 tolerances.
        assert float(error) < 2 * rtol


def test_errors_are_of_the_size_of_the_tolerance():
    exact = jax.jit(jax.jacfwd(lambda p: _states("forward", 1e-11)(p)[0]))(_POINT)
    for rtol in (1e-5, 1e-7):
        found = jax.jit(jax.jacrev(lambda p, rtol=rtol: _states("reverse", rtol)(p)[0]))(_POINT)
        error = _scaled(found, exact)
        # The last one, by the end, is the slope of the interpolation, of one order less.
        assert float(jnp.max(error[:4])) < 5 * rtol
        assert float(error[4]) < 40 * rtol


def test_a_batch_whose_designs_need_different_numbers_of_windows(monkeypatch):
    monkeypatch.setattr(_windows, "_TRIED", 11)

    def total(point):
        found, report = _states("reverse")(point)
        return jnp.sum(found), report.steps

    slope = jax.jit(jax.grad(total, has_aux=True))
    points = jnp.stack([_POINT, _POINT.at[0].set(3.0), _POINT.at[4].set(0.05)])
    found, steps = jax.jit(jax.vmap(jax.grad(total, has_aux=True)))(points)
    assert -(-int(steps.max()) // 11) > -(-int(steps.min()) // 11) + 3
    for point, one in zip(points, found, strict=True):
        np.testing.assert_allclose(one, slope(point)[0], rtol=1e-12, atol=1e-14)


def test_forward_mode_over_reverse_mode(monkeypatch):
    monkeypatch.setattr(_windows, "_TRIED", 60)

    def total(gradient):
        return lambda point: jnp.sum(_states(gradient, 1e-8)(jnp.append(point, 2.0))[0][:, 0] ** 2)

    exact = jax.jit(jax.jacfwd(jax.jacfwd(total("forward"))))(_POINT[:4])
    found = jax.jit(jax.jacfwd(jax.grad(total("both"))))(_POINT[:4])
    scale = jnp.sqrt(jnp.outer(jnp.abs(jnp.diagonal(exact)), jnp.abs(jnp.diagonal(exact))))
    np.testing.assert_allclose(found / scale, exact / scale, atol=1e-13)


def test_an_integration_that_is_out_of_steps_has_finite_derivatives(monkeypatch):
    """One step too few; the two windows alone would have room for it."""
    counted = jax.jit(_states("reverse"))(_POINT)[1]
    needed = int(counted.steps + counted.rejected)
    monkeypatch.setattr(_windows, "_TRIED", needed // 2 + 1)

    def total(point, most):
        found, report = _states("reverse", most=most)(point)
        return jnp.sum(jnp.where(jnp.isfinite(found), found, 0.0)), (found, report)

    def of(most):
        return jax.jit(jax.grad(functools.partial(total, most=most), has_aux=True))(_POINT)

    slopes, (_, report) = of(needed - 1)
    assert (
        int(report.code) == int(jax.jit(_states("reverse", most=needed - 1))(_POINT)[1].code) == 1
    )
    assert bool(jnp.all(jnp.isfinite(slopes)))
    # Far too few: the samples that are reached are those of an integration without derivatives.
    slopes, (found, report) = of(needed // 2)
    plain = jax.jit(_states("reverse", most=needed // 2))(_POINT)[0]
    reached = jnp.isfinite(plain)
    assert int(report.code) == 1
    assert bool(jnp.any(reached))
    np.testing.assert_array_equal(jnp.isfinite(found), reached)
    np.testing.assert_allclose(found[reached], plain[reached], rtol=1e-13)
    assert bool(jnp.all(jnp.isfinite(slopes)))
    slopes, (_, report) = of(needed)
    assert int(report.code) == 0


def test_a_drive_that_jumps_has_its_left_value_at_the_end_of_a_step():
    """By hand: ẏ = k (u − y), with u from 1 to p at a break."""

    def drive(time, args):
        return (jnp.where(time < 1.0, 1.0, args["after"]),)

    def chain(drive, state, args):
        return [args["rate"] * (drive[0] - y) for y in state]

    def rate(drive, state, args):
        return jnp.stack(chain(drive, list(state), args))

    jumps = DrivenRate(drive, rate, None, chain)
    settings = Settings(Rodasp(), gradient_of("reverse"), 1e-9, 1e-11, 4096)

    def last(k, after):
        args = {"rate": k, "after": after}
        start, end = jnp.zeros(1), jnp.asarray(1.5)
        found, _ = integrated(jumps, start, end, jnp.ones(1), 4, settings, args=args)
        return found[-1, 0]

    k, after = 3.0, 0.4
    at_break = 1 - np.exp(-k)
    by_after = 1 - np.exp(-0.5 * k)
    by_rate = np.exp(-k) * np.exp(-0.5 * k) - 0.5 * (at_break - after) * np.exp(-0.5 * k)
    found = jax.jit(jax.grad(last, (0, 1)))(jnp.asarray(k), jnp.asarray(after))
    np.testing.assert_allclose(found, [by_rate, by_after], rtol=1e-8)


def test_other_modes_and_solvers_repeat_their_steps():
    """Recorded windows are for states in a chain, and for the modes that declare it."""

    class Checkpointed(ReverseMode):
        along_steps = False

    def found(gradient, rate):
        total = jax.grad(lambda p: jnp.sum(_states(gradient, rate=rate)(p)[0]))
        # The equation of the transposed function, by the name of its primitive.
        return "linear_with_transpose" in str(jax.make_jaxpr(total)(_POINT))

    assert found("reverse", IN_CHAIN)
    assert found("both", IN_CHAIN)
    assert not found(Checkpointed(), IN_CHAIN)
    assert not found("reverse", ANY)
