"""What numbers rest on: sentences that follow the file, and the finding on equal sharing."""

import dataclasses
import math

import equinox as eqx
import jax.numpy as jnp
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.quantities import assumption, quantity
from tests.present import present

EQUAL = "All engaged threads of all rollers carry the same load"
#: Quantities of the design actuator that change where threads share for real, or would if they
#: looked: found by hand in the definitions, not from the declarations under test.
REST_ON_SHARES = (
    "max_pressure",
    "max_von_mises_screw",
    "approach_nut",
    "axial_stiffness",
    "natural_frequencies",
    "lowest_torsional_frequency",
    "static_capacity",
    "static_safety",
    "permanent_deformation",
    "dynamic_capacity",
    "rating_life",
    "life_ratio",
    "duty_cycle_damage",
    "minimum_oscillation_amplitude",
    "lost_motion",
    "efficiency",
    "loss_spin",
)
REST_ON_NOTHING = (
    "screw_radius",
    "roller_clearance",
    "buckling_load",
    "axial_backlash",
    "dn_value",
)


def _design(**changes):
    """The actuator without a word on sharing, and what is changed in its stage."""
    mechanism = example("actuator")
    stage = dataclasses.replace(mechanism.stages[0], **({"load_sharing": None} | changes))
    return dataclasses.replace(mechanism, stages=(stage,))


def _equal(mechanism, *names):
    return [one for one in prsm.assumptions(mechanism, names) if EQUAL in one]


@pytest.mark.parametrize("name", ["max_pressure_shared", "thread_sharing_factor_nut"])
def test_computed_loads_rest_on_rollers_that_are_held(name):
    mechanism = example("actuator")
    (stage,) = mechanism.stages
    assert stage.load_sharing is not None
    words = "rollers neither lean nor bend"
    assert any(words in one for one in prsm.assumptions(mechanism, [name]))
    sharing = dataclasses.replace(stage.load_sharing, roller_bending=prsm.mechanism.RollerBending())
    free = dataclasses.replace(stage, load_sharing=sharing)
    found = prsm.assumptions(dataclasses.replace(mechanism, stages=(free,)), [name])
    assert not any(words in one for one in found)
    assert not any(words in one for one in prsm.assumptions(mechanism, ["screw_radius"]))


@pytest.mark.parametrize("name", REST_ON_SHARES)
def test_what_rests_on_equal_shares_says_so(name):
    (sentence,) = _equal(_design(), name)
    assert "[stage.load_sharing]" in sentence
    assert "in reality" in sentence


@pytest.mark.parametrize("name", REST_ON_NOTHING)
def test_what_does_not_rest_on_shares_is_silent(name):
    assert prsm.assumptions(_design(), [name]) == ()


def test_equal_by_name_keeps_the_sentence_and_says_why():
    (sentence,) = _equal(_design(sharing="equal"), "max_pressure", "rating_life")
    assert 'sharing = "equal"' in sentence
    assert "since the file has no" not in sentence


def test_given_capacities_and_stiffnesses_assume_nothing():
    given = dataclasses.replace(
        present(_design().stages[0].strength), static_capacity=1e5, dynamic_capacity=6e4
    )
    mechanism = _design(strength=given)
    assert prsm.assumptions(mechanism, ["static_safety", "rating_life"]) == ()
    assert prsm.assumptions(example("wu2022"), ["natural_frequencies", "axial_stiffness"]) == ()
    assert _equal(example("wu2022"), "max_pressure")


@pytest.mark.parametrize("name", ["static_capacity", "static_safety"])
def test_a_static_capacity_names_the_load_under_which_threads_share(name):
    words = "under the largest load of the file"
    (sentence,) = [x for x in prsm.assumptions(example("actuator"), [name]) if words in x]
    assert "compute the capacity at a load near it" in sentence
    assert not any(words in one for one in prsm.assumptions(_design(), [name]))


def test_real_sharing_leaves_only_what_still_counts_the_mean_thread():
    mechanism = example("actuator_load_sharing")
    (of_secant,) = prsm.assumptions(mechanism, ["axial_stiffness"])
    assert "see nut_axial_stiffness_secant" in of_secant
    assert not _equal(mechanism, "max_pressure_shared")
    found = prsm.assumptions(mechanism, ["max_pressure"])
    of_mean, of_preload, of_load = [one for one in found if "contact ellipse" not in one]
    assert "mean thread load" in of_mean
    assert "max_pressure_shared" in of_mean
    assert "without the preload" in of_preload
    assert "without thread friction" in of_load
    # No friction of the contacts is modelled there.
    (of_friction,) = prsm.assumptions(mechanism, ["efficiency"])
    assert "its drag torque is preload_torque" in of_friction


