"""Vibration: cyclic symmetry against the full problem, assembled here a second time."""

import equinox as eqx
import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st
from scenes import array, example, modal

import prsm_jax as prsm
from prsm_jax.vibration import (
    CarrierBody,
    CentralBody,
    SpringBlock,
    VibrationSystem,
    block_modes,
    dense_matrices,
    dense_modes,
    symmetric_modes,
)

_modes = eqx.filter_jit(symmetric_modes)
_many_modes = eqx.filter_jit(eqx.filter_vmap(symmetric_modes))
_dense = eqx.filter_jit(dense_matrices)
_dense_modes = eqx.filter_jit(dense_modes)

SIGNS = {"screw": 1, "ring_gear": -1, "nut": -1}


def _system(count, draw, names=("screw", "ring_gear", "nut"), carrier=True, supported=True):
    """A system with numbers from `draw(low, high)`, decades of them."""
    held = 1.0 if supported else 0.0
    bodies = tuple(
        CentralBody(
            mass=array(draw(1e-2, 1e1)),
            equivalent_mass=array(draw(1e-2, 1e1)),
            mesh_stiffness=array(draw(1e7, 1e9)),
            radial_support=array(held * draw(1e4, 1e9)),
            torsional_support=array(held * draw(1e4, 1e9)),
            roller_sign=SIGNS[name],
            name=name,
        )
        for name in names
    )
    body = CarrierBody(array(draw(1e-1, 1e0)), array(held * draw(1e5, 1e7)))
    return VibrationSystem(bodies, array(draw(1e-2, 1e-1)), body if carrier else None, count)


def _random(generator):
    def draw(low, high):
        return float(np.exp(generator.uniform(np.log(low), np.log(high))))

    return draw


def _assembled(system, phases):
    """K and M of all degrees of freedom, spring by spring: Wu et al. 2022, equations 7 to 27."""
    count, bodies = system.roller_count, system.bodies
    first_roller = 3 * len(bodies)
    size = first_roller + count + (system.carrier is not None)
    stiffness, mass = np.zeros((size, size)), np.zeros(size)
    mass[first_roller:] = float(system.roller_equivalent_mass)
    for index, (body, phase) in enumerate(zip(bodies, phases, strict=True)):
        start = 3 * index
        mass[start : start + 3] = [body.mass, body.mass, body.equivalent_mass]
        supports = [body.radial_support, body.radial_support, body.torsional_support]
        stiffness[range(start, start + 3), range(start, start + 3)] = supports
        for roller in range(count):
            position = 2 * np.pi * roller / count
            angle = phase - position if body.name == "screw" else phase + position
            stretch = np.zeros(size)
            stretch[start : start + 3] = [-np.sin(angle), np.cos(angle), 1]
            stretch[first_roller + roller] = 1 if body.name == "screw" else -1
            stiffness += float(body.mesh_stiffness) * np.outer(stretch, stretch)
    if system.carrier is not None:
        mass[-1] = float(system.carrier.equivalent_mass)
        stiffness[-1, -1] = float(system.carrier.torsional_support)
    return stiffness, mass


def _squares(stiffness, mass):
    """ω² ascending, by LAPACK; good to about 1e-15 of the largest."""
    return np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(mass, mass)))


@pytest.mark.parametrize("count", [3, 8, 30])
def test_symmetry_reduction_equals_the_full_problem(count):
    """Random systems; phases drawn too, because the frequencies do not depend on them.

    LAPACK's ω² are good to 1e-15 of the largest one, absolutely; 1e-13 allows for the size.
    """
    generator = np.random.default_rng(count)
    systems = [_system(count, _random(generator)) for _ in range(20)]
    batch = jax.tree.map(lambda *leaves: jnp.stack(leaves), *systems)
    modes = _many_modes(batch)
    for index, system in enumerate(systems):
        found = np.sort(
            np.concatenate(
                [np.repeat(np.asarray(g.frequencies[index]), g.multiplicity) for g in modes.groups]
            )
        )
        assert found.shape == (count + 10,)
        expected = _squares(*_assembled(system, generator.uniform(-np.pi, np.pi, 3)))
        difference = (2 * np.pi * found) ** 2 - expected
        assert np.max(np.abs(difference)) < 1e-13 * expected[-1]


