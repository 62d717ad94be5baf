"""The assembler on a structure that is not ours: the planetary gear of Lin and Parker.

J. Lin, R. G. Parker, "Analytical characterization of the unique properties of planetary gear free
vibration", Journal of Vibration and Acoustics 121 (1999) 316–321: sun, ring, carrier and 3, 4 or 5
planets with three degrees of freedom each, on the carrier at rest.
"""

import equinox as eqx
import numpy as np
import pytest

from prsm_jax.modal import dense_modes, symmetric_modes
from prsm_jax.validation._lin_parker1999 import (
    PLANET,
    ROTATIONAL,
    TRANSLATIONAL,
    planetary_gear,
)

_symmetric = eqx.filter_jit(lambda system: symmetric_modes(system, shapes=True))
_dense = eqx.filter_jit(dense_modes)


@pytest.mark.parametrize("planets", [3, 4, 5])
def test_published_frequencies(planets):
    """To the printed digit, family by family, with the multiplicities that the paper proves."""
    modes = _symmetric(planetary_gear(planets))
    published = {"torsional": ROTATIONAL[planets], "transverse": TRANSLATIONAL[planets]}
    multiplicity = {"torsional": 1, "transverse": 2, "roller": planets - 3}
    if planets > 3:
        published["roller"] = PLANET
    assert {group.family for group in modes.groups} == set(published)
    compared = 0
    for group in modes.groups:
        assert group.multiplicity == multiplicity[group.family]
        assert group.frequencies.shape == (len(published[group.family]),)
        for found, printed in zip(group.frequencies, published[group.family], strict=True):
            if printed is not None:
                # Half a unit of the printed digit; the zero is a rigid rotation.
                assert abs(float(found) - float(printed)) <= 0.0501
                compared += 1
    assert compared == {3: 12, 4: 12, 5: 12}[planets]
    assert modes.families[0] == "rigid"


@pytest.mark.parametrize("planets", [3, 5])
def test_by_symmetry_and_without(planets):
    """The Hermitian blocks of the symmetry against all 9 + 3 N degrees of freedom at once."""
    system = planetary_gear(planets)
    reduced, dense = _symmetric(system), _dense(system)
    assert reduced.frequencies.shape == (9 + 3 * planets,)
    np.testing.assert_allclose(dense.frequencies[1:], reduced.frequencies[1:], rtol=1e-12)
    assert dense.families == reduced.families
    network = reduced.network
    shapes = np.asarray(reduced.shapes)
    # Mass-normalised, orthogonal, and eigenvectors: both to rounding of numbers of order one.
    gram = shapes.T @ (np.asarray(network.mass)[:, None] * shapes)
    np.testing.assert_allclose(gram, np.eye(len(gram)), atol=1e-13)
    squares = (2 * np.pi * np.asarray(reduced.frequencies)) ** 2
    stiffness = shapes.T @ np.asarray(network.stiffness_matrix()) @ shapes
    np.testing.assert_allclose(stiffness, np.diag(squares), atol=1e-13 * squares[-1])
