"""Derivatives of strength and life to all numbers at once: forward, reverse and by differences."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax.quantities import available_quantities, catalogue

_FILES = ("_strength", "_rating_life", "_play")
NAMES = tuple(q.name for q in catalogue() if q.function.__module__.endswith(_FILES))


def _actuator(**duty):
    """The shipped actuator, with a duty cycle of three phases."""
    given = {"duration": [3.0, 2.0, 1.0], "speed": [10.0, -50.0, 200.0], "load": [3e3, 9e3, 1.4e4]}
    one = example("actuator")
    new = [jnp.asarray((given | duty)[name]) for name in given]
    return eqx.tree_at(lambda m: [getattr(m.duty_cycle, n) for n in given], one, new)


#: What a preload makes has derivatives of its own, in closed form, and tests beside it.
BRACED = {"preload_opening_load", "preloaded_stiffness", "preload_torque"}
AVAILABLE = tuple(name for name in NAMES if name not in BRACED)


def _values(leaves, rest):
    found = prsm.compute(eqx.combine(leaves, rest), AVAILABLE)
    return jnp.concatenate([jnp.ravel(found[name]) for name in AVAILABLE])


@eqx.filter_jit
def _forward(leaves, direction, rest):
    return jax.jvp(lambda x: _values(x, rest), (leaves,), (direction,))


@eqx.filter_jit
def _reverse(leaves, weights, rest):
    return jax.vjp(lambda x: _values(x, rest), leaves)[1](weights)[0]


def _direction(leaves):
    """A change of every number by a share of its own."""
    random = np.random.default_rng(5)
    return jax.tree.map(lambda x: jnp.asarray(x * random.uniform(-1, 1, x.shape)), leaves)


def _dot(first, second):
    pairs = zip(jax.tree.leaves(first), jax.tree.leaves(second), strict=True)
    return sum(float(jnp.sum(a * b)) for a, b in pairs)


@pytest.fixture(scope="module")
def parts():
    return eqx.partition(_actuator(), eqx.is_inexact_array)


def test_nothing_is_left_out():
    assert set(available_quantities(_actuator(), NAMES)) == set(AVAILABLE)


def test_forward_agrees_with_differences(parts):
    leaves, rest = parts
    direction = _direction(leaves)
    values, slopes = _forward(leaves, direction, rest)
    step = 1e-6
    ends = [
        _forward(
            jax.tree.map(lambda x, d, s=s: x + s * step * d, leaves, direction), direction, rest
        )
        for s in (1, -1)
    ]
    found = (np.asarray(ends[0][0]) - np.asarray(ends[1][0])) / (2 * step)
    # Second order in a step of 1e-6, and rounding of 1e-16 over it: the meshing has 1e-12.
    np.testing.assert_allclose(
        slopes,
        found,
        rtol=1e-6,
        atol=2e-6 * np.abs(values).max(initial=0, where=np.abs(values) < 1),
    )
    assert np.isfinite(values).all()


@pytest.mark.parametrize(
    "duty",
    [
        {},
        {"load": [0.0, 0.0, 0.0]},
        {"load": [5e3, 5e3, 5e3]},
        {"load": [5e3, -5e3, 0.0]},
        {"speed": [0.0, 0.0, 10.0]},
        {"speed": [0.0, 0.0, 0.0]},
        {"load": [1e-9, 0.0, 1e9]},
    ],
    ids=["ordinary", "no load", "equal", "both flanks", "standing", "never turning", "extreme"],
)
def test_reverse_agrees_with_forward_and_stays_finite(duty):
    leaves, rest = eqx.partition(_actuator(**duty), eqx.is_inexact_array)
    direction = _direction(leaves)
    values, slopes = _forward(leaves, direction, rest)
    assert not np.isnan(values).any()
    assert np.isfinite(slopes).all()
    # Each quantity of order one, so that none drowns in another's rounding.
    scale = jnp.where(jnp.isfinite(values) & (values != 0), jnp.abs(values), 1.0)
    for weights in (jnp.ones_like(values) / scale, jnp.cos(jnp.arange(values.size)) / scale):
        gradient = _reverse(leaves, weights, rest)
        assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(gradient))
        expected = float(jnp.sum(weights * slopes))
        size = float(jnp.sum(jnp.abs(weights * slopes)))
        assert _dot(gradient, direction) == pytest.approx(expected, abs=1e-10 * size)
