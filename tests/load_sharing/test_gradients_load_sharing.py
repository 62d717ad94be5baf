"""Derivatives of load sharing through the set of threads that touch, against differences."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, mechanism
from sharing_scenes import HERTZ, SEGMENT, TOOTH, chains, sharing_stage

import prsm_jax as prsm
from prsm_jax.load_sharing import elastic_deflection, equilibrium

_GAPS = np.random.default_rng(3).normal(size=(1, 8)) * 2e-6
_NUMBERS = {
    "gap": jnp.asarray(_GAPS),
    "backlash": array(4e-6),
    "hertz": array(HERTZ),
    "tooth": array(TOOTH),
    "segment": array(SEGMENT),
    "load": array(500.0),
}


def _outputs(numbers):
    """Loads of eight threads on the screw side, and the force in the nut halfway [N]."""
    bare = chains(
        8,
        gap=numbers["gap"],
        backlash=numbers["backlash"],
        hertz=numbers["hertz"],
        tooth=numbers["tooth"],
        segments=(numbers["segment"], 8 * numbers["segment"], numbers["segment"] / 4),
        load=500.0,
    )
    found = equilibrium(bare, numbers["load"])
    forward, _ = bare.screw.loads(found.state.screw_approach, found.state.radial_shift[:, None])
    force = forward[0] + bare.regularisation * (found.state.screw_approach - bare.screw.centre)[0]
    return jnp.append(force, found.state.nut_force[3])


_value = jax.jit(_outputs)
_forward = jax.jit(lambda numbers, along: jax.jvp(_outputs, (numbers,), (along,))[1])
_reverse = jax.jit(lambda numbers, weights: jax.vjp(_outputs, numbers)[1](weights)[0])


def _direction(name):
    along = jax.tree.map(jnp.zeros_like, _NUMBERS)
    if name == "gap":
        return along | {"gap": 1e-7 * jnp.asarray(np.random.default_rng(1).normal(size=(1, 8)))}
    return along | {name: 0.01 * _NUMBERS[name]}


def _moved(numbers, along, step):
    return jax.tree.map(lambda a, b: a + step * b, numbers, along)


def _differences(numbers, along, step=0.05):
    """Of fourth order; the law's third derivatives leave 1e-6 of a share of the load."""
    one = _value(_moved(numbers, along, step)) - _value(_moved(numbers, along, -step))
    two = _value(_moved(numbers, along, 2 * step)) - _value(_moved(numbers, along, -2 * step))
    return np.asarray(8 * one - two) / (12 * step)


@functools.cache
def _gradients():
    weights = jnp.eye(9)
    return [_reverse(_NUMBERS, weights[i]) for i in range(9)]


@pytest.mark.parametrize("name", _NUMBERS)
def test_both_modes_against_differences(name):
    """Some threads carry nothing here, and theirs are exactly 0."""
    along = _direction(name)
    forward = np.asarray(_forward(_NUMBERS, along))
    np.testing.assert_allclose(forward, _differences(_NUMBERS, along), atol=2e-6)
    backward = [float(jnp.sum(row[name] * along[name])) for row in _gradients()]
    np.testing.assert_allclose(backward, forward, atol=1e-9)
    loads = np.asarray(_value(_NUMBERS))
    assert np.any(np.abs(loads) < 1e-6)
    if name not in ("backlash",):
        assert np.max(np.abs(forward)) > 1e-4


def test_a_contact_that_just_opens():
    """The force is smooth there: both one-sided differences meet the derivative."""
    along = _direction("load")
    low, high = 1.0, 500.0

    def closed(load):
        return np.sum(np.asarray(_value(_NUMBERS | {"load": array(load)}))[:8] > 1e-6)

    count = closed(high)
    for _ in range(45):
        middle = (low + high) / 2
        low, high = (low, middle) if closed(middle) == count else (middle, high)
    numbers = _NUMBERS | {"load": array(high)}
    forward = np.asarray(_forward(numbers, along))
    assert np.all(np.isfinite(forward))
    here = np.asarray(_value(numbers))
    for step in (1e-3, -1e-3):
        onesided = (np.asarray(_value(_moved(numbers, along, step))) - here) / step
        # The slope of a Hertz contact that has just closed is the root of its approach.
        np.testing.assert_allclose(onesided, forward, atol=0.05)
    backward = _reverse(numbers, jnp.ones(9))
    assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(backward))


