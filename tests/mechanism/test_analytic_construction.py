"""Numbers that are set in Python are held to the limits of files; traced ones pass."""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import pytest
import scenes
from scenes import array, example

import prsm_jax as prsm
from prsm_jax.friction import CoulombFriction
from prsm_jax.mechanism import (
    Carrier,
    Gear,
    GivenStiffness,
    LoadSharing,
    Material,
    Nut,
    Roller,
    Screw,
    ScrewShaft,
    SplitNut,
    Strength,
    Support,
    Thread,
    set_parameters,
    stage_at,
)
from tests.present import present


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: scenes.thread(lead=-0.01),
            "Thread: lead is -0.01 m; it must be more than 0 and at most 1 m; numbers in Python "
            "are in metres: 10 mm is 10e-3",
        ),
        (lambda: scenes.thread(lead=10.0), "lead is 10 m; it must be more than 0 and at most 1 m"),
        (
            lambda: scenes.thread(contact_angle=45.0),
            "Thread: contact_angle is 45 rad; it must be between 0 and 90 deg, both excluded; "
            "numbers in Python are in radians: 45 deg is math.radians(45)",
        ),
        (lambda: scenes.thread(starts=2.0), "starts is 2; it must be more than 2"),
        (lambda: scenes.thread(roller_radius=math.inf), "roller_radius is inf m; it must be more"),
        (lambda: Screw(mass=-0.1), "Screw: mass is -0.1 kg; it must be more than 0; give it in kg"),
        (lambda: Roller(inertia=0.0), "Roller: inertia is 0 kg·m²; it must be more than 0"),
        (lambda: Nut(wall_thickness=-1e-3), "Nut: wall_thickness is -0.001 m; it must be more"),
        (lambda: Carrier(mass=-1.0), "Carrier: mass is -1 kg"),
        (lambda: Material(2e11, 0.5), "poisson_ratio is 0.5; it must be between -1 and 0.5"),
        (lambda: Gear(20.0), "pressure_angle is 20 rad; it must be between 0 and 90 deg"),
    ],
)
def test_a_number_out_of_its_range_is_refused(make, words):
    with pytest.raises(ValueError, match=r"it must be") as raised:
        make()
    assert words in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        (
            {"screw": Screw(bore_radius=13e-3)},
            "screw.bore_radius is 0.013 m; it must be less than the screw's nominal radius, 12 mm",
        ),
        ({"roller": Roller(bore_radius=4e-3)}, "roller.bore_radius is 0.004 m; it must be less"),
        ({"carrier": Carrier(radial_width=33e-3)}, "carrier.radial_width is 0.033 m; it must be"),
        (
            {
                "screw": Screw(bore_radius=5e-3),
                "strength": Strength(
                    shaft=ScrewShaft(
                        end_conditions="fixed_fixed", unsupported_length=0.1, root_radius=4e-3
                    )
                ),
            },
            "strength.shaft.root_radius is 0.004 m; it must be more than the screw's bore_radius",
        ),
    ],
)
def test_numbers_that_exclude_each_other_are_refused(parts, words):
    with pytest.raises(ValueError, match=r"it must be") as raised:
        scenes.stage(**parts)
    assert words in str(raised.value)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("lead", -0.01, "lead is -0.01 m; it must be more than 0"),
        ("pitch", 0.0, "pitch is 0 m; it must be more than 0"),
        ("flank_angle", 45.0, "flank_angle is 45 rad; it must be between 0 and 90 deg"),
        ("screw.mass", -1.0, "mass is -1 kg; it must be more than 0"),
        ("roller_count", 0, "roller_count is 0; it must be a whole number from 1 to 1000"),
        # Its bore has 3 mm: the roller grows too small for it.
        ("roller_radius", 2e-3, "roller.bore_radius is 0.003 m; it must be less than the roller's"),
    ],
)
def test_setting_such_a_number_is_refused(name, value, words):
    whole = scenes.mechanism(scenes.stage(roller=Roller(mass=0.03, bore_radius=3e-3)))
    with pytest.raises(ValueError, match=r"it must be") as raised:
        prsm.set_parameter(whole, name, value)
    assert words in str(raised.value)
    if name != "roller_count":
        # For a search that looks at what lies outside.
        moved = prsm.set_parameter(whole, name, value, checked=False)
        assert float(prsm.get_parameter(moved, name)) == pytest.approx(value)


