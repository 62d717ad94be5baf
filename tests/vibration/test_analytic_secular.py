"""Roots of the secular equation: the closed form they start from, each step, and when they stop."""

import itertools
import math

import jax
import numpy as np
import pytest
from scenes import array

from prsm_jax.vibration.arrowhead._poles import sorted_poles
from prsm_jax.vibration.arrowhead._quartic import quartic_roots
from prsm_jax.vibration.arrowhead._secular import Roots, _begin, _settled, _step

_quartic = jax.jit(quartic_roots)
_started = jax.jit(_begin)
_stepped = jax.jit(_step)
_has_settled = jax.jit(_settled)

#: Stiffnesses on the supports and on the meshes, masses of three bodies and the roller.
SPRINGS = {
    "apart": ([2e8, 5e8, 1.1e9], [1e8, 2.5e8, 1.5e8], [1.0, 0.8, 0.9, 0.2]),
    "light roller": ([5e7, 3e8, 9e7], [4e8, 1e8, 3e8], [1.0, 2.0, 0.3, 0.01]),
    "heavy roller": ([3e8, 6e8, 2e8], [1e8, 1e8, 2e8], [1.0, 0.7, 2.0, 20.0]),
    "poles close together": ([3.0e8, 3.002e8, 3.005e8], [1e7, 1e7, 1e7], [1.0, 1.0, 1.0, 1.0]),
}


def _poles(name):
    support, mesh, mass = ([array(v) for v in values] for values in SPRINGS[name])
    return sorted_poles(support, mesh, mass, array(math.sqrt(5.0)))


def _exact(poles):
    """Eigenvalues of the arrowhead matrix that the equation belongs to, and where they lie."""
    d = np.asarray(poles.place)
    coupling = np.sqrt(np.asarray(poles.weight))
    matrix = np.diag([*d, np.sum(poles.corner)])
    matrix[3, :3] = matrix[:3, 3] = coupling
    return np.linalg.eigvalsh(matrix)


def _distances(poles, values, shares):
    """Roots that are off by shares of their distance to the nearer end of their interval."""
    d = np.asarray(poles.place)
    ends = ((0.0, d[0]), (d[0], d[1]), (d[1], d[2]), (d[2], np.inf))
    found = []
    for value, (lower, upper), share in zip(values, ends, shares, strict=True):
        near = value - lower if value - lower < upper - value else value - upper
        found.append(array(near * (1 + share)))
    return Roots(*found)


@pytest.mark.parametrize(
    "roots", [(1.0, 2.0, 3.0, 4.0), (1e-8, 0.3, 5.0, 7.0), (0.02, 0.05, 40.0, 90.0), (0, 1, 5, 8)]
)
def test_roots_of_a_quartic_are_found_again(roots):
    """Its coefficients are the sums of products of one, two, three and four of its roots.

    A third of an angle is taken by a polynomial to 5e-10.
    """
    sums = [sum(math.prod(some) for some in itertools.combinations(roots, n)) for n in (1, 2, 3, 4)]
    np.testing.assert_allclose(_quartic(*map(array, sums)), roots, rtol=1e-9, atol=1e-300)


@pytest.mark.parametrize("name", ["apart", "light roller", "heavy roller"])
def test_the_search_starts_at_the_roots_of_the_polynomial(name):
    """To the accuracy of the closed form, where no poles are close together."""
    poles = _poles(name)
    exact = np.asarray(_distances(poles, _exact(poles), np.zeros(4)))
    np.testing.assert_allclose(np.asarray(_started(poles)), exact, rtol=1e-5)


@pytest.mark.parametrize("name", list(SPRINGS))
@pytest.mark.parametrize("sense", [1, -1])
def test_a_step_converges_cubically(name, sense):
    """A hundredth off becomes a millionth, a thousandth a thousandth of that: each of the roots."""
    poles = _poles(name)
    values = _exact(poles)
    exact = np.asarray(_distances(poles, values, np.zeros(4)))
    errors = []
    for share in (1e-2, 1e-3):
        after = _stepped(poles, _distances(poles, values, np.full(4, sense * share)))
        errors.append(np.abs(np.asarray(after) / exact - 1))
    # The eigenvalues of the matrix are exact to rounding of the largest one.
    rounding = 1e-15 * values[-1] / np.abs(exact)
    assert np.all(errors[0] < 2e-6 + rounding), errors
    assert np.all(errors[1] < 4e-9 + rounding), errors


@pytest.mark.parametrize("name", ["apart", "light roller", "poles close together"])
def test_roots_have_settled_where_another_step_changes_nothing(name):
    """Convergence is cubic: moved by a millionth the next step is below rounding, by 1e-4 not."""
    poles = _poles(name)
    values = _exact(poles)
    rest = _distances(poles, values, np.zeros(4))
    assert bool(_has_settled(poles, _distances(poles, values, np.full(4, 1e-6)), rest))
    for moved in np.eye(4):
        assert not bool(_has_settled(poles, _distances(poles, values, 3e-4 * moved), rest)), moved