def test_trace_identity():
    """The sum of all ω² is the trace of M⁻¹K: no mode is lost or counted twice."""
    system = _system(7, _random(np.random.default_rng(5)))
    stiffness, mass = _assembled(system, np.zeros(3))
    squares = (2 * np.pi * np.asarray(_modes(system).frequencies)) ** 2
    assert squares.sum() == pytest.approx(np.sum(np.diagonal(stiffness) / mass), rel=1e-13)


def test_assembly_of_the_package():
    """`dense_matrices` against the second assembly, with phases."""
    system = _system(5, _random(np.random.default_rng(1)))
    phases = np.array([0.3, -1.2, 2.5])
    stiffness, mass = _dense(system, jnp.asarray(phases))
    expected_stiffness, expected_mass = _assembled(system, phases)
    # The package measures the screw's x the other way than the paper, so that all bodies share one
    # frame: the contact of roller i is at ψ = φ_i − α.
    turned = np.ones_like(mass)
    turned[0] = -1
    expected_stiffness = expected_stiffness * np.outer(turned, turned)
    largest = np.max(np.abs(expected_stiffness))
    np.testing.assert_allclose(stiffness, expected_stiffness, rtol=0, atol=1e-15 * largest)
    np.testing.assert_allclose(mass, expected_mass, rtol=1e-15)


@given(st.integers(0, 10**6), st.floats(-np.pi, np.pi))
def test_stiffness_is_positive_semidefinite(seed, phase):
    """By construction, supported or not."""
    for supported in (True, False):
        system = _system(5, _random(np.random.default_rng(seed)), supported=supported)
        stiffness, _ = _dense(system, jnp.asarray([phase, 2 * phase, -phase]))
        values = np.linalg.eigvalsh(stiffness)
        assert values[0] > -1e-14 * values[-1]


@pytest.mark.parametrize(
    ("names", "carrier"),
    [
        (("screw", "nut"), True),
        (("screw", "nut"), False),
        (("screw", "ring_gear", "nut"), False),
    ],
)
def test_without_ring_gear_or_carrier(names, carrier):
    """Their degrees of freedom are not there, and the rest is still exact."""
    system = _system(7, _random(np.random.default_rng(3)), names, carrier)
    modes = _modes(system)
    expected = _squares(*_assembled(system, np.zeros(len(names))))
    found = (2 * np.pi * np.asarray(modes.frequencies)) ** 2
    assert found.shape == (3 * len(names) + 7 + carrier,)
    assert np.max(np.abs(found - expected)) < 1e-13 * expected[-1]
    assert (modes.group("carrier") is not None) == carrier
    families = modes.families
    assert families.count("transverse") == 2 * (len(names) + 1)
    assert families.count("torsional") == len(names) + 1
    assert families.count("roller") == 4


def test_rigid_modes():
    """Without supports: all turn together, all shift in x or y, and the carrier is free."""
    modes = _modes(_system(7, _random(np.random.default_rng(4)), supported=False))
    assert modes.families[:4] == ("rigid",) * 4
    assert "rigid" not in modes.families[4:]
    assert np.all(modes.frequencies[:4] < 1e-13 * modes.frequencies[-1])


def test_three_rollers_have_no_roller_modes():
    modes = _modes(_system(3, _random(np.random.default_rng(6))))
    assert modes.group("roller") is None
    assert modes.frequencies.shape == (13,)


