"""What drives a right-hand side is computed once for each time, and changes no number."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from prsm_jax.dynamics._driven_rate import DrivenRate
from prsm_jax.dynamics._integration import Settings, integrated
from prsm_jax.dynamics._solvers import Method


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


def _states(rate, gradient, method: Method = "rosenbrock"):
    settings = Settings(method, gradient, 1e-7, 1e-9, 4096)

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
