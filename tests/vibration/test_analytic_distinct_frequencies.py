"""Distinct natural frequencies: one program for any number of rollers, to the last digits."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from scenes import array

from prsm_jax.sweeps import map_in_chunks
from prsm_jax.vibration import (
    CarrierBody,
    CentralBody,
    VibrationSystem,
    dense_matrices,
    distinct_frequencies,
    symmetric_modes,
)
from tests.present import present

SIGNS = {"screw": 1, "ring_gear": -1, "nut": -1}
#: Every scene has one design for each number of rollers.
COUNTS = (3, 4, 7, 12, 30)
FIELDS = ("mass", "equivalent_mass", "mesh_stiffness", "radial_support", "torsional_support")
_CENTRES = (1.0, 0.5, 2e8, 1e7, 3e6)
#: Roller and carrier come after the bodies.
_LAST = ("equivalent_mass", "equivalent_mass", "torsional_support")
NAMES = [*FIELDS * len(SIGNS), *_LAST]
HEAVY = np.array([name.endswith("mass") for name in NAMES])


def _system(numbers, count=7, names=tuple(SIGNS)):
    """One system from a row of numbers, in the order of its leaves."""
    rows = jnp.asarray(numbers)
    bodies = tuple(
        CentralBody(*rows[5 * at : 5 * at + 5], roller_sign=SIGNS[name], name=name)
        for at, name in enumerate(names)
    )
    return VibrationSystem(bodies, rows[-3], CarrierBody(rows[-2], rows[-1]), count)


def _random(seed, designs=5, spread=1.0, bodies=3):
    """Numbers of random designs, over ± `spread` decades."""
    random = np.random.default_rng(seed)
    centres = np.array([*_CENTRES * bodies, 0.1, 0.5, 1e6])
    return centres * 10 ** random.uniform(-spread, spread, (designs, len(centres)))


def _column(field, body):
    return 5 * body + FIELDS.index(field)


def _listed(numbers, count):
    """The distinct frequencies one after the other: carrier, torsional, transverse, roller."""
    found = distinct_frequencies(_system(numbers), roller_count=count)
    ends = [jnp.atleast_1d(present(found.carrier)), jnp.atleast_1d(found.roller)]
    return jnp.concatenate([ends[0], found.torsional, found.transverse, ends[1]])


_many = jax.jit(jax.vmap(_listed))
_COUNTS = jnp.asarray(COUNTS, jnp.float64)


@functools.cache
def _found(scene):
    """Frequencies of a scene's designs: one compiled program for all numbers of rollers."""
    return np.asarray(_many(jnp.asarray(SCENES[scene]()), _COUNTS))


def test_a_traced_number_of_rollers_gives_the_modes_of_every_number():
    numbers, found = SCENES["over two decades"](), _found("over two decades")
    for index, count in enumerate(COUNTS):
        modes = {
            group.family: group.frequencies
            for group in symmetric_modes(_system(numbers[index], count)).groups
        }
        parts = [modes.get(family) for family in ("carrier", "torsional", "transverse", "roller")]
        expected = np.concatenate([part for part in parts if part is not None])
        # Both paths share the solver; what may differ is the order of roundings.
        np.testing.assert_allclose(found[index, : len(expected)], expected, rtol=1e-14)


def _dense(system):
    """All frequencies of the full matrix, ascending [Hz]."""
    stiffness, mass = dense_matrices(system)
    weight = 1 / np.sqrt(mass)
    squares = np.linalg.eigvalsh(np.asarray(stiffness) * np.outer(weight, weight))
    return np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)


def test_distinct_frequencies_are_those_of_the_dense_problem():
    numbers, found = SCENES["over two decades"](), _found("over two decades")
    for index, count in enumerate(COUNTS):
        carrier, *both, roller = found[index]
        torsional, transverse = both[:4], both[4:]
        repeated = [carrier, *torsional, *np.repeat(transverse, 2), *[roller] * (count - 3)]
        expected = _dense(_system(numbers[index], count))
        # The dense solver loses digits of ω² below the largest one, in proportion.
        tolerance = 1e-14 * (expected[-1] / expected) ** 2 + 1e-13
        assert np.all(np.abs(np.sort(repeated) / expected - 1) < tolerance)


