"""Parts of programs that are compiled by themselves: the same values and derivatives."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.core import Tracer
from jaxtyping import ArrayLike
from scenes import array, example

import prsm_jax as prsm
from prsm_jax import strength
from prsm_jax.dynamics import all_kinematics, stage_kinematics
from prsm_jax.numerics import apart
from prsm_jax.programs import traced_physics
from tests.present import present


class _Found(eqx.Module):
    value: jax.Array
    large: jax.Array
    count: jax.Array
    words: str


def _function(x, name, *, offset: ArrayLike = 0.0):
    value = jnp.sin(x) * x + offset
    return _Found(value, value > 0.5, jnp.sum(value > 0), f"{name} of {x.shape[0]}")


def _value(x):
    return apart(_function)(x, "a sum", offset=array(0.25)).value


def test_values_flags_and_words_are_those_of_the_function():
    x = jnp.linspace(-1.0, 2.0, 5)
    expected = _function(x, "a sum")
    found = eqx.filter_jit(apart(_function))(x, "a sum")
    assert found.words == expected.words == "a sum of 5"
    np.testing.assert_array_equal(found.large, expected.large)
    assert (found.count, found.count.dtype) == (expected.count, expected.count.dtype)
    np.testing.assert_allclose(found.value, expected.value, rtol=1e-15)


def test_derivatives_are_those_of_the_function():
    """Both modes, second derivatives, and batches, against closed forms."""
    x = jnp.linspace(-1.0, 2.0, 5)
    slope = jnp.diag(jnp.cos(x) * x + jnp.sin(x))
    for jacobian in (jax.jacfwd, jax.jacrev):
        np.testing.assert_allclose(jax.jit(jacobian(_value))(x), slope, rtol=1e-14, atol=1e-15)
    second = jax.jit(jax.hessian(lambda x: jnp.sum(_value(x))))(x)
    np.testing.assert_allclose(
        second, jnp.diag(2 * jnp.cos(x) - jnp.sin(x) * x), rtol=1e-13, atol=1e-14
    )
    many = jnp.stack([x, 2 * x])
    np.testing.assert_allclose(
        jax.jit(jax.vmap(_value))(many), jnp.sin(many) * many + 0.25, rtol=1e-14
    )


def test_the_compiler_does_not_see_through():
    """What it could fuse stays in a call; outside a trace nothing is compiled."""
    x = jnp.linspace(-1.0, 2.0, 5)
    assert " call(" in present(jax.jit(_value).lower(x).compile().as_text())
    seen = []
    apart(lambda x: seen.append(isinstance(x, Tracer)))(x)
    assert seen == [False]


@pytest.mark.parametrize("whole", [False, True])
def test_a_long_function_is_several_calls_or_one(whole):
    def long(x):
        for _ in range(100):
            x = jnp.sin(x) + 0.5
        return x

    jaxpr = jax.make_jaxpr(apart(long, whole=whole))(array(0.5))
    pieces = [one for one in jaxpr.eqns if one.params.get("name") == "piece"]
    assert (len(pieces) == 1) == whole
    assert float(jax.jit(apart(long, whole=whole))(array(0.5))) == pytest.approx(
        float(long(array(0.5))), rel=1e-12
    )


def test_kinematics_of_a_mechanism():
    """Their separate part has the values of each stage by itself."""
    mechanism = example("li2020_two_stage")
    found = eqx.filter_jit(all_kinematics)(mechanism)
    expected = eqx.filter_jit(lambda m: tuple(map(stage_kinematics, m.stages)))(mechanism)
    assert jax.tree.structure(found) == jax.tree.structure(expected)
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14, atol=1e-16)


def _is_program(x) -> bool:
    return hasattr(x, "eqns") or hasattr(x, "jaxpr")


def _outside_of_pieces(jaxpr) -> set[str]:
    """Physics labels of the equations that XLA may fuse with those that use them."""
    names: set[str] = set()
    for equation in jaxpr.eqns:
        for part in str(equation.source_info.name_stack).split("/"):
            if "physics:" in part:
                names.add(part.split("physics:", 1)[1].rstrip(")"))
        if equation.params.get("name") != "piece":
            for inner in jax.tree.leaves(list(equation.params.values()), is_leaf=_is_program):
                if _is_program(inner):
                    names |= _outside_of_pieces(getattr(inner, "jaxpr", inner))
    return names


@pytest.mark.parametrize("verb", [prsm.modal, prsm.spatial_modal])
def test_contacts_are_a_separate_part_of_modes(verb):
    """The Hessian of a frequency compiles in 27 s of processor time, with them inside in 67 s."""
    mechanism = example("actuator")

    def frequency(lead):
        return verb(prsm.set_parameter(mechanism, "lead", lead)).frequencies[-1]

    outside = _outside_of_pieces(jax.make_jaxpr(frequency)(array(10e-3)).jaxpr)
    assert "hertz" in traced_physics(frequency, array(10e-3))
    assert {"torsional_modes", "spatial_modes"} & outside
    assert "hertz" not in outside


@pytest.mark.parametrize("verb", ["steady_state", "compute"])
def test_the_meshing_is_a_separate_part_of_every_verb(verb):
    """Each derivative of a concatenation of results would compute it anew: 34 times the values."""
    mechanism = example("wu2022")

    def efficiency(lead):
        moved = prsm.set_parameter(mechanism, "lead", lead)
        if verb == "compute":
            return prsm.compute(moved, ["efficiency"])["efficiency"]
        return prsm.steady_state(moved).efficiency

    outside = _outside_of_pieces(jax.make_jaxpr(efficiency)(array(10e-3)).jaxpr)
    assert "meshing" in traced_physics(efficiency, array(10e-3))
    assert "steady_state" in outside
    assert "meshing" not in outside


def test_contacts_and_ends_of_flanks_are_separate_parts_of_the_pressure():
    """Its Hessian compiles in 10 s of processor time, with them inside in 22 s."""
    mechanism = example("actuator")

    def pressure(lead):
        moved = prsm.set_parameter(mechanism, "lead", lead)
        return prsm.compute(moved, ["max_pressure"])["max_pressure"]

    outside = _outside_of_pieces(jax.make_jaxpr(pressure)(array(10e-3)).jaxpr)
    traced = traced_physics(pressure, array(10e-3))
    assert {"meshing", "hertz", "flank_ends", "truncation"} <= set(traced)
    assert not {"meshing", "hertz", "flank_ends", "truncation"} & outside


def test_the_law_of_cut_ellipses_is_a_separate_part():
    side = present(present(strength.side_onsets(example("actuator").stages[0]))[0])
    pressure = functools.partial(strength.truncated_pressure, side)
    jaxpr = jax.make_jaxpr(pressure)(array(2e9))
    assert [one.params.get("name") for one in jaxpr.eqns].count("piece") == 1
