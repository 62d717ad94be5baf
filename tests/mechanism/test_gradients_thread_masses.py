"""Derivatives of masses by the rule `thread_profile` against central differences."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.mechanism import body_inertia, body_mass


def _numbers(stage: Any) -> tuple[Any, ...]:
    """Lead, radius, angle, addenda, dedenda, thinnings, bore and wall of a stage."""
    thread, tooth, play = stage.thread, stage.load_sharing.tooth, stage.strength.play
    return (
        thread.lead,
        thread.roller_radius,
        thread.contact_angle,
        thread.screw_addendum,
        thread.roller_addendum,
        tooth.screw_dedendum,
        tooth.roller_dedendum,
        tooth.nut_dedendum,
        play.screw_tooth_thinning,
        play.roller_tooth_thinning,
        play.nut_tooth_thinning,
        stage.screw.bore_radius,
        stage.nut.wall_thickness,
    )


@pytest.mark.parametrize("body", ["screw", "roller", "nut"])
def test_forward_and_reverse_are_the_central_differences(body):
    """Steps of 1e-5 of a number: differences err by 1e-10 and by rounding, 1e-11 of the mass."""
    stage = dataclasses.replace(prsm.load("actuator").stages[0], mass_rule="thread_profile")
    start = jnp.stack(_numbers(stage))
    first = jnp.stack([body_mass(stage, body), body_inertia(stage, body)])

    @jax.jit
    def of(relative):
        moved = eqx.tree_at(_numbers, stage, tuple(start * (1 + relative)))
        return jnp.stack([body_mass(moved, body), body_inertia(moved, body)]) / first

    zero, step = jnp.zeros(start.size), 1e-5
    steps = step * np.eye(start.size)
    differences = np.stack([(of(zero + s) - of(zero - s)) / (2 * step) for s in steps], axis=1)
    assert np.all(np.abs(differences).max(axis=1) > 0.1)
    np.testing.assert_allclose(jax.jacfwd(of)(zero), differences, atol=2e-9)
    np.testing.assert_allclose(jax.jacrev(of)(zero), differences, atol=2e-9)