@pytest.mark.parametrize("names", [("screw", "nut"), ("screw",)])
def test_fewer_bodies_have_fewer_frequencies(names):
    system = _system(_random(3, 1, bodies=len(names))[0], 5, names)
    found = distinct_frequencies(system)
    assert found.torsional.shape == found.transverse.shape == (len(names) + 1,)
    ends = [*[float(found.roller)] * 2, float(present(found.carrier))]
    mine = np.sort(np.concatenate([found.torsional, np.repeat(found.transverse, 2), ends]))
    np.testing.assert_allclose(mine, _dense(system), rtol=1e-11)


def _exact_torsional(numbers, count):
    """mpmath at 60 digits, ascending [Hz]."""
    system = _system(numbers, count)
    with mpmath.workdps(60):
        size = len(system.bodies)
        block = mpmath.zeros(size + 1)
        masses = [mpmath.mpf(float(body.equivalent_mass)) for body in system.bodies]
        masses.append(mpmath.mpf(float(system.roller_equivalent_mass)))
        for j, body in enumerate(system.bodies):
            spring = mpmath.mpf(float(body.mesh_stiffness))
            block[j, j] = mpmath.mpf(float(body.torsional_support)) + count * spring
            block[j, size] = block[size, j] = mpmath.sqrt(count) * spring
            block[size, size] += spring
        for i in range(size + 1):
            for j in range(size + 1):
                block[i, j] /= mpmath.sqrt(masses[i] * masses[j])
        squares = sorted(mpmath.eigsy(block, eigvals_only=True))
        return np.array([float(mpmath.sqrt(abs(v)) / (2 * mpmath.pi)) for v in squares])


def _alike(gap):
    """Designs whose three bodies differ by about `gap`: three poles close together."""
    numbers, random = _random(8), np.random.default_rng(9)
    for body in range(3):
        own = slice(5 * body, 5 * body + 5)
        numbers[:, own] = numbers[:, :5] * (1 + gap * random.uniform(-1, 1, (len(COUNTS), 5)))
    return numbers


def _softened(share):
    """Torsional supports a share of the contacts."""
    numbers = _random(11)
    for body in range(3):
        soft = numbers[:, _column("mesh_stiffness", body)] * share
        numbers[:, _column("torsional_support", body)] = soft
    return numbers


ALL = "over two decades"
SCENES = {
    ALL: lambda: _random(1),
    "over twelve decades": lambda: _random(5, spread=6.0),
    "soft supports": lambda: _softened(1e-12),
    "three equal bodies": lambda: _alike(0.0),
    "bodies alike to 1e-12": lambda: _alike(1e-12),
    "bodies alike to 1e-6": lambda: _alike(1e-6),
}


@pytest.mark.parametrize("scene", SCENES)
def test_every_frequency_is_right_to_its_own_last_digits(scene):
    numbers, found = SCENES[scene](), _found(scene)
    for index, count in enumerate(COUNTS):
        expected = _exact_torsional(numbers[index], count)
        # Rounding of √N, of sums and of the last step: some 1e-16 each.
        np.testing.assert_allclose(found[index, 1:5], expected, rtol=2e-15)


@pytest.mark.parametrize(
    ("rigid", "stiffness"),
    [
        (1, {"torsional_support": (0, 1, 2)}),
        (0, {"mesh_stiffness": (1,)}),
        (1, {"mesh_stiffness": (1,), "torsional_support": (1,)}),
        (2, {"mesh_stiffness": (1, 2), "torsional_support": (1, 2)}),
        (1, {"mesh_stiffness": (0, 1, 2)}),
    ],
)
def test_springs_that_are_not_there(rigid, stiffness):
    """Rigid motions have exactly zero frequency and zero derivatives; the rest is right."""
    numbers = _random(13)
    for field, bodies in stiffness.items():
        for body in bodies:
            numbers[:, _column(field, body)] = 0.0
    found = np.asarray(_many(jnp.asarray(numbers), _COUNTS))[:, 1:5]
    assert np.all(found[:, :rigid] == 0)
    expected = np.stack([_exact_torsional(numbers[i], c) for i, c in enumerate(COUNTS)])
    np.testing.assert_allclose(found[:, rigid:], expected[:, rigid:], rtol=2e-15)
    for slopes in _slopes.values():
        slope = np.asarray(slopes(jnp.asarray(numbers), _COUNTS))
        assert np.all(np.isfinite(slope))
        assert np.all(slope[:, 1 : 1 + rigid] == 0)