def test_a_negative_stiffness_is_refused_outside_a_trace():
    """As in a file, with and without a limit of its own; `check` reports what a trace comes to."""
    for make in (
        lambda: Support(radial_stiffness=-1e6),
        lambda: GivenStiffness(screw_roller=-1e6),
        lambda: LoadSharing(3, screw_segment_stiffness=-1e6),
        lambda: SplitNut(1, preload=1.0, spacer_stiffness=0.0),
    ):
        with pytest.raises(ValueError, match=r"ness is -?[01].* N/m; it must|screw_roller is -1"):
            make()
    assert float(present(Support(radial_stiffness=0.0).radial_stiffness)) == 0.0
    traced = jax.jit(lambda k: Support(radial_stiffness=k).radial_stiffness)
    assert float(traced(-1e6)) == -1e6


def test_numbers_that_only_fit_together_are_set_together():
    """One after the other the bore would once be wider than the screw."""
    whole = scenes.mechanism(scenes.stage(screw=Screw(mass=0.76, bore_radius=4e-3)))
    moved = set_parameters(whole, {"screw.bore_radius": 13e-3, "roller_radius": 6e-3})
    assert float(present(moved.stages[0].screw.bore_radius)) == 13e-3


def test_traced_and_unknown_numbers_pass():
    """No check inside a trace, nor where a tree is rebuilt; NaN stands for a number to come."""

    def lead_of(value):
        return Thread(value, 5.0, 4e-3, math.pi / 4).lead

    assert float(jax.jit(lead_of)(-0.01)) == -0.01
    assert float(jax.grad(lead_of)(-0.01)) == 1.0
    assert jax.vmap(lead_of)(jnp.array([-0.01, 0.0])).shape == (2,)
    assert jax.eval_shape(lead_of, jax.ShapeDtypeStruct((), float)).shape == ()
    stage = scenes.stage(screw=Screw(mass=0.76, bore_radius=4e-3))
    whole = scenes.mechanism(stage)
    nan = jax.tree.map(lambda leaf: jnp.full_like(leaf, jnp.nan), whole)
    negative = jax.tree.map(jnp.negative, whole)
    assert float(negative.stages[0].thread.lead) < 0
    assert bool(jnp.isnan(nan.stages[0].thread.lead))
    assert eqx.tree_at(lambda t: t.lead, stage.thread, None).lead is None
    assert eqx.filter_eval_shape(lambda m: m, whole).stages[0].thread.lead.shape == ()
    batch = jax.tree.map(lambda leaf: jnp.stack([leaf, -leaf]), whole)
    moved = eqx.filter_vmap(lambda m, v: prsm.set_parameter(m, "lead", v), in_axes=(None, 0))(
        whole, jnp.array([-0.01, 0.01])
    )
    assert moved.stages[0].thread.lead.shape == batch.stages[0].thread.lead.shape == (2,)
    assert math.isnan(float(Thread(math.nan, 5.0, 4e-3, math.pi / 4).lead))


def test_a_stage_by_its_number_counts_from_one():
    two = prsm.load("li2020_two_stage")
    assert stage_at(two, 1) is two.stages[0]
    assert stage_at(two, 2) is two.stages[1]
    for number in (0, 3, -1):
        with pytest.raises(ValueError, match=f"stage is {number}; the mechanism has stages 1 to 2"):
            stage_at(two, number)


@pytest.mark.parametrize("over", [jax.grad, jax.jit, lambda f: lambda n: jax.vmap(f)(n[None])])
def test_a_traced_number_of_rollers_is_refused(over):
    """Its derivative was 0."""

    def of_count(number):
        changed = prsm.set_parameter(example("wu2022"), "roller_count", number)
        return changed.stages[0].thread.lead * changed.stages[0].roller_count

    with pytest.raises(ValueError, match="roller_count is a whole number and part of the structur"):
        over(of_count)(array(7.0))
    assert float(of_count(7)) == 7 * float(example("wu2022").stages[0].thread.lead)


def test_a_part_prints_its_numbers():
    friction = example("wu2022").stages[0].friction
    assert str(present(friction)) == "Friction(thread=CoulombFriction(coefficient=0.05))"
    support = Support(radial_stiffness=2e8, torsional_stiffness=5e7)
    assert str(support) == "Support(radial_stiffness=2e+08, torsional_stiffness=5e+07)"
    assert present(support._repr_html_()) == f"<pre>{support}</pre>"
    batch = jax.vmap(lambda mu: CoulombFriction(mu))(jnp.asarray([0.05, 0.06]))
    assert str(batch) == "CoulombFriction(coefficient=[0.05, 0.06])"
    many = jax.vmap(lambda mu: CoulombFriction(mu))(jnp.linspace(0.05, 0.06, 99))
    assert str(many) == "CoulombFriction(coefficient=f64[99])"
    told = []
    jax.jit(lambda mu: told.append(str(CoulombFriction(mu))))(array(0.06))
    assert told == ["CoulombFriction(coefficient=f64[])"]
