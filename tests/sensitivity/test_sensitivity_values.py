"""Sensitivities against closed forms and central differences."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax.sensitivity import sensitivity

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


@pytest.mark.slow
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
