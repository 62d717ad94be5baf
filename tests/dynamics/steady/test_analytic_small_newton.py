"""Newton's method on a few unknowns: roots of any size, their derivatives, and an honest end."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array

from prsm_jax.dynamics.steady._root_search import find_roots, find_roots_and

ROOT = np.sqrt([2.0, 3.0])


def _crossing(size, guess=(1.0, 1.2), **more):
    """x² + y = 2 + √3, y² + x = 3 + √2 in units of s: the root is s (√2, √3)."""

    def residuals(unknowns):
        x, y = unknowns[0] / size, unknowns[1] / size
        return jnp.stack([x**2 + y - 2 - 3**0.5, y**2 + x - 3 - 2**0.5])

    return find_roots(residuals, jnp.asarray(guess) * size, **more)


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e8, 3.3e8, 7e9, 1.9e11])
def test_roots_of_any_size_are_found(size):
    """The tolerance is relative to large unknowns: absolutely these never stand still."""
    roots, found = _crossing(array(size), tolerance=1e-10, max_steps=20)
    assert bool(found)
    # At 1e-9 the tolerance is absolute: it ends a step after the start.
    np.testing.assert_allclose(roots, ROOT * size, rtol=1e-13 if size >= 1 else 0.1)


def test_derivatives_are_those_of_the_root():
    """d(s √2, s √3)/ds, forward and reverse, whatever the number of steps."""

    def root(size):
        return _crossing(size, tolerance=1e-10, max_steps=20)[0]

    for transform in (jax.jacfwd, jax.jacrev):
        np.testing.assert_allclose(transform(root)(array(1.7)), ROOT, rtol=1e-12)


def test_what_is_known_at_the_roots_has_derivatives_to_second_order():
    """x = s √2 and y = s √3 by x² = 2 s², y² = 3 s²: s x y = √6 s³, in either mode."""

    def product(size):
        def residuals(unknowns):
            x, y = unknowns[0] / size, unknowns[1] / size
            known = {"product": size * unknowns[0] * unknowns[1], "large": unknowns[0] > 1}
            return jnp.stack([x**2 - 2, y**2 - 3]), known

        _, _, known = find_roots_and(
            residuals, jnp.asarray([1.5, 2.0]) * size, tolerance=1e-10, max_steps=20
        )
        assert known["large"].dtype == bool
        return known["product"]

    forward, reverse = jax.jacfwd, jax.jacrev
    size, third = array(1.7), 6**0.5
    np.testing.assert_allclose(product(size), third * 1.7**3, rtol=1e-13)
    for first in (forward, reverse):
        np.testing.assert_allclose(first(product)(size), 3 * third * 1.7**2, rtol=1e-12)
        for second in (forward, reverse):
            found = second(first(product))(size)
            np.testing.assert_allclose(found, 6 * third * 1.7, rtol=1e-12)


def test_what_is_not_found_is_said_so():
    """Too few steps, and an equation without a root."""
    assert not bool(_crossing(array(1.0), tolerance=1e-10, max_steps=2)[1])
    assert bool(_crossing(array(1.0), tolerance=1e-10, max_steps=8)[1])
    nothing = find_roots(lambda x: x**2 + 1.0, jnp.asarray([0.3]), tolerance=1e-10, max_steps=30)
    assert not bool(nothing[1])
