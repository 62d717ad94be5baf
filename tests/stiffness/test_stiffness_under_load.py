"""Thread stiffness under a load: of either sign, given, and what is said if the load is missing."""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, equal_shares, example

import prsm_jax as prsm
from prsm_jax.stiffness import loaded_threads, stiffness_under_load, thread_stiffness
from tests.present import present


def _under_load(stage, tangent):
    return eqx.filter_jit(
        lambda load: stiffness_under_load(stage, lambda: load, tangent=tangent).screw_roller
    )


@pytest.mark.parametrize("tangent", [False, True])
def test_it_is_that_of_the_loaded_threads_for_either_sign(tangent):
    (stage,) = example("actuator").stages
    contacts = loaded_threads(stage, array(7e3))
    expected = thread_stiffness(stage, lambda: contacts, tangent=tangent).screw_roller
    run = _under_load(stage, tangent)
    for load in (7e3, -7e3):
        assert float(run(array(load))) == pytest.approx(float(expected), rel=1e-13)


def test_worn_flanks_matter_only_for_loads_that_press_them():
    """Wear is of the flanks that a positive load presses; a negative load presses the others."""
    (stage,) = example("actuator").stages
    count = int(present(stage.load_sharing).thread_count)
    sharing = dataclasses.replace(
        present(stage.load_sharing), backlash=array(0.0), split_nut=None, tooth=None
    )
    worn = dataclasses.replace(sharing, nut_wear=1e-6 * jnp.minimum(jnp.arange(1.0 * count), 8.0))
    as_new, run_in = (
        _under_load(dataclasses.replace(stage, load_sharing=one), False) for one in (sharing, worn)
    )
    back, forth = (float(run_in(array(load))) for load in (-12e3, 12e3))
    assert back == pytest.approx(float(as_new(array(-12e3))), rel=1e-9)
    assert abs(forth / back - 1) > 1e-3


def test_frequencies_of_every_verb_are_those_of_the_flanks_that_are_loaded():
    mechanism = example("actuator")
    (stage,) = mechanism.stages
    sharing = present(stage.load_sharing)
    wear = 1e-6 * jnp.minimum(jnp.arange(1.0 * int(sharing.thread_count)), 8.0)
    sharing = dataclasses.replace(sharing, backlash=array(0.0), nut_wear=wear, split_nut=None)
    mechanism = dataclasses.replace(
        mechanism, stages=(dataclasses.replace(stage, load_sharing=sharing),)
    )
    name = "torsional_frequencies"
    for load in (-12e3, 12e3):
        at_load = prsm.set_parameter(mechanism, "load", load)
        groups = prsm.modal(at_load).groups
        (torsional,) = (one.frequencies for one in groups if one.family == "torsional")
        computed = prsm.compute(mechanism, [name], load=load)[name]
        np.testing.assert_allclose(torsional, computed, rtol=1e-12)


def test_of_equal_shares_it_grows_with_the_cube_root_of_the_load():
    """Hertz: F ∝ δ^{3/2}, so the tangent stiffness is 3/2 of the secant one."""
    (stage,) = equal_shares("actuator").stages
    secant, tangent = (_under_load(stage, tangent) for tangent in (False, True))
    one, eight = (float(secant(array(load))) for load in (2e3, -16e3))
    assert eight == pytest.approx(2 * one, rel=1e-12)
    assert float(tangent(array(2e3))) == pytest.approx(1.5 * one, rel=1e-12)


def test_given_stiffnesses_need_no_load():
    (stage,) = example("wu2022").stages
    found = stiffness_under_load(stage, lambda: pytest.fail("the load was asked for"))
    given = present(stage.stiffness)
    assert float(found.screw_roller) == float(present(given.screw_roller))
    assert float(found.nut_roller) == float(present(given.nut_roller))


@pytest.mark.parametrize("verb", [prsm.modal, prsm.spatial_modal])
def test_a_missing_load_is_named_with_both_remedies(verb):
    unloaded = eqx.tree_at(lambda m: m.operating_point, example("actuator"), None)
    with pytest.raises(prsm.MissingDataError, match="pass load=") as caught:
        verb(unloaded)
    assert str(caught.value).startswith("thread contact stiffness: ")
    assert "give stage.stiffness.screw_roller and stage.stiffness.nut_roller" in str(caught.value)