def _elasticities(direction):
    """∂f/∂log p and ∂f/∂N of every design, in one compiled program."""

    def one(numbers, count):
        by_number, by_count = direction(_listed, (0, 1))(numbers, count)
        return jnp.concatenate([by_number * numbers[None, :], by_count[:, None]], axis=1)

    return jax.jit(jax.vmap(one))


_slopes = {"forward": _elasticities(jax.jacfwd), "reverse": _elasticities(jax.jacrev)}
_values = jax.jit(jax.vmap(jax.vmap(_listed)))


@functools.cache
def _differences(scene):
    """Richardson's central differences of frequencies along log p, and along N."""
    numbers, counts = SCENES[scene](), np.asarray(COUNTS, float)
    size, columns = numbers.shape[1], []
    for step in (2e-3, 1e-3):
        factor = np.exp(step * np.vstack([np.eye(size), -np.eye(size), np.zeros((2, size))]))
        shift = np.concatenate([np.zeros(2 * size), [step, -step]])
        moved = numbers[:, None] * factor
        values = np.asarray(_values(jnp.asarray(moved), jnp.asarray(counts[:, None] + shift)))
        rising = np.concatenate([values[:, :size], values[:, 2 * size : 2 * size + 1]], axis=1)
        falling = np.concatenate([values[:, size : 2 * size], values[:, 2 * size + 1 :]], axis=1)
        columns.append((rising - falling) / (2 * step))
    coarse, fine = columns
    return np.moveaxis((4 * fine - coarse) / 3, 1, 2)


@pytest.mark.parametrize("mode", _slopes)
@pytest.mark.parametrize("scene", ["over two decades", "over twelve decades", "soft supports"])
def test_derivatives_against_differences(mode, scene):
    found = np.asarray(_slopes[mode](jnp.asarray(SCENES[scene]()), _COUNTS))
    values = _found(scene)
    # The fourth derivatives along log p are of the order of f/gap⁴ of neighbouring roots; the
    # designs of this seed have gaps of some per cent at the least.
    error = np.abs(found - _differences(scene)) / values[:, :, None]
    assert error.max() < 1e-7
    assert np.median(error) < 1e-12


@pytest.mark.parametrize("ratio", [1.0, 1e-12])
def test_derivatives_add_up(ratio):
    """f is homogeneous of degree ½ in stiffnesses and −½ in masses, root by root (Euler)."""
    numbers = jnp.asarray(_softened(ratio))
    values = np.asarray(_many(numbers, _COUNTS))
    for slopes in _slopes.values():
        found = np.asarray(slopes(numbers, _COUNTS))[:, :, :-1]
        np.testing.assert_allclose(found[:, :, ~HEAVY].sum(2), values / 2, rtol=1e-13)
        np.testing.assert_allclose(found[:, :, HEAVY].sum(2), -values / 2, rtol=1e-13)


@jax.jit
@jax.vmap
def _curvature(numbers, count):
    """∂²f/∂log p ∂log p, forward over reverse."""

    def along(logs):
        return _listed(numbers * jnp.exp(logs), count)

    return jax.hessian(along)(jnp.zeros_like(numbers))


@pytest.mark.parametrize("scene", ["over two decades", "soft supports"])
def test_second_derivatives_against_differences_of_first(scene):
    numbers = jnp.asarray(SCENES[scene]())
    found = np.asarray(_curvature(numbers, _COUNTS))
    values = _found(scene)[:, :, None, None]
    np.testing.assert_allclose(found, np.swapaxes(found, 2, 3), atol=1e-12 * values.max())
    step, size = 1e-5, numbers.shape[1]
    for column in range(size):
        factor = jnp.asarray(np.exp(step * np.eye(size)[column : column + 1]))
        rising = np.asarray(_slopes["forward"](numbers * factor, _COUNTS))[:, :, :-1]
        falling = np.asarray(_slopes["forward"](numbers / factor, _COUNTS))[:, :, :-1]
        expected = (rising - falling) / (2 * step)
        # Truncation 1e-10 f/gap³, rounding 1e-16 f/step.
        error = np.abs(found[:, :, :, column] - expected) / values[..., 0]
        assert error.max() < 1e-5
        assert np.median(error) < 1e-10


