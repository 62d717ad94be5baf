"""Derivatives of damped modes and of creep friction, forward and reverse, near standstill too."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import example

from prsm_jax.response import creep_friction
from prsm_jax.response._damped_modes import damped_modes
from prsm_jax.vibration import Coordinate, Spring, SpringNetwork, spring_modes

#: Three masses in a chain whose first may move freely with the last, and two dashpots.
_ROWS = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [0.3, 0.2, -0.5]])
_DASHPOTS = np.array([[1.0, 0.0, -1.0], [0.2, -1.0, 0.8]])
_PLACES = tuple(Coordinate(name, "x") for name in "abc")


def _ratios(changes, damping):
    stiffness = jnp.asarray([2e7, 5e6, 1e6]) * (1 + changes)
    names = tuple(Spring(name) for name in "klm")
    mass = jnp.asarray([1.0, 0.4, 0.02])
    network = SpringNetwork(stiffness, jnp.asarray(_ROWS), mass, _PLACES, names)
    dashpots = dataclasses.replace(
        network,
        stiffness=damping * jnp.asarray([1.0, -0.1]) * (1 + changes[0]),
        rows=jnp.asarray(_DASHPOTS),
        springs=names[:2],
    )
    found = damped_modes(spring_modes(network), dashpots)
    return jnp.concatenate([found.ratios, found.first_order])


_values = eqx.filter_jit(_ratios)
_slopes = eqx.filter_jit(jax.jacfwd(_ratios))
_pulled = eqx.filter_jit(jax.jacrev(_ratios))


@pytest.mark.parametrize("damping", [0.0, 3.0, 400.0, 1e9])
def test_forward_and_reverse_derivatives_are_central_differences(damping):
    damping, zero, step = jnp.asarray(damping), jnp.zeros(3), 1e-3
    forward, backward = np.asarray(_slopes(zero, damping)), np.asarray(_pulled(zero, damping))
    for at, way in enumerate(np.eye(3)):
        outer, inner = (
            np.asarray(_values(h * way, damping) - _values(-h * way, damping)) / (2 * h)
            for h in (2 * step, step)
        )
        size = np.abs(np.asarray(_values(zero, damping))) + 1e-4
        assert np.abs(forward[:, at] - (4 * inner - outer) / 3) == pytest.approx(
            0.0, abs=float(1e-8 * size.max())
        )
    assert np.isfinite(backward).all()
    assert backward == pytest.approx(forward, rel=1e-9, abs=1e-12)


@eqx.filter_jit
def _across(mechanism, speed):
    return creep_friction(mechanism, speed=speed, load=12e3).damping_across_slip


def test_damping_across_the_slip_falls_as_the_speed_rises_and_is_finite_at_rest():
    one = example("actuator")
    slope = eqx.filter_jit(lambda m, s: jax.value_and_grad(lambda x: _across(m, x))(s))
    for speed in (157.0, 1e-6):
        value, change = slope(one, jnp.asarray(speed))
        # Without a slope of the law, F μ/v₀ is inversely proportional to the speed.
        assert float(change) == pytest.approx(-float(value) / speed, rel=1e-6)
    assert [float(one) for one in slope(one, jnp.asarray(0.0))] == [0.0, 0.0]
