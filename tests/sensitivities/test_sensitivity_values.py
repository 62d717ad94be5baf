"""Sensitivities against closed forms and central differences."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax.mechanism import find_parameters, follows_in_words
from prsm_jax.sensitivities import sensitivity

PARAMETERS = ("lead", "contact_angle", "roller_radius")
QUANTITIES = ("efficiency", "max_pressure", "axial_stiffness")


@functools.cache
def mechanism():
    return scenes.mechanism()


@eqx.filter_jit
def values_at(given, moved):
    for name, value in moved.items():
        given = prsm.set_parameter(given, name, value)
    found = prsm.compute(given, QUANTITIES)
    return jnp.stack([found[name] for name in QUANTITIES])


def test_elasticities_of_hertz_theory():
    """p₀ ∝ (F E*²/z)^{1/3} and δ ∝ (F²/E*²)^{1/3}: exponents, hence exact elasticities."""
    table = sensitivity(
        mechanism(),
        ["max_pressure", "approach_screw"],
        ["operating_point.load", "youngs_modulus", "engaged_threads"],
    )
    expected = [[1 / 3, 2 / 3, -1 / 3], [2 / 3, -2 / 3, -2 / 3]]
    np.testing.assert_allclose(table.elasticity, expected, rtol=1e-12)
    assert table.quantities == ("max_pressure", "approach_screw[1]")


def test_gradients_of_dimensions():
    """r_n = n r_R and v = Ω L / 2π, in SI."""
    table = sensitivity(mechanism(), ["nut_radius", "nut_speed"], ["roller_radius", "lead"])
    np.testing.assert_allclose(table.gradient, [[5, 0], [0, 100 / (2 * np.pi)]], rtol=1e-13)
    np.testing.assert_allclose(table["nut_speed", "lead"], 100 / (2 * np.pi), rtol=1e-13)


@pytest.mark.parametrize("mode", ["forward", "reverse"])
def test_gradients_against_central_differences(mode):
    table = sensitivity(mechanism(), QUANTITIES, PARAMETERS, mode=mode)
    for column, name in enumerate(PARAMETERS):
        centre = np.asarray(prsm.get_parameter(mechanism(), name))
        # Richardson from two steps: truncation h⁴ ~ 1e-12 and rounding 1e-16/h ~ 1e-12.
        differences = []
        for step in (1e-3, 5e-4):
            ends = [
                values_at(mechanism(), {name: scenes.array(centre * (1 + sign * step))})
                for sign in (1, -1)
            ]
            differences.append((ends[0] - ends[1]) / (2 * step * centre))
        reference = (4 * differences[1] - differences[0]) / 3
        # Relative to a value's own scale, because the pressure hardly feels the lead.
        scale = np.abs(reference) + 1e-3 * np.abs(np.asarray(table.values)) / centre
        error = np.abs(np.asarray(table.gradient)[:, column] - reference) / scale
        assert error.max() < 1e-7, (name, error)


@pytest.mark.parametrize("mode", ["forward", "reverse"])
def test_nothing_is_differentiated_by_numbers_that_stay(mode):
    """A derivative by them would be compiled, and then be multiplied by 0."""

    @jax.custom_jvp
    def without_derivative(number):
        return number**2

    @without_derivative.defjvp
    def _(*_):
        raise AssertionError("differentiated by a number that stays")

    def own(mechanism):
        stage = mechanism.stages[0]
        return stage.thread.lead * without_derivative(stage.material.youngs_modulus)

    table = sensitivity(mechanism(), [own], ["lead"], mode=mode)
    np.testing.assert_allclose(table.elasticity, [[1.0]], rtol=1e-13)
    with pytest.raises(AssertionError, match="number that stays"):
        sensitivity(mechanism(), [own], ["lead", "youngs_modulus"], mode=mode)


def test_stages_move_together():
    """Without a stage number all stages move by equal amounts: gradients add up."""
    two = scenes.mechanism(
        scenes.stage(), scenes.stage(geometry=scenes.thread(roller_radius=3e-3, lead=6e-3))
    )
    table = sensitivity(two, ["nut_speed", "nut_radius"], ["lead", "stage.2.lead", "roller_radius"])
    rate = 100 / (2 * np.pi)
    np.testing.assert_allclose(
        table.gradient, [[2 * rate, rate, 0], [0, 0, 5], [0, 0, 5]], rtol=1e-13
    )
    # One per cent in both stages is one per cent of their sum.
    np.testing.assert_allclose(table.elasticity[0], [1, 6 / 16, 0], rtol=1e-13)
    assert [values.shape for values in table.parameter_values] == [(2,), (1,), (2,)]


def test_parameters_do_not_disturb_each_other(own_quantities):
    """ρ = r_R / cos λ follows the contact angle, also with ρ itself in the list."""
    own_quantities("profile_radius", lambda a: a.mechanism.stages[0].thread.profile_radius)
    angle, radius = np.pi / 4, 4e-3
    following = radius * np.sin(angle) / np.cos(angle) ** 2
    for mode in ("forward", "reverse"):
        both = sensitivity(
            mechanism(), ["profile_radius"], ["contact_angle", "roller_profile_radius"], mode=mode
        )
        np.testing.assert_allclose(both.gradient, [[following, 1.0]], rtol=1e-13)
    # Where the mechanism gives it, it does not follow.
    given = prsm.set_parameter(mechanism(), "roller_profile_radius", 5e-3)
    fixed = sensitivity(given, ["profile_radius"], ["contact_angle", "roller_profile_radius"])
    np.testing.assert_array_equal(fixed.gradient, [[0.0, 1.0]])


def test_inside_jit_vmap_and_grad():
    leads = jnp.asarray([8e-3, 10e-3])

    @jax.jit
    def elasticity(lead):
        moved = prsm.set_parameter(mechanism(), "lead", lead)
        return sensitivity(moved, ["screw_helix_angle"], ["lead"]).elasticity[0, 0]

    def closed(lead):  # λ = arctan(t), t = L/(2π r_s): (L/λ) dλ/dL = t/((1 + t²) arctan t)
        slope = lead / (2 * jnp.pi * 12e-3)
        return slope / ((1 + slope**2) * jnp.arctan(slope))

    np.testing.assert_allclose(jax.vmap(elasticity)(leads), closed(leads), rtol=1e-12)
    for lead in leads:
        np.testing.assert_allclose(jax.grad(elasticity)(lead), jax.grad(closed)(lead), rtol=1e-10)


def test_default_quantities_are_those_with_data():
    bare = scenes.mechanism(scenes.stage(material=None))
    table = sensitivity(bare, None, ["lead"])
    assert table.quantities == ("efficiency", "drive_torque")
    assert bool(table.valid)


def test_a_quantity_without_value_has_no_elasticity(own_quantities):
    own_quantities("sensitivity_zero", lambda a: 0.0 * a.mechanism.stages[0].thread.lead)
    table = sensitivity(mechanism(), ["sensitivity_zero"], ["lead"])
    assert not table.elasticity_defined[0]
    assert table.elasticity[0, 0] == 0
    assert table.to_dict()["elasticity"] == [[None]]
    assert "–" in str(table)


def test_prints_and_plain_numbers():
    table = sensitivity(mechanism(), ["nut_radius", "nut_speed"], ["roller_radius", "lead"])
    text = str(table)
    assert "nut_speed [mm/s]" in text
    assert "per mm of lead" in text
    plain = table.to_dict()
    assert {"quantities", "parameters", "gradient", "elasticity"} <= set(plain)
    assert plain["gradient"][0][0] == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("quantities", "parameters", "mode", "words"),
    [
        (["mass"], ["roller_count"], "auto", "whole number"),
        (["mass"], ["leed"], "auto", "did you mean lead"),
        (["massive"], ["lead"], "auto", "unknown quantity 'massive'"),
        (["mass"], [], "auto", "parameters is empty"),
        ([], ["lead"], "auto", "quantities is empty"),
        ("mass", ["lead"], "auto", "give a list"),
        (["mass"], ["lead"], "sideways", "mode is 'sideways'"),
        (["nut_outer_diameter"], ["lead"], "auto", "wall_thickness"),
    ],
)
def test_errors_name_the_thing(unchecked, quantities, parameters, mode, words):
    with pytest.raises(ValueError, match=words):
        sensitivity(mechanism(), quantities, parameters, mode=mode)


def test_a_tie_of_loads_is_a_kink_with_both_derivatives():
    """C/max(F, 18 kN) at F = 18 kN: 0 below, and −C/F² above; half of it is neither."""
    # With equal shares: the share of the most loaded thread changes with the load too.
    actuator = scenes.equal_shares("actuator")
    tied = prsm.set_parameter(actuator, "operating_point.load", 18e3)
    names = ["operating_point.load", "contact_angle"]
    table = sensitivity(tied, ["static_safety"], names)
    ((quantity, parameter, below, above),) = table.kinks
    assert (quantity, parameter) == ("static_safety", "operating_point.load")
    assert below == 0
    # Evaluated a millionth of the load beside the tie.
    capacity = float(table.values[0]) * 18e3
    assert above == pytest.approx(-capacity / (18e3 * (1 + 1e-6)) ** 2, rel=1e-9)
    (found,) = table.to_dict()["kinks"]
    assert (found["below"], found["above"]) == (below, above)
    assert "kink: derivative of static_safety by operating_point.load is 0 per kN below" in str(
        table
    )
    assert not sensitivity(actuator, ["static_safety"], names).kinks
    assert sensitivity(tied, ["static_safety"], names, kinks=False).left is None


@pytest.mark.parametrize("given", [None, 6e-3])
def test_what_follows_is_what_moves(given):
    """The words of every design variable against derivatives of the thread itself."""
    stage = scenes.stage(
        geometry=scenes.thread(roller_profile_radius=given),
        gear=prsm.mechanism.Gear(np.radians(20), roller_teeth=16.0),
    )
    one = scenes.mechanism(stage)
    thread = stage.thread
    numbers = ("lead", "starts", "roller_radius", "contact_angle", "pitch", "screw_radius")
    numbers += ("nut_radius", "centre_distance", "flank_angle", "profile_radius")

    def read(moved):
        found = {name: getattr(moved.stages[0].thread, name) for name in numbers}
        found["roller_profile_radius"] = found.pop("profile_radius")
        return found

    fields = [*numbers[:4], *(v.name for v in prsm.mechanism.DESIGN_VARIABLES), "gear_module"]
    for name in fields:
        value = prsm.get_parameter(one, name)
        _, slopes = jax.jvp(
            lambda v, name=name: read(prsm.set_parameter(one, name, v)),
            (value,),
            (jnp.ones_like(value),),
        )
        follows, stays = prsm.mechanism.what_follows(one, name)
        own = {name, "roller_radius" if name.startswith("roller_radius_at") else name}
        own.add("starts" if name.startswith("starts_at") else name)
        # Zero but for rounding, in units of the number itself.
        scale = {k: abs(float(v)) for k, v in read(one).items()}
        moving = {k for k, s in slopes.items() if abs(float(s)) * float(value) > 1e-12 * scale[k]}
        assert moving - own == set(follows) & set(scale), name
        assert set(scale) - moving - own == set(stays) & set(scale), name
    assert thread.lead == one.stages[0].thread.lead


def test_a_variable_beside_another_follows_nothing():
    """The profile radius follows the roller's, unless the same design sets it too."""
    one = mechanism()
    alone = prsm.mechanism.what_follows(one, "roller_radius")
    beside = prsm.mechanism.what_follows(one, "roller_radius", ("roller_profile_radius",))
    assert set(alone[0]) - set(beside[0]) == {"roller_profile_radius"}
    assert set(beside[1]) - set(alone[1]) == {"roller_profile_radius"}
    words = follows_in_words(one, "roller_radius", ("roller_profile_radius",))
    follow, _, stay = words.partition("; stays: ")
    assert "roller profile radius" in stay
    assert "roller profile radius" not in follow