@pytest.mark.parametrize("name", ["actuator_tolerances", "actuator_load_sharing"])
def test_numbers_that_do_not_follow_a_preload_say_so(name):
    """By changing the preload: a quantity with a sentence on it stays, one without one follows."""
    mechanism = example(name)
    at = "play.preload_force" if name == "actuator_tolerances" else "split_nut.preload"
    more = prsm.set_parameter(mechanism, at, 1.2 * float(prsm.get_parameter(mechanism, at)))
    names = [
        *("max_pressure", "max_von_mises_screw", "thread_stiffness_nut", "drive_torque"),
        *("contact_axial_stiffness_tangent", "static_safety", "lost_motion", "preload_torque"),
    ]
    names += ["max_pressure_shared"]
    names = [one for one in names if one in prsm.quantities.available_quantities(mechanism, names)]
    assert len(names) >= 6
    before, after = (prsm.compute(one, names) for one in (mechanism, more))
    for one in names:
        told = [x for x in prsm.assumptions(mechanism, [one]) if "without the preload" in x]
        told += [x for x in prsm.assumptions(mechanism, [one]) if "without its preload" in x]
        stays = bool(jnp.all(jnp.asarray(before[one]) == jnp.asarray(after[one])))
        assert bool(told) == stays, one


def test_the_secant_of_a_split_nut_is_said_to_be_no_load_over_travel():
    """With rigid shafts the travel of the nut is that of its contacts, and F/x is larger."""
    split = example("actuator_load_sharing")
    sharing = present(split.stages[0].load_sharing)
    rigid = {f"{body}_segment_stiffness": jnp.asarray(1e15) for body in ("screw", "roller", "nut")}
    stage = dataclasses.replace(split.stages[0], load_sharing=dataclasses.replace(sharing, **rigid))
    rigid_shafts = dataclasses.replace(split, stages=(stage,))
    names = ["contact_axial_stiffness_secant", "nut_axial_stiffness_secant"]
    contacts, nut = prsm.compute(rigid_shafts, names).values()
    assert float(nut) > 1.5 * float(contacts)
    words = "not the load over the travel"
    assert [words in one for one in prsm.assumptions(split, names[:1])].count(True) == 1
    assert not any(words in one for one in prsm.assumptions(split, names[1:]))
    assert not any(words in one for one in prsm.assumptions(example("actuator"), names))


@pytest.mark.parametrize("name", ["recirculating_stage", "actuator_tolerances"])
def test_contacts_that_do_not_follow_thread_friction_say_so(name):
    """By changing the coefficient: forces of the steady state follow it, single contacts do not."""
    mechanism = example(name)
    at = "friction.thread.coefficient"
    more = prsm.set_parameter(mechanism, at, 1.2 * float(prsm.get_parameter(mechanism, at)))
    names = [
        *("max_pressure", "max_pressure_nut", "approach_screw", "semi_major_screw"),
        *("max_shear_stress_nut", "max_pressure_shared", "preloaded_pressure", "contact_force"),
    ]
    names = prsm.quantities.available_quantities(mechanism, names)
    assert len(names) >= 6
    before, after = (prsm.compute(one, names) for one in (mechanism, more))
    for one in names:
        told = [x for x in prsm.assumptions(mechanism, [one]) if "without thread friction" in x]
        stays = bool(jnp.all(jnp.asarray(before[one]) == jnp.asarray(after[one])))
        assert len(told) == stays, one
    every = [x for x in prsm.assumptions(mechanism) if "without thread friction" in x]
    assert len(every) == 1
    stages = tuple(dataclasses.replace(one, friction=None) for one in mechanism.stages)
    bare = dataclasses.replace(mechanism, stages=stages)
    assert not [x for x in prsm.assumptions(bare) if "without thread friction" in x]


def test_friction_raises_the_force_while_driving_and_lowers_it_while_driven():
    """As the sentence says: one roller of eight carries 500 N along the axis, 707 N normal."""
    mechanism = example("recirculating_stage")
    driving, driven = (
        prsm.steady_state(prsm.set_parameter(mechanism, "load", load)) for load in (4e3, -4e3)
    )
    lead, radius = (
        1e3 * float(x)
        for x in (mechanism.stages[0].thread.lead, mechanism.stages[0].thread.screw_radius)
    )
    normal = 4e3 / 8 * (2 + (lead / (2 * math.pi * radius)) ** 2) ** 0.5
    assert float(driven.contact_force[0]) < normal < float(driving.contact_force[0])
    (sentence,) = (
        x for x in prsm.assumptions(mechanism, ["max_pressure"]) if "without thread friction" in x
    )
    assert (
        "raises the normal force where rollers slide while the body that turns drives" in sentence
    )


