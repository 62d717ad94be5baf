"""Searches in a box, on functions without a mechanism: steps, directions, a minimum."""

from types import SimpleNamespace

import numpy as np
import pytest

from prsm_jax.optimisation import Adam, Lbfgs

# What stands in for the functions of a search is none.
pytestmark = pytest.mark.usefixtures("unchecked")


def _functions(cost, gradient):
    """What a search evaluates, for a function of the position alone."""
    return SimpleNamespace(cost=cost, gradient=gradient, usable=lambda position: True)


def _plane(*slopes):
    slopes = np.asarray(slopes)
    return _functions(lambda x: float(slopes @ x), lambda x: slopes)


@pytest.mark.parametrize("method", [Adam, Lbfgs])
@pytest.mark.parametrize("maximum", [1, 2, 5])
def test_as_many_steps_as_are_allowed(method, maximum):
    steps = []
    search = method(max_iterations=maximum).search
    found = search(_plane(1e-3, -2e-3), np.array([0.4, 0.5]), 0.0, steps.append)
    assert len(steps) == maximum
    assert found.message == "iteration limit reached"
    assert found.iterations == maximum
    np.testing.assert_array_equal(found.position, steps[-1])


def test_the_first_step_of_lbfgs_goes_down_the_slope_of_the_angle():
    """x = (1 − cos πz)/2 has dx/dz = π/2 sin πz: a coordinate near a bound moves less."""
    start, slopes = np.array([0.2, 0.5, 0.9]), np.array([0.1, -0.3, 0.2])
    steps = []
    Lbfgs(max_iterations=1).search(_plane(*slopes), start, 0.0, steps.append)
    before, after = (np.arccos(1 - 2 * x) / np.pi for x in (start, steps[0]))
    expected = -slopes * np.pi / 2 * np.sin(np.pi * before)
    moved = after - before
    np.testing.assert_allclose(moved / moved[1], expected / expected[1], rtol=1e-9)
    # At most half the box.
    assert 0 < moved[1] <= 0.5


def test_lbfgs_finds_the_minimum_of_a_bowl_in_few_steps():
    """An ellipsoid of axes 1 : 3 inside the box, and one whose middle lies outside."""
    weights = np.array([1.0, 9.0])
    for middle in (np.array([0.3, 0.6]), np.array([0.3, 1.4])):
        bowl = _functions(
            lambda x, m=middle: float(weights @ (x - m) ** 2),
            lambda x, m=middle: 2 * weights * (x - m),
        )
        found = Lbfgs(max_iterations=30).search(
            bowl, np.array([0.8, 0.1]), 1e-6, lambda position: None
        )
        assert found.message == "projected gradient below tolerance"
        np.testing.assert_allclose(found.position, np.minimum(middle, 1.0), atol=1e-6)
        assert found.iterations <= 20