def test_a_default_follows_whoever_asks():
    """The profile radius that a file does not give moves with the roller, in any list."""
    one = mechanism()
    alone = sensitivity(one, ["axial_stiffness"], ["roller_radius"])
    beside = sensitivity(one, ["axial_stiffness"], ["roller_radius", "roller_profile_radius"])
    np.testing.assert_allclose(
        alone["axial_stiffness", "roller_radius"],
        beside["axial_stiffness", "roller_radius"],
        rtol=1e-9,
    )
    frozen = prsm.set_parameter(one, "roller_profile_radius", one.stages[0].thread.profile_radius)
    fixed = sensitivity(frozen, ["axial_stiffness"], ["roller_radius"])
    ratio = fixed["axial_stiffness", "roller_radius"] / alone["axial_stiffness", "roller_radius"]
    assert not 0.9 < float(ratio) < 1.1
    assert "roller_profile_radius" in alone.to_dict()["follows"]["roller_radius"]
    assert "roller_profile_radius" in fixed.to_dict()["stays"]["roller_radius"]
    words = (
        "roller_radius: moves with it: screw radius, nut radius, centre distance, roller profile"
    )
    assert words in str(alone)


def test_a_name_without_a_number_means_all_stages():
    """With the word `stage` before it or without; with a number one of them."""
    one = scenes.stage()
    two = scenes.mechanism(one, one)
    both = {"stage.1.thread.lead", "stage.2.thread.lead"}
    for name, paths in (
        ("lead", both),
        ("thread.lead", both),
        ("stage.thread.lead", both),
        ("stage.2.lead", {"stage.2.thread.lead"}),
        ("stage.1.thread.lead", {"stage.1.thread.lead"}),
    ):
        assert {found.path for found in find_parameters(two, name)} == paths, name
    with pytest.raises(prsm.UnknownNameError, match=r"has 2 stage\(s\)"):
        find_parameters(two, "stage.3.lead")
    with pytest.raises(prsm.UnknownNameError, match="unknown parameter"):
        find_parameters(two, "screw.1.lead")
