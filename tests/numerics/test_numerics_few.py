"""Sums, products and extremes of a few numbers: those of NumPy, and no reduction in a step."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies
from hypothesis.extra.numpy import array_shapes, arrays
from jax.extend.core import jaxprs_in_params

import prsm_jax as prsm
from prsm_jax.numerics import (
    all_few,
    any_few,
    dot_few,
    length_few,
    max_few,
    min_few,
    sum_few,
)

_NUMBERS = strategies.floats(-1e6, 1e6) | strategies.just(float("nan"))
_ARRAYS = arrays(float, array_shapes(min_dims=1, max_dims=3, max_side=4), elements=_NUMBERS)


@given(_ARRAYS, strategies.data())
def test_they_are_those_of_numpy(values, data):
    axis = data.draw(strategies.integers(-values.ndim, values.ndim - 1))
    given = jnp.asarray(values)
    pairs = [(sum_few, np.sum), (max_few, np.max), (min_few, np.min)]
    for ours, theirs in pairs:
        # NumPy may add in another order.
        np.testing.assert_allclose(ours(given, axis), theirs(values, axis), rtol=1e-14, atol=1e-9)
    truth = values > 0
    given = jnp.asarray(truth)
    np.testing.assert_array_equal(any_few(given, axis), truth.any(axis))
    np.testing.assert_array_equal(all_few(given, axis), truth.all(axis))


def test_a_scalar_product_and_a_matrix_times_a_vector():
    matrix, vector = jnp.arange(6.0).reshape(2, 3), jnp.array([2.0, -3.0, 5.0])
    np.testing.assert_array_equal(dot_few(vector, vector), 38.0)
    np.testing.assert_array_equal(dot_few(matrix, vector), [7.0, 19.0])


def test_the_length_of_a_vector_that_is_zero_or_no_number():
    vectors = jnp.array([[3.0, -4.0], [0.0, 0.0], [jnp.nan, 0.0]])
    np.testing.assert_array_equal(length_few(vectors), [5.0, 0.0, np.nan])
    slopes = jax.vmap(jax.grad(length_few))(vectors)
    np.testing.assert_allclose(slopes[:2], [[0.6, -0.8], [0.0, 0.0]], rtol=1e-15)
    assert np.isnan(slopes[2]).any()


def _inside_loops(jaxpr, inside=False):
    """Names of the operations of a program that are within its loops."""
    for equation in jaxpr.eqns:
        if inside:
            yield equation.primitive.name
        loop = inside or equation.primitive.name in ("while", "scan")
        for inner in jaxprs_in_params(equation.params):
            yield from _inside_loops(inner, loop)


@pytest.mark.parametrize("speed", [200.0, lambda time: 200.0 * jnp.sin(31.0 * time)])
def test_no_step_of_a_transient_has_a_reduction(speed):
    """XLA gives reductions to kernels for long rows: 40 % of the time of steps in a batch."""
    mechanism = prsm.load("li2020_two_stage")

    def states(load):
        scenario = prsm.Scenario(speed, load, 1e-3, samples=5)
        run = prsm.simulate(mechanism, scenario, method="rosenbrock", gradient="forward")
        return run.carrier_speed

    found = set(_inside_loops(jax.make_jaxpr(jax.vmap(states))(jnp.linspace(5e3, 7e3, 3)).jaxpr))
    # The root of the slip speed: the equation of motion is among them.
    assert "rsqrt" in found
    assert not found & {"dot_general", "reduce_sum", "reduce_max", "reduce_min", "argmax"}
