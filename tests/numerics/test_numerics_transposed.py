"""Linear functions whose transpose is given: a loop of as many steps as a number says."""

import equinox.internal as eqxi
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from prsm_jax.numerics import with_transpose


def _powered(parameters, inputs):
    """`aⁿ x`, by n products; as its own transpose it is the same loop."""
    factor, count = parameters

    def body(carry):
        number, value = carry
        return number + 1, jnp.where(number < count, factor * value, value)

    steps = eqxi.unvmap_max(count)
    start = jnp.zeros((), int), inputs[0]
    return [jax.lax.while_loop(lambda carry: carry[0] < steps, body, start)[1]]


def _power(factor, count, value):
    return with_transpose(_powered, _powered, [factor, count], [value])[0]


_FACTORS, _COUNTS = jnp.array([2.0, 3.0, 0.5]), jnp.array([2, 3, 5])
_EXACT, _SLOPES = np.array([4.0, 27.0, 1 / 32]), np.array([4.0, 27.0, 5 / 16])


@pytest.mark.parametrize("compiled", [False, True])
def test_reverse_mode_of_a_loop_of_unknown_length(compiled):
    one = jax.grad(_power, 2)
    batch = jax.vmap(one)
    if compiled:
        one, batch = jax.jit(one), jax.jit(batch)
    np.testing.assert_array_equal(one(_FACTORS[1], _COUNTS[1], 1.0), _EXACT[1])
    np.testing.assert_array_equal(batch(_FACTORS, _COUNTS, jnp.ones(3)), _EXACT)


def test_an_input_that_all_of_a_batch_share():
    def total(value):
        return jnp.sum(jax.vmap(_power, (0, 0, None))(_FACTORS, _COUNTS, value))

    np.testing.assert_allclose(jax.grad(total)(1.0), _EXACT.sum(), rtol=1e-15)


def test_forward_mode_by_parameters_and_by_inputs():
    slopes = jax.vmap(jax.jacfwd(_power, (0, 2)))(_FACTORS, _COUNTS, 1.5 * jnp.ones(3))
    np.testing.assert_allclose(slopes[0], 1.5 * _SLOPES, rtol=1e-15)
    np.testing.assert_array_equal(slopes[1], _EXACT)


def test_forward_mode_over_reverse_mode():
    mixed = jax.vmap(jax.jacfwd(jax.grad(_power, 2)))(_FACTORS, _COUNTS, jnp.ones(3))
    np.testing.assert_allclose(mixed, _SLOPES, rtol=1e-15)


def _difference(parameters, inputs):
    return [parameters[0] * inputs[0] - inputs[1], 2.0 * inputs[1]]


def _of_difference(parameters, cotangents):
    return [parameters[0] * cotangents[0], 2.0 * cotangents[1] - cotangents[0]]


def test_inputs_and_results_without_derivatives():
    """A result that is not used, and an input that is constant."""

    def first(x, y):
        return with_transpose(_difference, _of_difference, [jnp.asarray(3.0)], [x, y])[0]

    x, y = jnp.asarray(5.0), jnp.asarray(7.0)
    assert jax.grad(first, (0, 1))(x, y) == (3.0, -1.0)
    assert jax.grad(first)(x, y) == 3.0
    assert jax.jvp(lambda y: first(x, y), (y,), (jnp.asarray(1.0),)) == (8.0, -1.0)


def test_the_transpose_of_the_transpose_is_the_function():
    def both(x, y):
        return with_transpose(_difference, _of_difference, [jnp.asarray(3.0)], [x, y])

    example = jnp.asarray(0.0), jnp.asarray(0.0)
    back = jax.linear_transpose(lambda *x: both(*x), *example)
    again = jax.linear_transpose(lambda *x: list(back(list(x))), *example)
    point = [jnp.asarray(5.0), jnp.asarray(7.0)]
    np.testing.assert_array_equal(again(point), both(*point))
