"""Sine and cosine for several numbers at once: accuracy, derivatives, and where they are used."""

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from scenes import array

from prsm_jax import Scenario
from prsm_jax.numerics import sine_and_cosine, with_batched_trigonometry
from prsm_jax.scenario import SineProfile

ANGLES = st.floats(-1e12, 1e12)


@settings(deadline=None, max_examples=200)
@given(ANGLES)
@example(np.pi)
@example(355.0)  # Nearly a multiple of π.
@example(np.pi / 4)
@example(-1e-300)
def test_sine_and_cosine_against_forty_digits(angle):
    """Within the rounding of a number up to 1, and that of the angle."""
    with mpmath.workdps(40):
        exact = mpmath.sin(mpmath.mpf(angle)), mpmath.cos(mpmath.mpf(angle))
        found = sine_and_cosine(array(angle))
        for one, other in zip(found, exact, strict=True):
            assert abs(mpmath.mpf(float(one)) - other) <= 2.3e-16 + 1.2e-16 * abs(angle)


@settings(deadline=None, max_examples=50)
@given(st.floats(-1e5, 1e5))
def test_small_results_keep_their_digits(angle):
    """Sine next to a multiple of π, cosine next to an odd multiple of π/2."""
    near = np.pi * round(angle / np.pi)
    for of_pair, at in enumerate((near, near + np.pi / 2)):
        exact = (mpmath.sin, mpmath.cos)[of_pair](mpmath.mpf(at))
        found = float(sine_and_cosine(array(at))[of_pair])
        # The angle is off the multiple by half a rounding, so the result is at most that large.
        assert abs(found - exact) <= 1e-9 * abs(exact) + 1e-27


def test_every_angle_has_a_sine():
    """Infinite angles have none; beyond 1e16 nothing is left of an angle, but the bounds hold."""
    large = jnp.asarray([1e16, -1e18, 1e300])
    for values in sine_and_cosine(large):
        assert np.all(np.abs(values) <= 1)
    for values in sine_and_cosine(jnp.asarray([jnp.inf, -jnp.inf, jnp.nan])):
        assert np.all(np.isnan(values))


@pytest.mark.parametrize("mode", [jax.jacfwd, jax.jacrev])
def test_derivatives_of_every_order(mode):
    angle = array(2.1)
    sines = [lambda x: sine_and_cosine(x)[0]]
    for _ in range(3):
        sines.append(mode(sines[-1]))
    for one, other in zip(
        sines, (np.sin, np.cos, lambda x: -np.sin(x), lambda x: -np.cos(x)), strict=True
    ):
        # A few roundings of numbers up to 1.
        np.testing.assert_allclose(one(angle), other(2.1), atol=1e-15)


def _speed(amplitude):
    """A function of a user, with a function that is compiled by itself, and a closure."""

    @jax.jit
    def inside(time):
        return jnp.sin(3 * time)

    def speed(time):
        turned = 2 * time
        return amplitude * (jnp.sin(turned) + inside(time) * jnp.cos(turned) + jnp.cos(turned))

    return speed


def test_functions_keep_their_values_and_derivatives():
    def both(wrap):
        def at(amplitude, time):
            return wrap(_speed(amplitude))(time)

        return jax.jit(jax.vmap(jax.value_and_grad(at, (0, 1)))), jax.jit(
            jax.vmap(jax.hessian(at, (0, 1)))
        )

    points = jnp.linspace(0.5, 2.0, 5), jnp.linspace(-3.0, 40.0, 5)
    for one, other in zip(both(with_batched_trigonometry), both(lambda x: x), strict=True):
        # Roundings of numbers up to 20, of angles up to 120.
        jax.tree.map(
            lambda x, y: np.testing.assert_allclose(x, y, atol=1e-12), one(*points), other(*points)
        )


def _primitives(jaxpr):
    """Names of all primitives of a program, also of the functions that it calls."""
    for equation in jaxpr.eqns:
        yield equation.primitive.name
        for inner in ("jaxpr", "call_jaxpr"):
            if inner in equation.params:
                yield from _primitives(equation.params[inner].jaxpr)


def _traced(function, time):
    return list(_primitives(jax.make_jaxpr(function)(time).jaxpr))


def test_pairs_are_computed_once():
    """Of 2 t both sine and cosine are needed, of 3 t the sine alone.

    The cosine that is written twice has a pair of its own, which XLA merges with the first.
    """
    names = _traced(with_batched_trigonometry(_speed(2.0)), array(0.3))
    assert {"sin", "cos"}.isdisjoint(names)
    assert names.count("custom_jvp_call") == 3
    plain = _traced(_speed(2.0), array(0.3))
    assert (plain.count("sin"), plain.count("cos")) == (2, 2)


def test_nothing_to_replace():
    """Single precision and functions without sines stay as they are; numbers are not traced."""
    single = with_batched_trigonometry(_speed(jnp.float32(2.0)))
    assert "sin" in _traced(single, jnp.float32(0.3))
    assert _traced(with_batched_trigonometry(jnp.tan), array(0.3)) == ["tan"]
    assert float(with_batched_trigonometry(_speed(2.0))(0.3)) == float(_speed(2.0)(0.3))
    # A constant function, and one whose numbers alone are traced.
    assert float(jax.jit(with_batched_trigonometry(lambda time: 3.0))(0.3)) == 3.0
    slope = jax.grad(lambda amplitude: with_batched_trigonometry(_speed(amplitude))(0.3))
    np.testing.assert_allclose(slope(2.0), _speed(1.0)(0.3), rtol=1e-15)


def test_drives_and_loads_of_a_scene_have_them():
    profile = SineProfile(amplitude=100.0, frequency=5.0)
    scene = Scenario(profile, lambda time: 1e3 * jnp.cos(time), 1.0)

    def drive(time):
        return (*scene.motion_at(time), scene.load_at(time))

    assert {"sin", "cos"}.isdisjoint(_traced(drive, array(0.3)))
    speed, acceleration, load = jax.jit(drive)(array(0.3))
    turned = 2 * np.pi * 5.0 * 0.3
    expected = (100 * np.sin(turned), 1e3 * np.pi * np.cos(turned), 1e3 * np.cos(0.3))
    # Roundings of the angle, of 9 rad.
    np.testing.assert_allclose((speed, acceleration, load), expected, rtol=1e-14, atol=1e-12)
