"""The dynamic capacity by the formula of ball screws, against arithmetic of the test itself."""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import mechanism, stage, thread

import prsm_jax as prsm
from prsm_jax import strength
from prsm_jax.findings._truncation import _taken
from prsm_jax.mechanism import AxialPlay, Strength

FACTOR = 0.8
DATA = Strength(material_factor=FACTOR, fatigue_rule="equivalent_balls")
dynamic_capacity = eqx.filter_jit(strength.dynamic_capacity)


def _stage(data=DATA, lead=5e-3, profile: float | None = 4e-3, addendum=None, **more):
    """30 x 5 mm with 5 starts in Wu's convention, in which nothing has to mesh."""
    geometry = thread(
        5e-3,
        lead,
        roller_profile_radius=profile,
        screw_addendum=addendum,
        roller_addendum=addendum,
    )
    return stage(geometry=geometry, curvature="wu2022", strength=data, **more)


def _by_hand(lead=5e-3, profile=4e-3, rollers=7, threads=20.0):
    """Lundberg and Palmgren's ring for a straight flank, newtons and millimetres, 45°."""
    sine = math.sqrt(0.5)
    ball = 2 * math.sqrt(1e3 * profile * 5.0 / sine)
    ratio = 5.0 / 20.0
    normal_per_axial = 1 / (math.cos(math.atan(lead / (2 * math.pi * 25e-3))) * sine)
    # ISO 281 has 3.647 D^1.4 for balls above 25.4 mm.
    power = ball**1.8 if ball <= 25.4 else 3.647 * ball**1.4
    ring = 98.1 * ratio**0.3 * power * (rollers * threads) ** (2 / 3) / normal_per_axial
    inner = ring * (1 - ratio) ** 1.39 / (1 + ratio) ** (1 / 3)
    outer = ring * (1 + ratio) ** 1.39 / (1 - ratio) ** (1 / 3)
    return (inner ** (-10 / 3) + outer ** (-10 / 3)) ** -0.3


@pytest.mark.parametrize(("lead", "profile"), [(5e-3, 4e-3), (2e-3, 1.6e-3), (20e-3, 60e-3)])
def test_capacity_by_hand(lead, profile):
    one = _stage(lead=lead, profile=profile, engaged_threads=20.0)
    expected = FACTOR * _by_hand(lead, profile, one.roller_count)
    # The last ball is 41 mm thick; the standard rounds 25.4^0.4 = 3.64695 to 3.647.
    tolerance = 1e-12 if profile < 0.02 else 2e-5
    np.testing.assert_allclose(dynamic_capacity(one), expected, rtol=tolerance)


def test_a_profile_in_proportion_to_the_pitch_gives_the_exponent_of_ball_screws():
    """Threads over one length, z ~ 1/p, and ρ ~ p: p^(0.9 − 2/3), but for the helix angle."""
    capacities = [
        float(dynamic_capacity(_stage(lead=lead, profile=0.8 * lead, engaged_threads=0.1 / lead)))
        for lead in (1e-4, 2e-4)
    ]
    assert math.log2(capacities[1] / capacities[0]) == pytest.approx(0.9 - 2 / 3, abs=1e-6)


def test_the_ball_has_the_product_of_the_curvature_radii():
    one = _stage(engaged_threads=20.0)
    diameter = strength.equivalent_ball_diameter(one)
    np.testing.assert_allclose(diameter**2 / 4, 4e-3 * 5e-3 * math.sqrt(2), rtol=1e-13)
    # A profile centred on the roller's axis makes the roller itself the ball.
    centred = _stage(profile=None, engaged_threads=20.0)
    np.testing.assert_allclose(
        strength.equivalent_ball_diameter(centred), 2 * 5e-3 * math.sqrt(2), rtol=1e-13
    )


def test_sharing_and_split_nuts_lower_it():
    whole = dynamic_capacity(_stage(engaged_threads=20.0))
    shared = dynamic_capacity(_stage(engaged_threads=20.0), sharing_factor=1.25)
    np.testing.assert_allclose(shared, whole / 1.25, rtol=1e-14)
    play = AxialPlay(preload_force=100.0, arrangement="split_nut")
    split = Strength(material_factor=FACTOR, fatigue_rule="equivalent_balls", play=play)
    half = dynamic_capacity(_stage(split, engaged_threads=20.0))
    np.testing.assert_allclose(half, whole / 2 ** (2 / 3), rtol=1e-13)


def test_ends_of_flanks_do_not_matter():
    cut = _stage(addendum=0.05e-3, engaged_threads=20.0)
    whole = _stage(engaged_threads=20.0)
    np.testing.assert_allclose(dynamic_capacity(cut), dynamic_capacity(whole), rtol=1e-14)
    assert strength.truncated_fatigue(cut) is None
    assert not strength.cuts_fatigue(cut)
    sentences = prsm.assumptions(mechanism(cut), ["dynamic_capacity"])
    assert any("formula of ball screws" in one for one in sentences)
    assert not any("ellipse" in one for one in sentences)
    assert _taken(cut) == (
        "Pressures take this into account, but not the dynamic capacity of equivalent balls and "
        "its life, nor the concentration of pressure at the edge"
    )
    by_lundberg = _stage(Strength(material_factor=1.0), addendum=0.05e-3, engaged_threads=20.0)
    assert _taken(by_lundberg).startswith("The dynamic capacity, life and pressures take")


@pytest.mark.parametrize("name", ["roller_profile_radius", "roller_radius", "contact_angle"])
def test_derivatives_against_central_differences(name):
    one = _stage(engaged_threads=20.0)
    value = float(getattr(one.thread, name))

    def capacity(x):
        return strength.dynamic_capacity(
            eqx.tree_at(lambda s: getattr(s.thread, name), one, x, is_leaf=lambda x: x is None)
        )

    step = 1e-5 * value

    @jax.jit
    def slopes(x):
        central = (capacity(x + step) - capacity(x - step)) / 2 / step
        return central, jax.jacfwd(capacity)(x), jax.grad(capacity)(x)

    central, forward, reverse = slopes(jnp.asarray(value))
    # Truncation of a central difference of relative step h: about h².
    np.testing.assert_allclose(forward, central, rtol=1e-8)
    np.testing.assert_allclose(reverse, forward, rtol=1e-12)
