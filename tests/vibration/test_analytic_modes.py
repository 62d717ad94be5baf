"""Shapes, energies and the dense path: rollers that differ, that are missing, that translate."""

import dataclasses

import equinox as eqx
import jax
import numpy as np
import pytest
from scenes import array, example

import prsm_jax as prsm
from prsm_jax.mechanism import UnequalRoller
from prsm_jax.vibration import (
    RollerScatter,
    RollerTranslation,
    dense_modes,
    symmetric_modes,
)
from tests.present import present

_both = eqx.filter_jit(
    lambda system: (symmetric_modes(system, shapes=True), dense_modes(system)),
)
_frequencies = eqx.filter_jit(
    lambda system: (symmetric_modes(system).frequencies, dense_modes(system).frequencies)
)
_dense = eqx.filter_jit(dense_modes)
_shapes = eqx.filter_jit(lambda mechanism: prsm.modal(mechanism, shapes=True))


def _wu(count=7):
    mechanism = prsm.set_parameter(example("wu2022"), "roller_count", count)
    return prsm.modal(mechanism, shapes=True).system


def _scaled(system, generator, decades):
    return jax.tree.map(lambda leaf: leaf * 10 ** generator.uniform(-decades, decades), system)


@pytest.mark.parametrize("count", [3, 4, 5, 7, 8, 30])
def test_both_paths_agree(count):
    """Random designs, every number spread over four decades: 1e-12, relative, of every frequency.

    Both sum over springs, so soft modes keep their digits: 2e-15 was measured.
    """
    generator, system = np.random.default_rng(count), _wu(count)
    for _ in range(5):
        reduced, dense = _frequencies(_scaled(system, generator, 2.0))
        np.testing.assert_allclose(dense, reduced, rtol=1e-12)


def test_both_paths_agree_on_shapes_families_and_energies():
    """Energies of whole clusters do not depend on the choice of shapes within them."""
    generator = np.random.default_rng(1)
    for _ in range(3):
        reduced, dense = _both(_scaled(_wu(), generator, 0.5))
        assert dense.families == reduced.families
        network = reduced.network
        for modes in (reduced, dense):
            shapes = np.asarray(modes.shapes)
            # φᵀ M φ = 1 and φᵀ K φ = ω², to rounding of 17 terms.
            gram = shapes.T @ (np.asarray(network.mass)[:, None] * shapes)
            np.testing.assert_allclose(gram, np.eye(17), atol=1e-13)
            squares = (2 * np.pi * np.asarray(modes.frequencies)) ** 2
            stiffness = shapes.T @ np.asarray(network.stiffness_matrix()) @ shapes
            np.testing.assert_allclose(stiffness, np.diag(squares), atol=1e-13 * squares[-1])
        for name in ("kinetic_energy_shares", "strain_energy_shares"):
            first, second = getattr(reduced, name)(), getattr(dense, name)()
            assert set(first) == set(second)
            for key, row in first.items():
                np.testing.assert_allclose(row, second[key], atol=1e-10)
            np.testing.assert_allclose(sum(first.values()), 1.0, rtol=1e-13)


@pytest.mark.parametrize("ratio", [1e-6, 1e-12, 1e-15])
def test_both_paths_agree_on_soft_supports(ratio):
    """Supports far softer than the contacts, where an eigensolver on the matrix keeps no digit.

    The singular values of √k G M^{-1/2} lose the square root of that ratio only, and the sum over
    springs squares what is left: 4e-14 was measured at 1e-15.
    """
    system = _wu()
    bodies = tuple(
        dataclasses.replace(
            body,
            radial_support=body.radial_support * ratio,
            torsional_support=body.torsional_support * ratio,
        )
        for body in system.bodies
    )
    reduced, dense = _both(dataclasses.replace(present(system), bodies=bodies))
    np.testing.assert_allclose(dense.frequencies, reduced.frequencies, rtol=1e-12)
    assert dense.families == reduced.families


def _by_numpy(system, stiffness_factor, mass_factor, position):
    """Squares of all frequencies but the carrier's, from a second assembly."""
    count = len(position)
    size = 9 + count
    stiffness, mass = np.zeros((size, size)), np.zeros(size)
    mass[9:] = mass_factor * float(system.roller_equivalent_mass)
    for index, body in enumerate(system.bodies):
        place = slice(3 * index, 3 * index + 3)
        mass[place] = [body.mass, body.mass, body.equivalent_mass]
        other = body.radial_support if body.radial_support_y is None else body.radial_support_y
        stiffness[place, place] = np.diag([body.radial_support, other, body.torsional_support])
        for roller, angle in enumerate(position):
            row = np.zeros(size)
            row[place] = [-np.sin(angle), np.cos(angle), 1]
            row[9 + roller] = body.roller_sign
            factor = stiffness_factor[roller] * float(body.mesh_stiffness)
            stiffness += factor * np.outer(row, row)
    return np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(mass, mass)))


def _compare(mechanism, stiffness_factor, mass_factor, position):
    modes = _shapes(mechanism)
    assert not modes.system.symmetric
    expected = _by_numpy(modes.system, stiffness_factor, mass_factor, position)
    found = np.sort((2 * np.pi * np.asarray(modes.group("coupled").frequencies)) ** 2)
    # LAPACK's are good to 1e-15 of the largest, absolutely.
    assert np.max(np.abs(found - expected)) < 1e-13 * expected[-1]
    return modes


