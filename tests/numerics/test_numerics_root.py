"""Roots of one number and their derivatives, to third order, against a closed form."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from prsm_jax.numerics import find_root, find_root_of

_A, _B, _C = 1.3, 0.7, np.array([0.4, 1.1, 0.9])
_POWERS = np.arange(3.0)


def _exact(a, b, c):
    """Positive root of a x² + b x = Σ k c."""
    constant = jnp.sum(jnp.asarray(_POWERS) * c)
    return (jnp.sqrt(b**2 + 4 * a * constant) - b) / (2 * a)


def _residual(arguments, x):
    a, b, c = arguments
    return a * x**2 + b * x - jnp.sum(jnp.asarray(_POWERS) * c), 2 * a * x + b


def _found(a, b, c):
    root, converged = find_root_of(
        _residual, (a, b, c), jnp.ones(()), tolerance=1e-13, max_steps=20
    )
    return jnp.where(converged, root, jnp.nan)


def _found_in_a_closure(a, b, c):
    root, converged = find_root(
        lambda x: _residual((a, b, c), x)[0], jnp.ones(()), tolerance=1e-13, max_steps=20
    )
    return jnp.where(converged, root, jnp.nan)


@pytest.mark.parametrize("found", [_found, _found_in_a_closure])
@pytest.mark.parametrize("modes", [(), (jax.jacfwd,), (jax.jacrev,), (jax.jacfwd, jax.jacrev)])
@pytest.mark.parametrize("more", [(), (jax.jacfwd,)])
def test_derivatives_by_all_arguments(found, modes, more):
    """Three numbers at once, one of them an array; of any order and mode."""
    exact = _exact
    for mode in (*modes, *more):
        found, exact = (mode(function, argnums=(0, 1, 2)) for function in (found, exact))
    arguments = jnp.asarray(_A), jnp.asarray(_B), jnp.asarray(_C)
    values, expected = (
        jax.tree.leaves(jax.jit(function)(*arguments)) for function in (found, exact)
    )
    for value, one in zip(values, expected, strict=True):
        # The root is exact to 1e-13; each order multiplies by a few units.
        np.testing.assert_allclose(value, one, rtol=1e-11, atol=1e-12)


def test_one_of_three_arguments_varies():
    """The others are constants, without derivatives."""
    derivative = jax.jacfwd(lambda a: _found(a, jnp.asarray(_B), jnp.asarray(_C)))
    assert float(derivative(jnp.asarray(_A))) == pytest.approx(
        float(jax.grad(_exact)(_A, _B, _C)), rel=1e-12
    )