def test_all_quantities_at_once_and_each_sentence_once():
    found = prsm.assumptions(_design())
    assert len(set(found)) == len(found)
    assert set(found) >= set(prsm.assumptions(_design(), REST_ON_SHARES))
    assert prsm.assumptions(_design(), ["rating_life[1]"]) == prsm.assumptions(
        _design(), ["rating_life"]
    )
    with pytest.raises(prsm.UnknownNameError, match="max_pressure"):
        prsm.assumptions(_design(), ["max_presure"])


def test_a_stage_that_differs_is_named():
    single = example("actuator_load_sharing").stages[0]
    alone = dataclasses.replace(single, load_sharing=None)
    (sentence,) = _equal(prsm.Mechanism((single, alone)), "axial_stiffness")
    assert sentence.startswith("Stage 2: All engaged threads")


def test_nothing_is_evaluated():
    """Only what a mechanism consists of counts, so a batch has the same assumptions."""
    batch = eqx.filter_vmap(lambda lead: prsm.set_parameter(_design(), "lead", lead))
    leads = jnp.asarray([9e-3, 1e-2])
    assert prsm.assumptions(batch(leads)) == prsm.assumptions(_design())


def test_a_quantity_of_ones_own_names_what_it_assumes():
    with pytest.raises(ValueError, match="unknown assumption 'equal_contact'"):
        quantity("own", "x", "1", "own", assumes=("equal_contact",))
    with pytest.raises(ValueError, match="exists already"):
        assumption("equal_contacts")(lambda stage: None)


def _finding(mechanism):
    return {one.name: one for one in prsm.check(mechanism)}.get("equal_sharing")


def test_the_finding_warns_where_strength_rests_on_equal_shares():
    found = _finding(_design())
    assert found.severity == "warning"
    assert found.value == 20
    assert "thread_count = 20" in found.message
    assert 'sharing = "equal"' in found.message


def test_the_finding_is_a_note_without_strength_and_limits():
    mechanism = dataclasses.replace(_design(strength=None), design_problem=None)
    assert _finding(mechanism).severity == "note"
    problem = prsm.mechanism.DesignProblem(
        (prsm.mechanism.Variable("lead", 5e-3, 2e-2),),
        (prsm.mechanism.Objective("efficiency", "maximise"),),
        (prsm.mechanism.Constraint("max_pressure", upper=2e9),),
    )
    limited = dataclasses.replace(mechanism, design_problem=problem)
    assert _finding(limited).severity == "warning"


def test_what_silences_the_finding():
    assert _finding(_design(sharing="equal")) is None
    assert _finding(_design(engaged_threads=None)) is None
    assert _finding(_design(engaged_threads=1.0)) is None
    assert _finding(example("actuator_load_sharing")) is None


def test_sharing_in_a_file():
    text = file.dumps(_design(sharing="equal"))
    assert 'sharing = "equal"' in text
    assert file.loads(text).stages[0].sharing == "equal"
    assert "sharing" not in file.dumps(_design())
    with pytest.raises(prsm.FileError, match=r'choose one of .*"equal"'):
        file.loads(text.replace('sharing = "equal"', 'sharing = "even"'))


def test_equal_beside_a_table_is_a_contradiction():
    stage = dataclasses.replace(example("actuator_load_sharing").stages[0], sharing="equal")
    found = _finding(prsm.Mechanism((stage,), example("actuator_load_sharing").operating_point))
    assert found.severity == "warning"
    assert "remove one" in found.message


@pytest.mark.parametrize("name", ["natural_frequencies", "lowest_critical_speed"])
def test_modes_of_stages_say_that_they_leave_out_the_axis(name):
    """The axis has a mode at 117.9 Hz; the stages alone have none below 983 Hz."""
    words, mechanism = "leave out [axis]", example("actuator_axis")
    (said,) = (one for one in prsm.assumptions(mechanism, [name]) if words in one)
    assert "--spatial" in said
    for silent in ("first_axial_frequency", "efficiency"):
        assert not any(words in one for one in prsm.assumptions(mechanism, [silent]))
    empty = dataclasses.replace(present(mechanism.axis), motor=None, shaft=None, load=None)
    for axis in (None, empty):
        rigid = dataclasses.replace(mechanism, axis=axis)
        assert not any(words in one for one in prsm.assumptions(rigid, [name]))