def test_rollers_that_differ():
    even = 2 * np.pi * np.arange(7) / 7
    unequal = (
        UnequalRoller(2, stiffness_factor=0.8),
        UnequalRoller(5, mass_factor=1.3, position_offset=0.02),
    )
    wu = example("wu2022")
    mechanism = eqx.tree_at(lambda m: m.stages[0].unequal_roller, wu, unequal)
    stiffness, mass, position = np.ones(7), np.ones(7), even.copy()
    stiffness[1], mass[4], position[4] = 0.8, 1.3, even[4] + 0.02
    modes = _compare(mechanism, stiffness, mass, position)
    assert modes.multiplicities == (1,) * 17
    # Slightly unequal rollers leave the families what they were.
    assert modes.families.count("roller") == 4
    assert modes.families.count("transverse") == 8


def test_a_missing_roller():
    unequal = (UnequalRoller(3, missing=True),)
    wu = example("wu2022")
    mechanism = eqx.tree_at(lambda m: m.stages[0].unequal_roller, wu, unequal)
    position = np.delete(2 * np.pi * np.arange(7) / 7, 2)
    modes = _compare(mechanism, np.ones(6), np.ones(6), position)
    assert modes.frequencies.shape == (16,)
    assert [str(c) for c in modes.coordinates if c.body.startswith("roller")] == [
        f"roller {number} u" for number in (1, 2, 4, 5, 6, 7)
    ]


def test_supports_that_differ_in_x_and_y():
    wu = example("wu2022")
    mechanism = eqx.tree_at(
        lambda m: m.stages[0].screw.support.radial_stiffness_y,
        wu,
        array(5e6),
        is_leaf=lambda leaf: leaf is None,
    )
    ones = np.ones(7)
    _compare(mechanism, ones, ones, 2 * np.pi * np.arange(7) / 7)


@pytest.mark.parametrize("count", [1, 2])
def test_fewer_than_three_rollers(count):
    mechanism = prsm.set_parameter(example("wu2022"), "roller_count", count)
    ones = np.ones(count)
    _compare(mechanism, ones, ones, 2 * np.pi * np.arange(count) / count)


def test_energies_on_one_body_and_spring():
    """Carrier: its own support and mass only. Roller modes: rollers and contacts only."""
    modes = _shapes(example("wu2022"))
    kinetic, strain = modes.kinetic_energy_shares(), modes.strain_energy_shares()
    carrier = modes.families.index("carrier")
    assert float(kinetic["carrier"][carrier]) == 1.0
    assert float(strain["carrier_support_torsional"][carrier]) == 1.0
    roller = modes.families.index("roller")
    assert float(kinetic["roller"][roller]) == pytest.approx(1.0, abs=1e-15)
    # In a roller mode each contact has its share of the roller's stiffness.
    system = modes.system
    total = sum(float(body.mesh_stiffness) for body in system.bodies)
    for body, name in zip(
        system.bodies, ("screw_roller", "ring_roller", "nut_roller"), strict=True
    ):
        share = float(body.mesh_stiffness) / total
        assert float(strain[name][roller]) == pytest.approx(share, rel=1e-13)
    # Each roller by itself: in a torsional mode all have the same.
    each = modes.kinetic_energy_shares(each_roller=True)
    torsional = modes.families.index("torsional")
    for number in range(1, 8):
        expected = float(kinetic["roller"][torsional]) / 7
        assert float(each[f"roller {number}"][torsional]) == pytest.approx(expected, rel=1e-12)


def test_stiff_pins_bring_back_rollers_that_only_rotate():
    """Pins and a carrier 1e8 times stiffer than the contacts: N + 10 frequencies are left.

    The rest of the difference is the compliance of pins over that of contacts, 1e-7.
    """
    system = _wu()
    held = dataclasses.replace(
        present(system.carrier),
        mass=array(0.023),
        radial_support=array(1e17),
        torsional_support=array(1e17),
    )
    moving = dataclasses.replace(
        present(system),
        carrier=held,
        translation=RollerTranslation(array(0.0326), array(1e17)),
        bodies=tuple(
            dataclasses.replace(body, contact_angle=array(angle))
            for body, angle in zip(system.bodies, (0.7, 0.35, 0.8), strict=True)
        ),
    )
    reduced, dense = _both(moving)
    np.testing.assert_allclose(dense.frequencies, reduced.frequencies, rtol=1e-11)
    expected = _both(dataclasses.replace(present(system), carrier=None))[0].frequencies
    np.testing.assert_allclose(reduced.frequencies[:16], expected, rtol=1e-7)
    assert float(reduced.frequencies[16]) > 100 * float(expected[-1])


def test_roller_translation_from_a_mechanism():
    """Wu's roller bending stiffness as pins: 2 N + 2 more degrees of freedom, softer modes."""
    wu = example("wu2022")
    held = prsm.mechanism.Support(radial_stiffness=2.199e5)
    mechanism = eqx.tree_at(
        lambda m: m.stages[0].roller.support, wu, held, is_leaf=lambda leaf: leaf is None
    )
    modes = _shapes(mechanism)
    assert modes.frequencies.shape == (17 + 2 * 7 + 2,)
    assert modes.group("carrier") is None
    assert modes.group("roller").frequencies.shape == (3,)
    assert float(modes.frequencies[0]) < float(_shapes(wu).frequencies[0])


def test_path_is_decided_by_the_scene():
    """What differs in structure is traced densely, even with the numbers of equal rollers."""
    system = _wu()
    even = RollerScatter(system.roller_positions, numbers=tuple(range(1, 8)))
    scattered = dataclasses.replace(present(system), scatter=even)
    assert system.symmetric
    assert not scattered.symmetric
    with pytest.raises(ValueError, match="dense_modes"):
        symmetric_modes(scattered)
    np.testing.assert_allclose(
        _dense(scattered).frequencies, _dense(present(system)).frequencies, rtol=1e-13
    )
