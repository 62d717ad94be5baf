"""Roots of one number and their derivatives, to third order, against a closed form."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from prsm_jax.numerics import find_root, find_root_by_secants, find_root_of

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


def _found_by_secants(a, b, c):
    root, converged, _ = find_root_by_secants(
        lambda x: (_residual((a, b, c), x)[0], jnp.asarray(True)),
        jnp.ones(()),
        lambda value: 1 - value / 4,
        tolerance=1e-9,
        max_steps=30,
    )
    return jnp.where(converged, root, jnp.nan)


@pytest.mark.parametrize("found", [_found, _found_in_a_closure, _found_by_secants])
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


@jax.jit
def _by_secants(constant, start):
    """Root of exp x − c, valid above −1; the second point lies where a straight line has it."""
    return find_root_by_secants(
        lambda x: (jnp.exp(x) - constant, x > -1),
        start,
        lambda value: start - value / jnp.exp(start),
        tolerance=1e-9,
        max_steps=40,
    )


@pytest.mark.parametrize("constant", [0.5, 1.0, 1 + 1e-15, 1 + 1e-9, 3.0])
def test_secants_from_anywhere_and_from_the_root_itself(constant):
    """At the root, and so near it that both first points would be one."""
    root, found, first = _by_secants(jnp.asarray(constant), jnp.zeros(()))
    assert bool(found)
    assert float(root) == pytest.approx(np.log(constant), rel=1e-12, abs=1e-15)
    assert float(first.value) == 1 - constant
    assert bool(first.valid)


def test_secants_say_where_the_function_is_not_valid():
    """At the start only, at the root, or nowhere a number."""
    root, found, first = _by_secants(jnp.asarray(2.0), jnp.asarray(-1.5))
    assert float(root) == pytest.approx(np.log(2.0), rel=1e-12)
    assert bool(found)
    assert not bool(first.valid)
    root, found, first = _by_secants(jnp.asarray(0.2), jnp.zeros(()))
    assert float(root) == pytest.approx(np.log(0.2), rel=1e-12)
    assert not bool(found)
    assert bool(first.valid)
    for constant in (np.nan, np.inf, -1.0):
        assert not bool(_by_secants(jnp.asarray(constant), jnp.zeros(()))[1])


def test_a_search_by_secants_does_not_derive_the_function():
    """One evaluation in the program; Newton's method has its derivative besides."""

    def slow(x):
        return jnp.sinh(x) - 1

    def by_secants(start):
        return find_root_by_secants(
            lambda x: (slow(x), jnp.asarray(True)),
            start,
            lambda value: start - value,
            tolerance=1e-9,
            max_steps=40,
        )[0]

    def by_newton(start):
        return find_root(slow, start, tolerance=1e-12, max_steps=40)[0]

    programs = [str(jax.make_jaxpr(one)(jnp.ones(()))) for one in (by_secants, by_newton)]
    assert [p.count("cosh") for p in programs] == [0, 1]
    assert programs[0].count("sinh") == 1
    assert float(by_secants(jnp.ones(()))) == pytest.approx(np.arcsinh(1.0), rel=1e-13)
