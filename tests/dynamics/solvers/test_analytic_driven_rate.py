"""What drives a right-hand side is computed once for each time, and changes no number."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.dynamics.histories._integration import Settings, integrated
from prsm_jax.dynamics.solvers import (
    DrivenRate,
    ForwardMode,
    MethodName,
    Rodasp,
    gradient_of,
    method_of,
)


def _drive(time, frequency):
    return jnp.sin(frequency * time), jnp.cos(frequency * time)


def _rate(drive, state, frequency):
    sine, cosine = drive
    size = jnp.sqrt(1.0 + (state[0] - sine) ** 2 + (state[1] - cosine) ** 2)
    first = (sine - state[0]) / (size + sine**2)
    second = (cosine - state[1]) / (size * (1.0 + frequency) + cosine**2)
    return 20.0 * jnp.stack([first + second * cosine, second - first * sine])


def _at_once(time, state, frequency):
    return _rate(_drive(time, frequency), state, frequency)


def _states(rate, gradient, method: MethodName = "rosenbrock"):
    settings = Settings(method_of(method), gradient_of(gradient), 1e-7, 1e-9, 4096)

    def states(frequency):
        start = jnp.array([0.1, 0.9])
        end, breaks = jnp.asarray(1.0), jnp.zeros(0)
        return integrated(rate, start, end, breaks, 5, settings, args=frequency)[0]

    return states


@pytest.mark.parametrize("method", ["rosenbrock", "explicit", "implicit"])
def test_states_and_derivatives_are_those_of_the_same_function_in_one_piece(method):
    # Both take the same steps but for rounding, and lengths of steps have few digits.
    found = []
    for rate in (DrivenRate(_drive, _rate), _at_once):
        states = _states(rate, "forward", method)
        found.append(
            jax.jit(lambda f, of=states: jax.jvp(of, (f,), (jnp.ones_like(f),)))(jnp.asarray(3.0))
        )
    for split, whole in zip(*found, strict=True):
        np.testing.assert_allclose(split, whole, rtol=1e-10, atol=1e-12)


def test_reverse_mode_agrees_with_forward():
    states, frequency = _states(DrivenRate(_drive, _rate), "both"), jnp.asarray(3.0)
    weights = jnp.linspace(1.0, 2.0, 10).reshape(5, 2)

    def total(f):
        return jnp.sum(weights * states(f))

    forward, reverse = jax.jit(lambda f: (jax.jacfwd(total)(f), jax.grad(total)(f)))(frequency)
    np.testing.assert_allclose(reverse, forward, rtol=1e-10)


def _stiff(drive, state, args):
    # States that follow a swinging number: y = c sin(wt) + (c w/k) terms, in closed form below.
    return args["stiffness"] * (args["share"] * drive[0] - state)


def _swing(time, args):
    return jnp.sin(args["frequency"] * time), args["frequency"] * jnp.cos(args["frequency"] * time)


def _closed_form(times, start, args):
    """States of the linear equation above."""
    k, w, c = args["stiffness"], args["frequency"], args["share"]
    forced = k * (k * jnp.sin(w * times) - w * jnp.cos(w * times)) / (k**2 + w**2)
    decay = start + c * k * w / (k**2 + w**2)
    return jnp.outer(forced, c) + jnp.outer(jnp.exp(-k * times), decay)


@pytest.mark.parametrize("stiffness", [30.0, 3e3, 3e6])
def test_states_that_follow_a_leader(stiffness):
    """The equation of motion is the same, and samples between long steps are as exact."""
    args = {
        "stiffness": jnp.asarray(stiffness),
        "frequency": jnp.asarray(6.0),
        "share": jnp.array([0.4, -0.7]),
    }
    start, end, samples = jnp.array([0.2, 0.1]), jnp.asarray(3.0), 31
    settings = Settings(Rodasp(), ForwardMode(), 1e-6, 1e-8, 4096)

    def run(rate):
        def found(share):
            given = args | {"share": share}
            return integrated(rate, start, end, jnp.zeros(0), samples, settings, args=given)

        share = args["share"]
        states, report = found(share)
        return states, jax.jacfwd(lambda s: found(s)[0])(share), report.code

    leading = DrivenRate(_swing, _stiff, lambda drive, _: drive)
    states, slopes, code = jax.jit(lambda: run(leading))()
    times = jnp.linspace(0.0, 3.0, samples)
    exact = _closed_form(times, start, args)
    by_share = jax.jacfwd(lambda s: _closed_form(times, start, args | {"share": s}))(args["share"])
    # Hundreds of steps, each of an error of 1e-6 of the state at most.
    np.testing.assert_allclose(states, exact, atol=1e-5)
    np.testing.assert_allclose(slopes, by_share, atol=1e-5)
    assert int(code) == 0


def test_steps_end_before_the_screw_reverses():
    """Two strokes of two stages with Coulomb friction; 420 steps and 133 rejected ones before."""
    mechanism = prsm.load("li2021_two_stage")
    swing = prsm.scenario.SineProfile(amplitude=jnp.asarray(100.0), frequency=jnp.asarray(5.0))
    scenario = prsm.Scenario(swing, jnp.asarray(1e3), jnp.asarray(0.2), samples=21)

    def run(rtol):
        return prsm.simulate(
            mechanism, scenario, method="rosenbrock", rtol=rtol, atol=0.01 * rtol, max_steps=8192
        )

    found, exact = run(1e-6), run(1e-9)
    assert int(found.solver.steps) <= 260
    assert int(found.solver.rejected) <= 80
    np.testing.assert_allclose(found.carrier_speed, exact.carrier_speed, atol=2e-5 * 37.0)


def test_sines_are_not_computed_anew_for_what_follows_from_them():
    """A step evaluates at five times, where six stages, a Jacobian and a slope use the numbers."""

    def sines(rate):
        states = jax.jit(jax.vmap(_states(rate, "forward")))
        text = str(states.lower(jnp.linspace(2.0, 3.0, 3)).compile().as_text())
        return text.count(" sine(") + text.count(" cosine(")

    split, whole = sines(DrivenRate(_drive, _rate)), sines(_at_once)
    # Of the start, 2; of a step, 10 and 2 for the slope; diffrax evaluates once more.
    assert split <= 20
    assert whole >= 2 * split
