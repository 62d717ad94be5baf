"""Derivatives of damping ratios, forward and reverse, near standstill and at repeated roots too."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from scenes import example

import prsm_jax as prsm
from prsm_jax.friction import StribeckFriction
from prsm_jax.response import spatial_damping


def _mechanism():
    one = example("actuator")
    friction = dataclasses.replace(
        present(one.stages[0].friction),
        thread=StribeckFriction(0.15, 0.06, 0.1),
        spin=None,
        rolling_hysteresis=None,
    )
    return dataclasses.replace(one, stages=(dataclasses.replace(one.stages[0], friction=friction),))


def _ratios(mechanism, changes, speed):
    """Exact and first-order ratios of all groups; the transverse and roller roots are repeated."""
    moved = mechanism
    for name, change in zip(("lead", "roller_radius"), changes[1:], strict=True):
        value = prsm.get_parameter(mechanism, name)
        moved = prsm.set_parameter(moved, name, value * (1 + change))
    found = spatial_damping(moved, speed=speed * (1 + changes[0]), load=12e3)
    return jnp.concatenate([*found.ratios, *found.first_order_ratios])


_values = eqx.filter_jit(_ratios)


@eqx.filter_jit
def _slope(mechanism, direction, speed):
    zero = jnp.zeros_like(direction)
    return jax.jvp(lambda c: _ratios(mechanism, c, speed), (zero,), (direction,))[1]


@eqx.filter_jit
def _pulled_back(mechanism, weights, speed):
    return jax.grad(lambda c: weights @ _ratios(mechanism, c, speed))(jnp.zeros(3))


@pytest.mark.parametrize("speed", [157.0, 1e-4, 0.0])
def test_forward_and_reverse_derivatives_are_central_differences(speed):
    mechanism = _mechanism()
    speed = jnp.asarray(speed)
    at_zero = np.asarray(_values(mechanism, jnp.zeros(3), speed))
    assert np.isfinite(at_zero).all()
    slopes = np.stack([_slope(mechanism, jnp.eye(3)[at], speed) for at in range(3)], axis=1)
    step = 1e-4
    for at in range(3):
        outer, inner = (
            (_values(mechanism, h * jnp.eye(3)[at], speed)
             - _values(mechanism, -h * jnp.eye(3)[at], speed)) / (2 * h)
            for h in (2 * step, step)
        )  # fmt: skip
        difference = np.asarray(4 * inner - outer) / 3
        # Rounding of the ratios over the step: |Re λ| has the digits of |λ|, some 1e-14.
        assert slopes[:, at] == pytest.approx(difference, rel=1e-6, abs=1e-9)
    weights = np.where(np.abs(at_zero) > 0, 1 / np.where(at_zero == 0, 1.0, at_zero), 0.0)
    pulled = np.asarray(_pulled_back(mechanism, jnp.asarray(weights), speed))
    assert np.isfinite(pulled).all()
    assert pulled == pytest.approx(weights @ slopes, rel=1e-8, abs=1e-8)
