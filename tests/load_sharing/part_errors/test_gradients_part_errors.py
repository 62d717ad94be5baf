"""Derivatives by errors of parts: closed form, differences, work; two compiler settings."""

import os
import subprocess
import sys

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from error_scenes import ERRORS, FREE, LOAD, NO_ERRORS, ROLLERS, THREADS, stage_with
from jax.flatten_util import ravel_pytree
from scenes import array

from prsm_jax.load_sharing import stage_load_distribution
from prsm_jax.mechanism import PartErrors

#: Steps of differences by error: micrometres, and angles that move flanks by as much.
_STEPS = PartErrors(
    *(1e-7, 1e-3, 1e-5, 1e-3) * 2,
    roller_diameter_deviation=np.full(ROLLERS, 1e-7),
    roller_tilt=np.full(ROLLERS, 1e-6),
)


def _outputs(errors, stage):
    """Loads of rollers and of their first threads, force, moment, and travel.

    Not the largest of equal rollers, which has a kink where they are equal.
    """
    one = eqx.tree_at(lambda s: s.load_sharing.part_errors, stage, errors)
    found = stage_load_distribution(one, array(LOAD))
    across = [found.nut_radial_force, found.nut_overturning_moment * 100]
    if found.nut_displacement is not None:
        across += [found.nut_displacement * 1e7, found.nut_lean * 1e6]
    numbers = [found.deflection * 1e7, found.tangent_stiffness / 1e6]
    loads = [found.nut.roller_load, found.screw.forward[:, 0]]
    return jnp.concatenate([*loads, *across, jnp.stack(numbers)])


@eqx.filter_jit
def _both(errors, stage, along, weights):
    """Values, their derivative along a direction, and the gradient of a weighted sum."""
    value, forward = jax.jvp(lambda e: _outputs(e, stage), (errors,), (along,))
    (reverse,) = jax.vjp(lambda e: _outputs(e, stage), errors)[1](weights)
    return value, forward, reverse


def _direction(seed):
    random = np.random.default_rng(seed)
    return jax.tree.map(lambda x: x * jnp.asarray(random.uniform(-1, 1, x.shape)), _STEPS)


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("errors", [ERRORS, NO_ERRORS], ids=["errors", "none"])
def test_against_differences(errors, free):
    """Forward and reverse, also where threads and a whole roller carry nothing."""
    stage = stage_with(errors, **({"free_nut": FREE} if free else {}))
    part = stage.load_sharing.part_errors
    weights = np.random.default_rng(2).normal(size=ROLLERS * 2 + (10 if free else 6))
    for seed in (0, 1):
        along = _direction(seed)
        _, forward, reverse = _both(part, stage, along, weights)

        def at(step, along=along):
            moved = jax.tree.map(lambda a, b: a + step * b, part, along)
            return np.asarray(_both(moved, stage, along, weights)[0])

        one, two = (at(h) - at(-h) for h in (0.01, 0.02))
        difference = (8 * one - two) / (12 * 0.01)
        # Differences of the fourth order, of balances found to 1e-12 of the load: 1e-8 N over a
        # step of 0.01, of 100 N.
        scale = np.abs(difference).max()
        np.testing.assert_allclose(forward, difference, atol=1e-7 * scale)
        inner = np.dot(ravel_pytree(reverse)[0], ravel_pytree(along)[0])
        assert inner == pytest.approx(float(weights @ np.asarray(forward)), rel=1e-9)


