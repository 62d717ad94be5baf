"""Equal operations are merged when a program is traced; values and derivatives stay the same."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from prsm_jax.numerics import apart, merged, quotient


def _count(function, name: str, *args) -> int:
    """Operations of a kind in the program of a function, those of its calls included."""

    def of(jaxpr) -> int:
        inner = [p for e in jaxpr.eqns for p in e.params.values() if hasattr(p, "jaxpr")]
        own = sum(e.primitive.name == name for e in jaxpr.eqns)
        return own + sum(of(p.jaxpr) for p in inner)

    return of(jax.make_jaxpr(function)(*args).jaxpr)


def _repeating(x):
    once = jnp.where(x > 0, jnp.sin(x), 0.0)
    again = jnp.where(x > 0, jnp.sin(x), 0.0)
    return once * again + jnp.cos(2.0 * x) * jnp.cos(2.0 * x)


def test_equal_operations_are_done_once_also_inside_calls():
    assert _count(_repeating, "sin", 1.0) == 2
    for name in ("sin", "cos", "gt", "select_n"):
        assert _count(merged(_repeating), name, 1.0) == 1
    assert _count(lambda x: jax.jit(_repeating)(x) + _repeating(x), "sin", 1.0) == 4
    assert _count(merged(lambda x: jax.jit(_repeating)(x) + _repeating(x)), "sin", 1.0) == 1


@settings(max_examples=25)
@given(st.floats(-3.0, 3.0))
def test_values_and_derivatives_are_those_of_the_function(x):
    # Not differentiated where the function has a kink.
    x = x if abs(x) > 1e-3 else 1e-3
    for of in (lambda f: f, jax.grad, jax.jacfwd, lambda f: jax.grad(jax.grad(f))):
        np.testing.assert_allclose(of(merged(_repeating))(x), of(_repeating)(x), rtol=1e-14)


def test_operations_that_differ_in_a_number_or_a_parameter_stay():
    def different(x):
        return (
            jnp.sin(x[0]) * jnp.sin(x[1]) + jnp.sin(2.0 * x[0]) * jnp.sin(3.0 * x[0]),
            jax.lax.slice(x, (0,), (2,)) + jax.lax.slice(x, (1,), (3,)),
            jnp.sum(x) + jnp.prod(x),
            x.astype(jnp.float32).astype(float) + x.astype(jnp.int32).astype(float),
        )

    x = jnp.array([0.3, 1.7, 2.9])
    assert _count(merged(different), "sin", x) == 4
    for found, expected in zip(merged(different)(x), different(x), strict=True):
        np.testing.assert_array_equal(found, expected)


def test_close_numbers_stay_apart_and_constant_results_are_arrays():
    def close(x):
        return x * np.array(1.00000000012) - x * np.array(1.00000000034)

    np.testing.assert_allclose(merged(close)(jnp.asarray(1.0)), -2.2e-10, rtol=1e-5)
    signs = merged(lambda x: (x * np.array(0.0), x * np.array(-0.0)))(jnp.asarray(1.0))
    assert [bool(np.signbit(value)) for value in signs] == [False, True]
    found = merged(lambda x: (jnp.asarray(0.5), jnp.zeros(()), x))(jnp.asarray(1.0))
    assert all(isinstance(value, jax.Array) for value in found)
    assert [float(value) for value in found] == [0.5, 0.0, 1.0]


def test_functions_with_their_own_derivatives_are_merged_where_they_are_the_same():
    def two(x):
        return quotient(jnp.sin(x), x) + quotient(jnp.sin(x), x) + quotient(x, jnp.sin(x))

    x = jnp.asarray(1.3)
    names = [e.primitive.name for e in jax.make_jaxpr(merged(two))(x).jaxpr.eqns]
    assert sum(name in ("jit", "pjit", "custom_jvp_call") for name in names) == 2
    for of in (lambda f: f, jax.grad, lambda f: jax.grad(jax.grad(f))):
        np.testing.assert_allclose(of(merged(two))(x), of(two)(x), rtol=1e-14)


def test_parts_that_are_compiled_separately_stay_so():
    @jax.jit
    def found(x):
        return merged(lambda x: apart(jnp.sin)(x) * 2.0 + apart(jnp.sin)(x))(x)

    text = found.lower(1.0).compile().as_text()
    assert text is not None
    assert 'inlineable="false"' in text
    np.testing.assert_allclose(found(1.0), 3 * np.sin(1.0), rtol=1e-15)


def test_what_has_an_effect_is_repeated():
    seen = []

    @jax.jit
    def hear(x):
        jax.debug.callback(lambda value: seen.append(float(value)), x)

    def heard(x):
        hear(x)
        hear(x)
        return x + x

    jax.block_until_ready(jax.jit(merged(heard))(2.0))
    jax.effects_barrier()
    assert seen == [2.0, 2.0]


@pytest.mark.parametrize("value", [0.0, -1.0, 1e300, np.inf, np.nan])
def test_in_a_batch_and_at_the_limits(value):
    x = jnp.array([value, 1.0])
    np.testing.assert_array_equal(jax.vmap(merged(_repeating))(x), jax.vmap(_repeating)(x))


def test_other_objects_among_arguments_and_results():
    def named(x, name, scale=2.0):
        return {"value": x * scale, "name": name.upper(), "none": None}

    found = merged(named)(jnp.asarray(1.5), "carrier", scale=4.0)
    assert found["name"] == "CARRIER"
    assert found["none"] is None
    assert float(found["value"]) == 6.0