def test_derivatives_at_repeated_roots():
    """Three equal bodies: two roots coincide and their sum has its true derivative."""
    numbers, values = _alike(0.0), _found("three equal bodies")[:, 1:5]
    double = np.isclose(values[:, :, None], values[:, None, :], rtol=1e-14).sum(2) == 2
    assert np.all(double.sum(1) == 2)
    held = [_column("torsional_support", body) for body in range(3)]
    stiffness, mass = numbers[:, held[0]], numbers[:, _column("equivalent_mass", 0)]
    for slopes in _slopes.values():
        found = np.asarray(slopes(jnp.asarray(numbers), _COUNTS))[:, 1:5, held]
        for design in range(len(COUNTS)):
            pair = double[design]
            slope = stiffness[design] / mass[design] / (8 * np.pi**2 * values[design, pair][0])
            # Both span all motions of the bodies that add up to zero: 2/3 of each body.
            sums = found[design, pair].sum(0)
            np.testing.assert_allclose(sums, [2 / 3 * slope] * 3, rtol=1e-12)
    assert np.all(np.isfinite(_curvature(jnp.asarray(numbers), _COUNTS)))


def test_only_symmetric_systems():
    system = _system(_random(1)[0])
    soft = dataclasses.replace(system.bodies[0], radial_support_y=array(1e6))
    with pytest.raises(ValueError, match="supports equal in x and y"):
        distinct_frequencies(dataclasses.replace(system, bodies=(soft, *system.bodies[1:])))


@pytest.mark.parametrize(
    ("column", "factor"), [(_column("mesh_stiffness", 1), -1.0), (15, 0.0), (2, np.nan)]
)
def test_what_is_no_stable_system_is_no_number(column, factor):
    """Not a plausible wrong frequency, nor zero; its neighbours do not notice."""
    numbers = _random(1)
    numbers[2, column] *= factor
    found = np.asarray(_many(jnp.asarray(numbers), _COUNTS))
    assert np.all(np.isnan(found[2, 1:9]))
    np.testing.assert_array_equal(np.delete(found, 2, 0), np.delete(_found(ALL), 2, 0))


def test_chunks_change_nothing():
    """Any number of designs, any chunk: the same as all at once, and the same gradient."""
    designs = (jnp.asarray(_random(2, 11)), jnp.linspace(3.0, 13.0, 11))

    def one(design):
        return jnp.sum(design[0]) * design[1]

    for chunk in (1, 4, 11, 100):
        found = map_in_chunks(one, designs, chunk=chunk)
        np.testing.assert_allclose(found, designs[0].sum(1) * designs[1], rtol=1e-14)
    chunked = functools.partial(map_in_chunks, lambda design: _listed(*design), chunk=4)  # pyright: ignore[reportGeneralTypeIssues]
    np.testing.assert_allclose(jax.jit(chunked)(designs), _many(*designs), rtol=1e-14)
    slope = jax.grad(lambda c: jnp.sum(map_in_chunks(one, (designs[0], c), chunk=4)))(designs[1])
    np.testing.assert_allclose(slope, designs[0].sum(1), rtol=1e-14)


@pytest.mark.parametrize(
    ("designs", "chunk", "message"),
    [
        ((), 4, "of no array"),
        (jnp.zeros((0, 2)), 4, "at least 1"),
        ((jnp.zeros(3), jnp.zeros(4)), 4, r"\(3,\), \(4,\)"),
        (jnp.zeros(3), 0, "chunk is 0"),
    ],
)
def test_what_cannot_be_chunked(designs, chunk, message):
    with pytest.raises(ValueError, match=message):
        map_in_chunks(lambda design: design, designs, chunk=chunk)
