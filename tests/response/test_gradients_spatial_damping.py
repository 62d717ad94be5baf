"""Derivatives of damping ratios through the whole mechanism: meshing, contact, friction, modes."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from scenes import example

import prsm_jax as prsm
from prsm_jax.friction import CoulombFriction
from prsm_jax.response import spatial_damping

PARAMETERS = ("lead", "contact_angle", "roller_radius", "friction.thread.coefficient")
SPEED, LOAD = 157.0, 3e3


def _mechanism(name):
    """An example with thread friction alone, without its axis: elastic modes are its own."""
    one = example(name)
    friction = dataclasses.replace(
        present(one.stages[0].friction), thread=CoulombFriction(0.07), spin=None,
        rolling_hysteresis=None, thrust_bearing=None, drag=None,
    )  # fmt: skip
    stage = dataclasses.replace(one.stages[0], friction=friction, sharing="equal")
    return dataclasses.replace(one, stages=(stage,), axis=None)


@pytest.mark.parametrize("name", ["actuator", "humanoid_leg"])
def test_both_modes_are_central_differences(name):
    one = _mechanism(name)
    start = jnp.asarray([float(prsm.get_parameter(one, p)) for p in PARAMETERS])

    @eqx.filter_jit
    def ratios(changes):
        moved = one
        for parameter, value, change in zip(PARAMETERS, start, changes, strict=True):
            moved = prsm.set_parameter(moved, parameter, value * (1 + change))
        found = spatial_damping(moved, speed=SPEED, load=LOAD)
        # Of the elastic axial–torsional modes, from the strongest to the weakest damping.
        return jnp.log(jnp.sort(found.ratios[0])[-3:])

    zero, step = jnp.zeros(len(PARAMETERS)), 1e-4
    forward = np.asarray(eqx.filter_jit(jax.jacfwd(ratios))(zero))
    reverse = np.asarray(eqx.filter_jit(jax.jacrev(ratios))(zero))
    assert np.all(np.isfinite(forward))
    np.testing.assert_allclose(reverse, forward, rtol=1e-8, atol=1e-9)
    for at, way in enumerate(np.eye(len(PARAMETERS))):
        outer, inner = (
            np.asarray(ratios(h * way) - ratios(-h * way)) / (2 * h) for h in (2 * step, step)
        )
        # Relative change per relative change; Richardson's differences err by 1e-8 of them.
        difference = (4 * inner - outer) / 3
        np.testing.assert_allclose(forward[:, at], difference, rtol=1e-6, atol=1e-6)
