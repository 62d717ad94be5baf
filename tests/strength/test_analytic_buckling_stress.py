"""A buckling load by Euler that no steel carries: what is said of it, and where."""

import dataclasses
import math

import equinox as eqx
import jax.numpy as jnp
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax.dimensioning import dimension
from prsm_jax.strength import buckling_load, buckling_stress, slenderness_ratio
from tests.present import present

_MODULUS, _ROOT = 210e9, 11.5e-3


def _screw(stress: float | None, yield_strength: float | None = None):
    """The actuator with a loaded length at which Euler's stress is `stress` [Pa]."""
    mechanism = example("actuator")
    stage = mechanism.stages[0]
    strength = present(stage.strength)
    shaft = present(strength.shaft)
    shaft = dataclasses.replace(shaft, root_radius=_ROOT, yield_strength=yield_strength)
    if stress is not None:
        slenderness = math.pi * math.sqrt(_MODULUS / stress)
        # Fixed at one end, supported at the other; a tube with the bore of the example, 8 mm wide.
        length = slenderness * math.hypot(_ROOT, 4e-3) / 2 / 0.699155659
        shaft = dataclasses.replace(shaft, loaded_length=length)
    stage = dataclasses.replace(stage, strength=dataclasses.replace(strength, shaft=shaft))
    return dataclasses.replace(mechanism, stages=(stage,))


def _named(mechanism):
    return [one for one in prsm.check(mechanism) if one.name == "buckling_stress"]


@pytest.mark.parametrize(("megapascals", "count"), [(440.0, 0), (460.0, 1), (5650.0, 1)])
def test_a_short_screw_without_a_yield_strength_is_named(megapascals, count):
    mechanism = _screw(1e6 * megapascals)
    stage = mechanism.stages[0]
    # The factor of the end conditions to nine digits.
    assert float(buckling_stress(stage)) == pytest.approx(1e6 * megapascals, rel=1e-8)
    findings = _named(mechanism)
    assert len(findings) == count
    for one in findings:
        assert one.severity == "warning"
        assert (one.value, one.limit) == (pytest.approx(1e6 * megapascals, rel=1e-8), 450e6)
        assert f"is {megapascals:.4g} MPa" in one.message
        assert "yield_strength" in one.message
    assert not _named(_screw(1e6 * megapascals, 900e6))


@pytest.mark.parametrize("quantity", ["buckling_load", "buckling_safety"])
def test_eulers_load_is_an_assumption_where_no_yield_strength_is_given(quantity):
    (sentence,) = [one for one in prsm.assumptions(_screw(None), [quantity]) if "Euler" in one]
    assert "yield strength" in sentence
    assert not any("Euler" in one for one in prsm.assumptions(_screw(None, 900e6), [quantity]))


def test_the_first_design_has_a_yield_strength():
    """A short stiff screw, for which Euler alone is six times higher."""
    found = dimension(10e3, 50e-3, 0.1, 1.8e6, 60e-3)
    mechanism = found.mechanism
    assert mechanism is not None
    stage = mechanism.stages[0]
    shaft = present(present(stage.strength).shaft)
    assert float(present(shaft.yield_strength)) == 900e6
    assert not _named(mechanism)
    # A choice that only a preload gives a meaning.
    assert "arrangement" not in prsm.file.dumps(mechanism)
    load = float(buckling_load(stage))
    area = math.pi * float(present(shaft.root_radius)) ** 2
    without = eqx.tree_at(lambda s: s.strength.shaft.yield_strength, stage, jnp.asarray(1e30))
    euler = (math.pi**2 * 210e9 * area) / float(slenderness_ratio(without)) ** 2
    assert load == pytest.approx(area * 900e6 * (1 - area * 900e6 / (4 * euler)), rel=1e-12)
    assert found.margins["buckling"] == pytest.approx(load / 20e3, rel=1e-9)
    assert euler > 6 * load
