"""Derivatives of the frequencies in space, through meshing and contacts, at repeated roots."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from scenes import example
from spatial_scenes import held_stage, modes_of, system_of
from tilt_assembly import tilting_stage

import prsm_jax as prsm
from prsm_jax.stiffness import ThreadStiffness

_VARIABLES = ("lead", "contact_angle", "roller_radius")


def _mechanism():
    """The held stage with thread stiffnesses of Hertz contacts, and exact curvatures."""
    given = dataclasses.replace(present(held_stage().stiffness), screw_roller=None, nut_roller=None)
    stage = dataclasses.replace(held_stage(), stiffness=given, curvature="exact")
    return dataclasses.replace(example("wu2022"), stages=(stage,))


def _distinct(mechanism, changes):
    """Each distinct frequency, the mean of its cluster, with variables changed by these shares."""
    moved = mechanism
    for variable, change in zip(_VARIABLES, changes, strict=True):
        value = prsm.get_parameter(mechanism, variable)
        moved = prsm.set_parameter(moved, variable, value * (1 + change))
    return jnp.concatenate([group.frequencies for group in prsm.spatial_modal(moved).groups])


_values = eqx.filter_jit(_distinct)


@eqx.filter_jit
def _slope(mechanism, direction):
    zero = jnp.zeros_like(direction)
    return jax.jvp(lambda c: _distinct(mechanism, c), (zero,), (direction,))[1]


@eqx.filter_jit
def _pulled_back(mechanism, weights):
    return jax.grad(lambda c: weights @ _distinct(mechanism, c))(jnp.zeros(3))


def test_forward_and_reverse_derivatives_are_central_differences():
    mechanism = _mechanism()
    slopes = np.stack([_slope(mechanism, jnp.eye(3)[at]) for at in range(3)], axis=1)
    step = 1e-4
    for at in range(3):
        outer, inner = (
            (_values(mechanism, h * jnp.eye(3)[at]) - _values(mechanism, -h * jnp.eye(3)[at]))
            / (2 * h)
            for h in (2 * step, step)
        )
        difference = np.asarray(4 * inner - outer) / 3
        # Of fourth order in the step: 1e-16; rounding 1e-15/1e-4 of the largest frequency.
        size = np.asarray(_values(mechanism, jnp.zeros(3)))
        np.testing.assert_allclose(slopes[:, at] / size, difference / size, rtol=0, atol=1e-10)
    weights = np.cos(np.arange(len(slopes)))
    pulled = _pulled_back(mechanism, jnp.asarray(weights))
    np.testing.assert_allclose(pulled, weights @ slopes, rtol=1e-12)


def test_contacts_have_their_tangent_stiffness():
    """3/2 of the secant one of a Hertz contact; the argument `load` sets it."""
    mechanism = _mechanism()
    secant = prsm.compute(mechanism, ["thread_stiffness_screw", "thread_stiffness_nut"])
    threads = ThreadStiffness(*(1.5 * jnp.ravel(value)[0] for value in secant.values()))
    expected = modes_of(system_of(mechanism.stages[0], threads))
    found = _values(mechanism, jnp.zeros(3))
    groups = jnp.concatenate([group.frequencies for group in expected.groups])
    np.testing.assert_allclose(found, groups, rtol=1e-11)


@pytest.mark.parametrize("sticking", [True, False])
def test_a_part_that_is_absent_leaves_no_trace(sticking):
    whole = _mechanism()
    given = example("wu2022")

    def traced(mechanism):
        return prsm.programs.traced_physics(
            lambda m: prsm.spatial_modal(m, sticking=sticking), mechanism
        )

    assert {"meshing", "spatial_system", "hertz"} <= traced(whole)
    found = traced(given)
    # Stiffnesses of threads and gear are given: no contact and no tooth is evaluated.
    assert not found & {"hertz", "gear_mesh_stiffness", "spatial_dense_assembly"}
    assert ("tangential_contact" in found) == sticking
    assert not any(name.startswith("spatial") for name in _of_wus_model(given))


def _of_wus_model(mechanism):
    return prsm.programs.traced_physics(prsm.modal, mechanism)


def test_without_pins_there_is_no_carrier_among_the_coordinates():
    stage = example("wu2022").stages[0]
    system = prsm.vibration.spatial_system(
        stage, ThreadStiffness(jnp.asarray(2e8), jnp.asarray(2e8))
    )
    assert [body.name for body in system.bodies] == ["screw", "nut"]
    assert not any(spring.name.startswith("pin") for spring in system.springs)


def _tilting(mechanism, changes):
    """Distinct frequencies with tilts; contact angle and lengths changed by these shares."""
    angle = prsm.get_parameter(mechanism, "contact_angle")
    moved = prsm.set_parameter(mechanism, "contact_angle", angle * (1 + changes[0]))
    for at, body in enumerate(("roller", "nut"), start=1):
        moved = eqx.tree_at(
            lambda m, body=body: getattr(m.stages[0], body).length,
            moved,
            replace_fn=lambda value, at=at: value * (1 + changes[at]),
        )
    return jnp.concatenate(
        [group.frequencies for group in prsm.spatial_modal(moved, tilt=True).groups]
    )


def test_derivatives_of_tilting_bodies_are_central_differences():
    stage = tilting_stage()
    given = dataclasses.replace(present(stage.stiffness), screw_roller=None, nut_roller=None)
    stage = dataclasses.replace(stage, stiffness=given, curvature="exact")
    mechanism = dataclasses.replace(example("wu2022"), stages=(stage,))
    values = eqx.filter_jit(lambda c: _tilting(mechanism, c))
    weights = jnp.cos(jnp.arange(values(jnp.zeros(3)).shape[0]))
    forward = np.asarray(eqx.filter_jit(jax.jacfwd(lambda c: _tilting(mechanism, c)))(jnp.zeros(3)))
    pulled = eqx.filter_jit(jax.grad(lambda c: weights @ _tilting(mechanism, c)))(jnp.zeros(3))
    np.testing.assert_allclose(pulled, np.asarray(weights) @ forward, rtol=1e-11)
    size, step = np.asarray(values(jnp.zeros(3))), 1e-4
    for at, unit in enumerate(np.eye(3)):
        outer, inner = (
            (np.asarray(values(h * unit)) - np.asarray(values(-h * unit))) / (2 * h)
            for h in (2 * step, step)
        )
        # Of fourth order in the step: 1e-16; rounding 1e-15/1e-4 of the largest frequency.
        difference = (4 * inner - outer) / 3
        np.testing.assert_allclose(forward[:, at] / size, difference / size, rtol=0, atol=1e-10)
    assert np.abs(forward / size[:, None]).max(axis=0).min() > 0.1