@pytest.mark.parametrize("backlash", [-12e-6, 20e-6])
def test_where_a_nut_stands_without_load(backlash):
    """Braced by thick rollers, or with play: both modes against differences."""
    got, forward, reverse = _rest(array(backlash))
    assert bool(got.preloaded) == (backlash < 0)
    step = 1e-9
    after, before = (_rest(array(backlash + sign * step))[0] for sign in (1, -1))
    difference = (float(after.unloaded_position) - float(before.unloaded_position)) / (2 * step)
    # Differences of second order, and rests found to 1e-12 of some micrometres.
    assert float(forward) == pytest.approx(difference, abs=1e-6)
    assert float(reverse) == pytest.approx(float(forward), abs=1e-12)
    # Backward the play is passed first; a preloaded nut floats in the middle of what there is.
    assert float(forward) == pytest.approx(-1 if backlash > 0 else -0.5, abs=0.2)


@jax.jit
def _rest(backlash):
    def found(value):
        bare = chains(4, gap=jnp.asarray(_GAPS[:, :4]), backlash=value)
        return elastic_deflection(bare, array(-100.0), array(0.0))

    def rest(value):
        return found(value).unloaded_position

    return found(backlash), jax.jacfwd(rest)(backlash), jax.jacrev(rest)(backlash)


def test_no_load_at_all():
    """Without errors and without load every thread takes an equal part of the first newton."""
    numbers = _NUMBERS | {
        "gap": jnp.zeros((1, 8)), "load": array(0.0), "backlash": array(0.0)
    }  # fmt: skip
    along = jax.tree.map(jnp.zeros_like, numbers) | {"load": array(1.0)}
    np.testing.assert_allclose(_value(numbers)[:8], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.asarray(_forward(numbers, along))[:8], 1 / 8, rtol=1e-6)
    backward = _reverse(numbers, jnp.ones(9))
    assert float(backward["load"]) == pytest.approx(1.5, rel=1e-6)
    assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(backward))


def test_batched_gradients():
    """vmap of gradients gives each its own."""
    loads = jnp.asarray([200.0, 500.0])
    batch = eqx.filter_jit(jax.vmap(jax.grad(lambda load: _outputs(_NUMBERS | {"load": load})[8])))(
        loads
    )
    assert float(batch[1]) == pytest.approx(float(_gradients()[8]["load"]), rel=1e-9)
    assert float(batch[0]) != pytest.approx(float(batch[1]), rel=1e-3)


def test_second_derivative():
    """The slope of the first, by central differences."""

    def slope(load):
        return _reverse(_NUMBERS | {"load": load}, jnp.eye(9)[8])["load"]

    once = jax.grad(lambda load: _outputs(_NUMBERS | {"load": load})[8])
    bend = jax.jit(jax.jacfwd(once))(array(500.0))
    difference = (slope(array(500.1)) - slope(array(499.9))) / 0.2
    assert float(bend) == pytest.approx(float(difference), rel=1e-4)
    assert abs(float(bend)) > 1e-7


def test_a_stage_and_its_tangent_stiffness():
    """Through the whole stage, to a number of the file; the stiffness is a derivative itself."""
    one = mechanism(sharing_stage(tooth=None))

    def stiffness(shares):
        moved = prsm.set_parameter(one, "stage.1.screw.bore_radius", 4e-3 * shares[0])
        quantities = ["axial_stiffness_shared", "thread_stiffness_screw"]
        found = prsm.compute(moved, quantities, load=7e3 * shares[1])
        return jnp.append(
            found["thread_stiffness_screw"] / 2e8, found["axial_stiffness_shared"] / 1e9
        )

    value = jax.jit(stiffness)
    here = jnp.ones(2)
    reverse = jax.jit(jax.jacrev(stiffness))(here)
    steps = 0.01 * jnp.eye(2)
    difference = [(value(here + step) - value(here - step)) / 0.02 for step in steps]
    # The differences' own error is a few 1e-4 of the derivative (steps of 1 %, second order).
    np.testing.assert_allclose(reverse, np.stack(difference, axis=1), rtol=1e-3)
    # A larger bore softens the screw; a larger load stiffens the contacts.
    assert float(reverse[1, 0]) < 0 < float(reverse[1, 1])
