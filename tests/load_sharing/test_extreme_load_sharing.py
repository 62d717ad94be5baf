"""Load sharing where numbers are decades from those of a roller screw."""

import dataclasses
import itertools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, example
from sharing_scenes import HERTZ, SEGMENT, TOOTH, chains, equilibrium, loads_of

import prsm_jax as prsm
from prsm_jax.load_sharing import equilibrium as solve, regularised

_ERRORS = np.random.default_rng(8).normal(size=(1, 12)) * 2e-6
_CONTACTS = (1e-12, 1e-6, 1.0, 1e6, 1e12)
_SEGMENTS = (0.0, 1e-20, SEGMENT, 1e-5, 1.0, 1e12)
_LOADS = (1e-6, 1.0, 1e3, 1e6)


@eqx.filter_jit
def _grid(scale, segment, load, errors):
    def one(scale, segment, load):
        # Errors of the size of an approach: larger ones than 1e12 approaches leave no digits.
        unit = HERTZ * scale * (load / 12) ** (2 / 3)
        bare = chains(
            12,
            gap=errors * unit,
            hertz=HERTZ * scale,
            tooth=TOOTH * scale,
            segments=(segment, segment, segment),
        )
        units = regularised(bare, load=load)
        bare = dataclasses.replace(
            bare,
            regularisation=units.regularisation,
            typical_force=units.typical_force,
            radial_regularisation=units.radial_regularisation,
        )
        found = solve(bare, load)
        screw, _ = bare.screw.loads(found.state.screw_approach, 0.0)
        return found.result, found.steps, jnp.sum(screw), jnp.min(screw)

    return jax.vmap(one)(scale, segment, load)


@pytest.mark.parametrize("errors", [0.0, 1.0])
def test_stiff_and_soft(errors):
    """Contacts over 24 decades, shafts from rigid to none, loads from 1 µN to 1 MN."""
    grid = np.array(list(itertools.product(_CONTACTS, _SEGMENTS, _LOADS)))
    pattern = jnp.asarray(errors * np.abs(_ERRORS) / np.abs(_ERRORS).max())
    result, steps, total, least = _grid(*(jnp.asarray(c) for c in grid.T), pattern)  # pyright: ignore[reportCallIssue]
    assert np.all(np.asarray(result) == 0), grid[np.asarray(result) != 0]
    np.testing.assert_allclose(total, grid[:, 2], rtol=1e-8)
    assert np.all(np.asarray(least) >= 0)
    assert np.max(np.asarray(steps)) <= 40


def test_many_unlike_rollers_from_rigid_shafts_to_none():
    """By arrays, a batch side by side or one alone: as three classes number by number."""
    errors = np.random.default_rng(9).normal(size=(4, 6)) * 1e-6
    # The fourth is like the third, so that three classes say the same.
    errors[3] = errors[2]

    def total(weight, segment):
        bare = chains(6, weight, gap=errors[: len(weight)], segments=(segment,) * 3)
        found = solve(bare, array(1e3))
        screw, _ = bare.screw.loads(found.state.screw_approach, 0.0)
        return found.result, screw[:3]

    segments = jnp.asarray([0.0, 1e-20, SEGMENT, 1e-5, 1e12])
    batch = jax.jit(jax.vmap(lambda s: total((1.0, 2.0, 1.0, 1.0), s)))
    result, loads = batch(segments)
    few, expected = jax.jit(jax.vmap(lambda s: total((1.0, 2.0, 2.0), s)))(segments)
    assert np.all(np.asarray(result) == 0) & np.all(np.asarray(few) == 0)
    np.testing.assert_allclose(loads, expected, atol=1e-7)
    alone = jax.jit(lambda s: total((1.0, 2.0, 1.0, 1.0), s))(segments[2])
    np.testing.assert_allclose(alone[1], expected[2], atol=1e-7)


def test_one_thread_and_a_hundred():
    one = chains(1, load=500.0)
    found = equilibrium(one, array(500.0))
    assert int(found.result) == 0
    assert loads_of(one, found)[0][0, 0] == pytest.approx(500.0, rel=1e-10)
    errors = np.random.default_rng(2).normal(size=(1, 100)) * 2e-6
    many = chains(100, (30.0,), gap=errors, load=1e6)
    found = equilibrium(many, array(1e6))
    assert int(found.result) == 0
    assert 30 * loads_of(many, found)[1].sum() == pytest.approx(1e6, rel=1e-9)


def test_loose_teeth_without_load():
    """Backlash and no load: all float, none carries, and the numbers are finite."""
    loose = chains(8, gap=_ERRORS[:, :8], backlash=20e-6, load=0.0)
    found = equilibrium(loose, array(0.0))
    assert int(found.result) == 0
    for side in loads_of(loose, found):
        np.testing.assert_array_equal(side, 0.0)
    state = jax.tree.leaves(found.state)
    assert all(np.all(np.isfinite(leaf)) for leaf in state)


def test_a_load_that_is_not_a_number_is_told():
    found = equilibrium(chains(1, load=500.0), array(np.nan))
    assert int(found.result) == 2


def test_bodies_too_stiff_for_a_balance_are_no_zero():
    """Loads hang on errors of the pitch that no body gives way to; what is found carries them."""
    shared = example("actuator_load_sharing")
    names = ["largest_thread_load", "axial_deflection"]
    equal = None
    for modulus in (2.1e11, 2.1e15, 2.1e16):
        stiff = prsm.set_parameter(shared, "material.youngs_modulus", modulus)
        found = {k: np.ravel(v)[0] for k, v in prsm.compute(stiff, names).items()}
        missing = [np.isnan(value) for value in found.values()]
        assert all(missing) or not any(missing)
        equal = found["largest_thread_load"] if equal is None else equal
        # Fewer threads carry the same load the stiffer they are.
        assert all(missing) or found["largest_thread_load"] >= equal > 0
        assert all(missing) or min(found.values()) > 0