def test_roller_modes_in_closed_form():
    """Harmonics ≥ 2: ω² = (k_s + k_r + k_n)/m_eq, N − 3 times."""
    system = _system(7, _random(np.random.default_rng(7)))
    total = sum(float(body.mesh_stiffness) for body in system.bodies)
    expected = np.sqrt(total / float(system.roller_equivalent_mass)) / (2 * np.pi)
    group = _modes(system).group("roller")
    assert group.multiplicity == 4
    np.testing.assert_allclose(group.frequencies, [expected], rtol=1e-15)


def test_mesh_energy_shares():
    """Strain energy of each mode, spring by spring, in the full problem.

    The modes are grouped by family, so a torsional one is found by its frequency.
    """
    system = _system(7, _random(np.random.default_rng(8)))
    stiffness, mass = _assembled(system, np.zeros(3))
    supports = np.zeros_like(mass)
    for index, body in enumerate(system.bodies):
        held = [body.radial_support, body.radial_support, body.torsional_support]
        supports[3 * index : 3 * index + 3] = held
    scale = np.sqrt(mass)
    squares, shapes = np.linalg.eigh(stiffness / np.outer(scale, scale))
    shapes = shapes / scale[:, None]
    modes = _modes(system)
    for family in ("torsional", "transverse"):
        group = modes.group(family)
        for frequency, share in zip(group.frequencies, group.mesh_energy_share, strict=True):
            nearest = np.argmin(np.abs(squares - (2 * np.pi * float(frequency)) ** 2))
            held = supports @ shapes[:, nearest] ** 2
            assert share == pytest.approx(1 - held / squares[nearest], abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_a_rigid_motion_is_no_mesh_mode(seed):
    """Nothing holds the bodies: rigid motions strain nothing, and every other mode only contacts.

    What rounding leaves of a rigid motion's strain is all in the contacts, and is not its share.
    """
    system = _system(5, _random(np.random.default_rng(seed)), supported=False)
    symmetric, dense = _modes(system), _dense_modes(system)
    groups = [symmetric.group("torsional"), symmetric.group("transverse"), dense.group("coupled")]
    for group in groups:
        frequencies = np.asarray(group.frequencies)
        elastic = frequencies > 1e-6 * frequencies.max()
        np.testing.assert_allclose(group.mesh_energy_share, elastic, atol=1e-12)
    # Torsion; transverse in x and in y.
    assert [int(np.sum(np.asarray(g.mesh_energy_share) == 0)) for g in groups] == [1, 1, 3]


@pytest.mark.parametrize("ratio", [1e3, 1e6, 1e12])
def test_torsional_block_with_stiff_and_soft_springs(ratio):
    """Supports `ratio` times softer than the contacts, all in 60 digits.

    A support that is 1e-12 of a contact loses twelve of its digits when both are summed on the
    diagonal of one float64 matrix; sums over springs keep them.
    """
    system = _system(7, _random(np.random.default_rng(11)))
    softened = eqx.tree_at(
        lambda s: [b.torsional_support for b in s.bodies],
        system,
        [b.mesh_stiffness / array(ratio) for b in system.bodies],
    )
    with mpmath.workdps(60):
        block = mpmath.zeros(4)
        masses = [mpmath.mpf(float(b.equivalent_mass)) for b in softened.bodies]
        masses.append(mpmath.mpf(float(softened.roller_equivalent_mass)))
        for index, body in enumerate(softened.bodies):
            spring = mpmath.mpf(float(body.mesh_stiffness))
            block[index, index] = mpmath.mpf(float(body.torsional_support)) + 7 * spring
            block[index, 3] = block[3, index] = body.roller_sign * mpmath.sqrt(7) * spring
            block[3, 3] += spring
        for i in range(4):
            for j in range(4):
                block[i, j] /= mpmath.sqrt(masses[i] * masses[j])
        squares = mpmath.eigsy(block, eigvals_only=True)
        expected = np.sort([float(mpmath.sqrt(v) / (2 * mpmath.pi)) for v in squares])
    found = np.sort(np.asarray(_modes(softened).group("torsional").frequencies))
    np.testing.assert_allclose(found, expected, rtol=1e-13)


def _block(support, mesh, mass, signs=(1, -1, -1), count=7.0):
    return SpringBlock(*(jnp.asarray(v) for v in (support, mesh, mass, count**0.5)), signs)  # pyright: ignore[reportCallIssue]


def _squares_of(block):
    return block_modes(block)[0]


_derivatives = {
    "forward": eqx.filter_jit(jax.jacfwd(_squares_of)),
    "reverse": eqx.filter_jit(jax.jacrev(_squares_of)),
}


@pytest.mark.parametrize("mode", _derivatives)
@pytest.mark.parametrize("ratio", [1.0, 1e6, 1e12])
def test_eigenvalue_derivatives_obey_euler(mode, ratio):
    """λ is homogeneous of degree 1 in all stiffnesses and −1 in all masses, mode by mode.

    Also for supports 1e12 times softer than the contacts: nothing cancels in sums over springs.
    """
    block = _block([1e8 / ratio, 3e8 / ratio, 2e8 / ratio], [2e8, 1e8, 3e8], [1.0, 0.1, 2.0, 0.3])
    values = _squares_of(block)
    slope = _derivatives[mode](block)
    springs = slope.support @ block.support + slope.mesh @ block.mesh
    np.testing.assert_allclose(springs, values, rtol=1e-12)
    np.testing.assert_allclose(slope.mass @ block.mass, -values, rtol=1e-12)
    # Every coefficient is an energy of one spring: none is negative.
    assert np.all(slope.support >= 0)
    assert np.all(slope.mesh >= 0)


@pytest.mark.parametrize("mode", _derivatives)
def test_eigenvalue_derivatives_survive_a_repeated_root(mode):
    """Three equal bodies have two equal roots; the sum of both has its true derivative.

    The two modes span all motions of the bodies that add up to zero, so a support on one body
    holds 2/3 of them.
    """
    block = _block([1e6] * 3, [2e8] * 3, [0.7, 0.7, 0.7, 0.3], signs=(1, 1, 1))
    values = np.asarray(_squares_of(block))
    double = np.isclose(values, (1e6 + 7 * 2e8) / 0.7, rtol=1e-13)
    assert np.count_nonzero(double) == 2
    slope = np.asarray(_derivatives[mode](block).support)
    assert np.all(np.isfinite(slope))
    np.testing.assert_allclose(slope[double].sum(axis=0), [2 / 3 / 0.7] * 3, rtol=1e-12)


def test_scaling_of_a_whole_mechanism():
    """k → 4k everywhere doubles every frequency; masses × 4 halve them."""
    wu = example("wu2022")
    base = modal(wu).frequencies

    def scaled(names):
        moved = wu
        for parameter in prsm.mechanism.all_parameters(wu):
            if parameter.path.rsplit(".", 1)[1] in names:
                moved = parameter.set(moved, 4 * parameter.get(moved))
        return moved

    springs = ("radial_stiffness", "torsional_stiffness", "screw_roller", "nut_roller")
    stiffer, heavier = scaled((*springs, "ring_roller")), scaled(("mass", "inertia"))
    np.testing.assert_allclose(modal(stiffer).frequencies, 2 * base, rtol=1e-13)
    np.testing.assert_allclose(modal(heavier).frequencies, base / 2, rtol=1e-13)


@pytest.mark.usefixtures("unchecked")
def test_errors_name_the_remedy():
    wu = example("wu2022")
    with pytest.raises(ValueError, match="stages 1 to 1"):
        prsm.modal(wu, stage=2)
    with pytest.raises(ValueError, match="shapes=True"):
        _ = prsm.modal(wu).shapes
    without = eqx.tree_at(lambda m: m.stages[0].nut.mass, wu, None)
    with pytest.raises(prsm.MissingDataError, match=r"stage\.nut\.mass"):
        prsm.modal(without)
