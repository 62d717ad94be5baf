"""Derivatives of sweeps: each name alone, in all stages by equal amounts, whatever else is named.

Expected numbers are central differences of single designs, and the closed form of the nut's speed
v = ω n p / 2π with n starts of pitch p.
"""

import functools

import numpy as np
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax.studies._map import at_designs
from prsm_jax.studies._problem import problem_of
from prsm_jax.sweeps import sweep

SPEED = 100.0
LEADS = (5e-3, 15e-3)


@functools.cache
def unequal_stages():
    mechanism = prsm.load("li2021_two_stage")
    for stage, lead in enumerate(LEADS, start=1):
        mechanism = prsm.set_parameter(mechanism, f"stage.{stage}.thread.lead", lead)
    return mechanism


def _efficiency(*leads):
    mechanism = unequal_stages()
    for stage, lead in enumerate(leads, start=1):
        mechanism = prsm.set_parameter(mechanism, f"stage.{stage}.thread.lead", lead)
    return float(prsm.compute(mechanism, ["efficiency"], load=5e3)["efficiency"])


def test_stages_keep_their_own_values():
    axes = {"operating_point.load": [5e3]}
    names = ["lead", "stage.1.thread.lead", "stage.2.thread.lead"]
    data = sweep(unequal_stages(), axes, ["efficiency"], gradients=names, findings=False)
    step, (first, second) = 1e-7, LEADS
    sides = [
        ((first + d * step, second + e * step), (first - d * step, second - e * step))
        for d, e in ((1, 1), (1, 0), (0, 1))
    ]
    expected = [(_efficiency(*a) - _efficiency(*b)) / (2 * step) for a, b in sides]
    found = [data[f"efficiency_by_{name}"].item() for name in names]
    # Truncation (1e-7/5e-3)², rounding 1e-16/(1e-7 · 5e-3) of the derivative.
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    assert found[0] == pytest.approx(found[1] + found[2], rel=1e-12)


@pytest.mark.parametrize(
    "names",
    [
        ["lead"],
        ["pitch"],
        ["lead", "pitch"],
        ["pitch", "lead", "starts"],
        ["starts", "starts_at_fixed_pitch", "pitch"],
    ],
)
def test_names_do_not_change_each_other(names):
    mechanism = scenes.mechanism()
    thread = mechanism.stages[0].thread
    starts, pitch = float(thread.starts), float(thread.pitch)
    axes = {"operating_point.load": [5e3, 9e3]}
    data = sweep(mechanism, axes, ["nut_speed"], gradients=names, speed=SPEED, findings=False)
    per_lead = SPEED / (2 * np.pi)
    expected = {
        "lead": per_lead,
        "pitch": per_lead * starts,
        # At a fixed lead, as `sensitivity` defines it.
        "starts": 0.0,
        "starts_at_fixed_pitch": per_lead * pitch,
    }
    for name in names:
        np.testing.assert_allclose(data[f"nut_speed_by_{name}"], expected[name], rtol=1e-13)


def test_a_radius_that_follows_follows_also_where_it_is_named():
    """The profile radius is r_R / sin α unless it is given; α then moves it."""
    mechanism = scenes.mechanism()
    axes = {"operating_point.load": [5e3]}
    names = ["contact_angle", "roller_profile_radius"]
    both = sweep(mechanism, axes, ["max_pressure"], gradients=names, findings=False)
    angle = float(mechanism.stages[0].thread.contact_angle)
    step = 1e-5
    near = [
        prsm.compute(
            prsm.set_parameter(mechanism, "contact_angle", angle + sign * step),
            ["max_pressure"],
            load=5e3,
        )["max_pressure"]
        for sign in (-1, 1)
    ]
    expected = (np.asarray(near[1]) - np.asarray(near[0])) / (2 * step)
    found = both["max_pressure_by_contact_angle"][0].values
    # Truncation (1e-5)², rounding 1e-16/1e-5.
    np.testing.assert_allclose(found, expected, rtol=1e-7)


def test_axes_that_are_held_give_the_slope_along_an_axis():
    axes = {"starts": [5.0, 6.0], "pitch": [2e-3, 3e-3]}
    found = {
        held: sweep(
            scenes.mechanism(),
            axes,
            ["nut_speed"],
            gradients=list(axes),
            speed=SPEED,
            findings=False,
            hold_axes=held,
        )
        for held in (False, True)
    }
    per_lead = SPEED / (2 * np.pi)
    starts, pitch = np.array(axes["starts"])[:, None], np.array(axes["pitch"])[None, :]
    both = np.ones((2, 2))
    for held, data in found.items():
        # Axes are set in their order, not in that of their letters.
        values = data["nut_speed"].values.reshape(2, 2)
        np.testing.assert_allclose(values, per_lead * starts * pitch, rtol=1e-13)
        slope = data["nut_speed_by_starts"].values.reshape(2, 2)
        # At a fixed lead the number of starts has no influence.
        expected = per_lead * pitch * both if held else 0.0 * both
        np.testing.assert_allclose(slope, expected, rtol=1e-13, atol=1e-13)
        along = data["nut_speed_by_pitch"].values.reshape(2, 2)
        np.testing.assert_allclose(along, per_lead * starts * both, rtol=1e-13)


def test_a_study_holds_its_other_drivers():
    """v = ω n p / 2π: an elasticity of 1 by either driver."""
    ranges = {"starts": (4.0, 6.0), "pitch": (2e-3, 3e-3)}
    senses = {"nut_speed": "maximise", "efficiency": "maximise"}
    mechanism = scenes.mechanism()
    problem = problem_of(mechanism, ranges, senses, None, ())
    designs = at_designs(mechanism, problem, [{"starts": 5.0, "pitch": 2e-3}], ["nut_speed"])
    np.testing.assert_allclose(designs.elasticities["nut_speed"], [[1.0, 1.0]], rtol=1e-12)
