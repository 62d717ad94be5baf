"""Half-space contacts far from the ordinary, all in one batch: each found, or marked."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.contact import hertz_contact
from prsm_jax.halfspace import Grid, flank_contact, solve_contact

_RANDOM = np.random.default_rng(11)
_SHAPE = (32, 32)
_NOISE = jnp.asarray(_RANDOM.normal(size=_SHAPE))
_INDEX = jnp.arange(32.0) - 15.5
_X, _Y = jnp.meshgrid(_INDEX, _INDEX, indexing="ij")
_PARABOLOID = _X**2 + 1.4 * _Y**2
_ALL = jnp.ones(_SHAPE, bool)

#: Gap, material, spacings along x and y, modulus, load, expected code.
SCENES = {
    "ordinary": (1e-8 * _PARABOLOID, _ALL, 1e-5, 1e-5, 1e11, 10.0, 0),
    "white noise, three times the approach": (
        1e-8 * _PARABOLOID + 3e-6 * _NOISE, _ALL, 1e-5, 1e-5, 1e11, 10.0, 2,
    ),
    "white noise, a tenth of it": (
        1e-8 * _PARABOLOID + 1e-7 * _NOISE, _ALL, 1e-5, 1e-5, 1e11, 10.0, 0,
    ),
    "cells a hundred times as long as wide": (1e-8 * _PARABOLOID, _ALL, 1e-3, 1e-5, 1e11, 40.0, 0),
    "nanometres": (1e-17 * _PARABOLOID, _ALL, 1e-14, 1e-14, 1e11, 1e-17, 0),
    "kilometres": (1e1 * _PARABOLOID, _ALL, 1e4, 1e4, 1e11, 1e19, 0),
    "soft as jelly": (1e-8 * _PARABOLOID, _ALL, 1e-5, 1e-5, 1e3, 1e-7, 0),
    "one cell with material": (
        1e-8 * _PARABOLOID, (_X == 0.5) & (_Y == 0.5), 1e-5, 1e-5, 1e11, 10.0, 0,
    ),
    "one cell in contact": (1e-2 * _PARABOLOID, _ALL, 1e-5, 1e-5, 1e11, 1e-9, 0),
    "a large constant": (1.0 + 1e-8 * _PARABOLOID, _ALL, 1e-5, 1e-5, 1e11, 10.0, 0),
    "the edge of a body through the middle": (
        1e-8 * _PARABOLOID, _X < 0, 1e-5, 1e-5, 1e11, 5.0, 0,
    ),
    "flat": (0.0 * _PARABOLOID, _ALL, 1e-5, 1e-5, 1e11, 10.0, 2),
    "no material": (1e-8 * _PARABOLOID, ~_ALL, 1e-5, 1e-5, 1e11, 10.0, 1),
    "no load": (1e-8 * _PARABOLOID, _ALL, 1e-5, 1e-5, 1e11, 0.0, 3),
    "pulled": (1e-8 * _PARABOLOID, _ALL, 1e-5, 1e-5, 1e11, -3.0, 3),
    # Its peaks overlap before there is any load, by more than the tolerance counted in metres.
    "no load on a rough gap": (
        1e-8 * _PARABOLOID + 1e-6 * _NOISE, _ALL, 1e-5, 1e-5, 1e11, 0.0, 3,
    ),
    "not a number": (jnp.full(_SHAPE, jnp.nan), _ALL, 1e-5, 1e-5, 1e11, 10.0, 1),
    "infinite load": (1e-8 * _PARABOLOID, _ALL, 1e-5, 1e-5, 1e11, np.inf, 1),
}  # fmt: skip


@pytest.fixture(scope="module")
def batch():
    gaps, material, *numbers, _ = (
        jnp.asarray(column) for column in zip(*SCENES.values(), strict=True)
    )

    def at(gap, material, spacing_x, spacing_y, modulus, load):
        def peak(load, gap):
            grid = Grid(_SHAPE, spacing_x, spacing_y)
            # A constant of a metre leaves 1e-16 m of the gap's digits, 1e-10 of the displacement.
            found = solve_contact(grid, gap, modulus, load=load, material=material, tolerance=1e-7)
            return found.max_pressure, found

        slopes, found = jax.grad(peak, argnums=(0, 1), has_aux=True)(load, gap)
        return found, slopes

    return jax.jit(jax.vmap(at))(gaps, material, *numbers)


def test_codes_of_all_scenes(batch):
    found, _ = batch
    codes = dict(zip(SCENES, found.code.tolist(), strict=True))
    assert codes == {name: scene[-1] for name, scene in SCENES.items()}
    assert int(jnp.max(found.iterations)) < 300


def test_what_is_found_is_a_contact(batch):
    """Load carried, no overlap, finite values and derivatives, whatever the neighbours do."""
    found, (by_load, by_gap) = batch
    for index, (name, scene) in enumerate(SCENES.items()):
        if scene[-1] == 1:
            continue
        one = jax.tree.map(lambda leaf, i=index: np.asarray(leaf[i]), found)
        assert one.load == pytest.approx(max(scene[5], 0.0), rel=1e-12), name
        scale = max(one.displacement.max(), 1e-300)
        assert one.separation[np.asarray(scene[1])].min() >= -1.001e-7 * scale, name
        assert np.all(np.isfinite(one.pressure)), name
        assert np.isfinite(by_load[index]), name
        assert np.all(np.isfinite(by_gap[index])), name


def test_scaled_scenes_agree(batch):
    """Sizes and moduli only scale: the same share of the Hertz pressure within the grid's error."""
    found, _ = batch
    names = list(SCENES)
    for name in ("ordinary", "nanometres", "kilometres", "soft as jelly", "a large constant"):
        gap, _, spacing, _, modulus, load, _ = SCENES[name]
        first = (gap[20, 15] - gap[19, 15]) / ((4.5**2 - 3.5**2) * spacing**2)
        exact = hertz_contact(
            jnp.asarray(load),
            jnp.asarray(2.4 * first),
            jnp.asarray((0.4 * first) ** 2),
            jnp.asarray(modulus),
        )
        share = float(found.max_pressure[names.index(name)] / exact.max_pressure)
        assert share == pytest.approx(1.0, abs=3e-3), name


def test_flanks_under_loads_of_any_size():
    """Below a nanometre the heights of the flanks differ by less than their rounding."""
    mechanism = prsm.load("actuator")
    thread = dataclasses.replace(
        mechanism.stages[0].thread, screw_addendum=None, roller_addendum=None
    )
    stage = dataclasses.replace(mechanism.stages[0], thread=thread)
    loads = jnp.asarray([1e-90, 1e-30, 1e-12, 1e-9, 1e-3, 1e3])

    @jax.jit
    @jax.vmap
    def pressures(load):
        found = flank_contact(stage, "screw", load, (16, 16))
        return found.surface.code, found.surface.max_pressure / found.hertz.max_pressure

    codes, ratio = pressures(loads)
    assert codes.tolist() == [0] * len(loads)
    # The grid's own error, the same for contacts that are small beside the flanks.
    np.testing.assert_allclose(ratio[:-1], ratio[0], rtol=1e-4)
    np.testing.assert_allclose(ratio, 1.0, atol=2e-2)