def test_closed_form_without_errors():
    """Around the screw the change is cos φ: its sum is 0, so that screw and nut stay.

    Each roller is then a chain of springs between two walls, of which the nut's moves.
    """
    stage = stage_with({})
    part = stage.load_sharing.part_errors
    zero = jax.tree.map(jnp.zeros_like, part)
    along = eqx.tree_at(lambda e: e.nut_eccentricity, zero, array(1.0))
    _, forward, _ = _both(part, stage, along, np.zeros(2 * ROLLERS + 6))
    found = eqx.filter_jit(stage_load_distribution)(stage, array(LOAD))

    def spring(load, flanks):
        return 1 / (float(flanks.tooth[0, 0]) + 2 / 3 * float(flanks.hertz[0, 0]) / np.cbrt(load))

    screw = spring(np.asarray(found.screw.forward[0]), found.chains.screw)
    nut = spring(np.asarray(found.nut.forward[0]), found.chains.nut)
    shaft = 1 / float(found.chains.roller_segment[0])
    steps = np.diff(np.eye(THREADS), axis=0)
    nodes = np.linalg.solve(np.diag(screw + nut) + shaft * steps.T @ steps, nut)
    # Nut moves away by 1 (tan 45°): its springs lose, the roller follows by `nodes`.
    change = -np.sum(nut * (1 - nodes))
    angle = 2 * np.pi * np.arange(ROLLERS) / ROLLERS
    np.testing.assert_allclose(forward[:ROLLERS], change * np.cos(angle), atol=1e-9 * abs(change))
    force = np.asarray(forward)[2 * ROLLERS : 2 * ROLLERS + 2]
    assert force[0] == pytest.approx(change * ROLLERS / 2, rel=1e-9)
    assert abs(force[1]) < 1e-9 * abs(change)


@eqx.filter_jit
def _work(errors, stage):
    """Slope of the energy less the work of the load, and the forces that it is of."""

    def potential(errors):
        one = eqx.tree_at(lambda s: s.load_sharing.part_errors, stage, errors)
        found = stage_load_distribution(one, array(LOAD))
        return found.stored_energy - array(LOAD) * found.deflection, found

    slope, found = jax.grad(potential, has_aux=True)(errors)
    return slope, found.nut_radial_force, found.nut_overturning_moment


def test_forces_do_the_work_of_displacements():
    """Castigliano: minus the slope by eccentricity and tilt is the force in their direction."""
    stage = stage_with(ERRORS)
    slope, force, moment = _work(stage.load_sharing.part_errors, stage)
    for name, angle, vector in (
        ("nut_eccentricity", "nut_eccentricity_angle", force),
        ("nut_tilt", "nut_tilt_angle", moment),
    ):
        direction = np.array([np.cos(ERRORS[angle]), np.sin(ERRORS[angle])])
        across = np.array([-direction[1], direction[0]])
        assert -float(getattr(slope, name)) == pytest.approx(float(vector @ direction), rel=1e-7)
        turned = -float(getattr(slope, angle))
        assert turned == pytest.approx(ERRORS[name] * float(vector @ across), rel=1e-7)


def finite():
    """Whether all derivatives by all numbers of a stage are finite (called in a process too)."""
    stage = stage_with(ERRORS)
    arrays, rest = eqx.partition(stage, eqx.is_array)

    def value(arrays):
        found = stage_load_distribution(eqx.combine(arrays, rest), array(LOAD))
        return jnp.sum(found.nut.forward[:, 0]) + 1e6 * found.elastic.deflection

    slopes = jax.tree.leaves(jax.jit(jax.grad(value))(arrays))
    return len(slopes) > 10 and all(bool(jnp.all(jnp.isfinite(one))) for one in slopes)


def test_all_derivatives_are_finite_without_optimised_code():
    """Differently fused code rounds a gap differently: its largest must be found by its index."""
    assert "optimization_level=0" in os.environ["XLA_FLAGS"]
    assert finite()


def test_all_derivatives_are_finite_with_the_compiler_settings_of_users():
    environment = {key: value for key, value in os.environ.items() if key != "XLA_FLAGS"}
    folders = [os.path.dirname(__file__), os.path.join(os.path.dirname(__file__), "../..")]
    program = f"import sys; sys.path[:0] = {folders!r}; import test_gradients_part_errors as t; "
    run = [sys.executable, "-c", program + "assert t.finite()"]
    subprocess.run(run, env=environment, check=True)
