"""Quotients and inverse roots: exact values, and derivatives with one division."""

import re

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st

from prsm_jax.numerics import inverse_root, merged, quotient

_SIZES = st.floats(-1e3, 1e3).filter(lambda x: abs(x) > 1e-3)


@given(_SIZES, _SIZES)
def test_a_quotient_is_that_of_ieee_and_its_derivatives_are_exact(a, b):
    assert float(quotient(a, b)) == a / b
    exact = {(0,): 1 / b, (1,): -a / b**2, (0, 1): -1 / b**2, (1, 1): 2 * a / b**3, (0, 0): 0.0}
    for order, value in exact.items():
        for mode in (jax.jacfwd, jax.grad):
            of = quotient
            for number in order:
                of = mode(of, argnums=number)
            # Each derivative takes fewer than ten operations.
            np.testing.assert_allclose(of(a, b), value, rtol=3e-15, atol=1e-300)


@given(st.floats(1e-12, 1e12))
def test_an_inverse_root_and_its_derivatives_are_exact(x):
    np.testing.assert_allclose(inverse_root(x), x**-0.5, rtol=4e-16)
    np.testing.assert_allclose(jax.grad(inverse_root)(x), -0.5 * x**-1.5, rtol=3e-15)
    second = jax.jacfwd(jax.grad(inverse_root))(x)
    np.testing.assert_allclose(second, 0.75 * x**-2.5, rtol=3e-15)


@pytest.mark.parametrize(("a", "b"), [(0.0, 1e-300), (1.0, 1e-320), (1.0, 0.0), (0.0, 0.0)])
def test_at_the_limits_a_quotient_is_that_of_the_processor(a, b):
    np.testing.assert_array_equal(quotient(a, b), jnp.asarray(a) / jnp.asarray(b))


def test_derivatives_in_many_directions_divide_once_more_than_the_value():
    def slopes(a, b):
        directions = jnp.eye(3)
        return jax.vmap(
            lambda d: jax.jvp(
                merged(lambda x: quotient(x[0] * x[1], x[2] + x[0])), (jnp.stack([a, b, a]),), (d,)
            )
        )(directions)

    text = jax.jit(slopes).lower(1.0, 2.0).compile().as_text()
    assert text is not None
    # The value, and the inverse of the divisor.
    assert len(re.findall(r" divide\(", text)) <= 2
