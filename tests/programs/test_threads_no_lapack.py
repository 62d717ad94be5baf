"""No program that users can compile calls LAPACK: its batched calls deadlock between threads.

Looked for in the lowered programs, by the target of every custom call. Nothing is compiled.
"""

import dataclasses
import re

import equinox as eqx
import jax
import jax.flatten_util
import jax.numpy as jnp
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.dynamics.solvers import Gradient
from prsm_jax.mechanism import Support, UnequalRoller
from prsm_jax.vibration import directional_derivatives, family_modes
from tests.present import present

#: `stablehlo.custom_call @lapack_dgesdd_ffi(...)`.
_CALL = re.compile(r"custom_call\s+@(\w+)")


def _called(function, *arguments):
    """Targets of the custom calls in a program."""
    return set(_CALL.findall(eqx.filter_jit(function).lower(*arguments).as_text()))


def _unequal(name="wu2022"):
    one = example(name)
    rollers = (UnequalRoller(2, stiffness_factor=0.9), UnequalRoller(5, mass_factor=1.1))
    stage = dataclasses.replace(one.stages[0], unequal_roller=rollers)
    return dataclasses.replace(one, stages=(stage,))


def test_the_test_sees_lapack():
    called = _called(jnp.linalg.svd, jnp.eye(3)) | _called(
        jnp.linalg.solve, jnp.eye(3), jnp.ones(3)
    )
    assert any("gesdd" in target for target in called)
    assert any("getrf" in target for target in called)


@pytest.mark.parametrize("name", file.example_names())
def test_quantities(name):
    """Every quantity of every example."""
    mechanism = example(name)
    names = prsm.quantities.available_quantities(mechanism)
    assert not _called(lambda m: prsm.compute(m, names), mechanism)


@pytest.mark.parametrize(
    ("name", "other"), [("wu2022", None), ("actuator", "wu2022"), ("li2020_two_stage", None)]
)
def test_derivatives_of_quantities(name, other):
    """In both modes, by a parameter that everything depends on.

    Of quantities that another example has too, the derivatives are looked at there.
    """
    mechanism = example(name)
    elsewhere = () if other is None else prsm.quantities.available_quantities(example(other))
    names = prsm.quantities.available_quantities(mechanism)
    names = tuple(one for one in names if one not in elsewhere)

    def values(lead):
        return prsm.compute(prsm.set_parameter(mechanism, "lead", lead), names)

    lead = prsm.get_parameter(mechanism, "lead")
    assert not _called(_both_derivatives(values), lead)


def _both_derivatives(function):
    """`jax.jacfwd` and `jax.jacrev` of a function in one program, traced once for both."""

    def evaluate(at):
        found, push = jax.linearize(function, at)
        pull = jax.linear_transpose(push, at)
        flat, structured = jax.flatten_util.ravel_pytree(found)
        forward = jax.vmap(push)(jnp.ones((1, *at.shape), at.dtype))
        reverse = jax.vmap(lambda one: pull(structured(one)))(jnp.eye(flat.size, dtype=flat.dtype))
        return found, forward, reverse

    return evaluate


def test_a_call_in_only_one_of_the_two_is_seen():
    """LAPACK in the derivative of a function, and in the transpose of its derivative."""

    @jax.custom_jvp
    def in_derivative(x):
        return x

    @in_derivative.defjvp
    def _(given, moved):
        return given[0], moved[0] * jnp.linalg.svd(given[0] * jnp.eye(2), compute_uv=False)[0]

    def in_transpose(x):
        return jax.lax.custom_linear_solve(
            lambda y: 2 * y,
            x,
            lambda _, y: y / 2,
            lambda _, y: y / jnp.linalg.svd(2 * jnp.eye(2), compute_uv=False)[0],
        )

    for function in (in_derivative, in_transpose):
        called = _called(_both_derivatives(function), jnp.asarray(1.0))
        assert any("gesdd" in target for target in called), function


@pytest.mark.parametrize("translating", [False, True])
def test_modes(translating):
    mechanism = _unequal()
    if translating:
        stage = mechanism.stages[0]
        held = Support(radial_stiffness=jnp.asarray(1e9))
        stage = dataclasses.replace(
            stage, roller=dataclasses.replace(stage.roller, support=held), unequal_roller=()
        )
        mechanism = dataclasses.replace(mechanism, stages=(stage,))

    def modes(stiffness):
        moved = prsm.set_parameter(mechanism, "stiffness.screw_roller", stiffness)
        found = prsm.modal(moved, shapes=True)
        family = family_modes(found, "torsional")
        return found.frequencies, found.strain_energy_shares(), family.frequencies

    stiffness = jnp.linspace(1e8, 2e8, 3)
    assert not _called(jax.vmap(modes), stiffness)
    assert not _called(jax.vmap(jax.jacfwd(modes)), stiffness)
    assert not _called(jax.vmap(jax.jacrev(modes)), stiffness)


def test_one_sided_slopes():
    system = prsm.modal(_unequal(), shapes=True).system

    def slopes(at):
        def system_at(t):
            body = dataclasses.replace(
                system.bodies[0], mesh_stiffness=system.bodies[0].mesh_stiffness * (1 + t)
            )
            return dataclasses.replace(present(system), bodies=(body, *system.bodies[1:]))

        return directional_derivatives(system_at, at)

    assert not _called(slopes, jnp.asarray(0.0))


@pytest.mark.parametrize("method", ["auto", "closed_form", "explicit", "implicit", "rosenbrock"])
def test_transients_and_their_derivatives(method):
    two = example("li2020_two_stage")

    def run(load, gradient: Gradient = "forward"):
        scenario = prsm.Scenario(jnp.asarray(100.0), load, jnp.asarray(3e-4), samples=5)
        return prsm.simulate(
            two,
            scenario,
            method=method,
            gradient=gradient,
            throw=False,
        ).efficiency

    load = jnp.asarray(7e3)
    assert not _called(run, load)
    assert not _called(jax.jacfwd(run), load)
    assert not _called(jax.jacrev(lambda x: run(x, "reverse")), load)


@pytest.mark.parametrize("name", ["actuator_mission", "li2021_two_stage"])
def test_scenarios_of_examples(name):
    mechanism = example(name)
    assert not _called(lambda m: prsm.simulate(m, m.scenario, throw=False), mechanism)


def test_responses_and_contacts():
    mechanism, hertz = example("wu2022"), jnp.asarray([100.0, 5e3])
    for method in ("direct", "modal"):
        assert not _called(
            lambda m, method=method: prsm.frequency_response(
                m,
                "screw u",
                "nut u",
                hertz,
                method=method,  # pyright: ignore[reportArgumentType]
            ),
            mechanism,
        )
    assert not _called(prsm.campbell, mechanism)
    shared = example("actuator_load_sharing")
    assert not _called(prsm.load_sharing.load_distribution, shared)
    assert not _called(
        lambda m: prsm.halfspace.flank_contact(m.stages[0], "screw", 100.0, (8, 8)), shared
    )
