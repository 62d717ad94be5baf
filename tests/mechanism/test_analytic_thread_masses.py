"""Masses by the rule `thread_profile` against closed forms and against the profile in slices."""

import dataclasses
from typing import Any

import jax
import numpy as np
import pytest
from scenes import STEEL, stage, thread

import prsm_jax as prsm
from prsm_jax.mechanism import (
    Nut,
    Roller,
    Screw,
    body_inertia,
    body_mass,
    thread_heights,
    thread_section,
)
from prsm_jax.mechanism.parts import AxialPlay, LoadSharing, ScrewShaft, Strength, ThreadTooth
from prsm_jax.programs import traced_physics

BODIES: tuple[Any, ...] = ("screw", "roller", "nut")
DENSITY = 7850.0
LENGTHS = {"screw": 0.35, "roller": 0.05, "nut": 0.08}
#: Given dedenda, different for each body [m].
ROOTS = {"screw": 0.45e-3, "roller": 0.42e-3, "nut": 0.47e-3}
THINNINGS = {"screw": 0.08e-3, "roller": 0.05e-3, "nut": 0.01e-3}


def _stage(rule="thread_profile", roller_profile_radius=None):
    tooth = ThreadTooth(0.8e-3, ROOTS["screw"], ROOTS["roller"], ROOTS["nut"])
    play = AxialPlay(
        screw_tooth_thinning=THINNINGS["screw"],
        roller_tooth_thinning=THINNINGS["roller"],
        nut_tooth_thinning=THINNINGS["nut"],
    )
    return stage(
        geometry=thread(
            screw_addendum=0.3e-3,
            roller_addendum=0.4e-3,
            roller_profile_radius=roller_profile_radius,
        ),
        material=STEEL,
        screw=Screw(length=LENGTHS["screw"], bore_radius=4e-3),
        roller=Roller(length=LENGTHS["roller"], bore_radius=1e-3),
        nut=Nut(length=LENGTHS["nut"], wall_thickness=10e-3),
        load_sharing=LoadSharing(3, tooth=tooth),
        strength=Strength(play=play),
        mass_rule=rule,
    )


def _numbers(body):
    """Nominal radius, other radius, sign, crest, root [m] of the stage above."""
    nominal = {"screw": 12e-3, "roller": 4e-3, "nut": 20e-3}[body]
    other = {"screw": 4e-3, "roller": 1e-3, "nut": 30e-3}[body]
    crest = 0.4e-3 if body == "roller" else 0.3e-3
    return nominal, other, -1 if body == "nut" else 1, crest, ROOTS[body]


def _radius_over_pitch(body, along, arc):
    """Radius of the profile at a distance from the middle of a tooth, solved for directly."""
    nominal, _, sign, crest, root = _numbers(body)
    half = 0.5e-3 - THINNINGS[body] / 2
    if body == "roller":
        # (s − s_0)² + (y + ρ sin α)² = ρ², the centre at s_0 on this side of the tooth.
        centre = half - arc / np.sqrt(2)
        inside = np.clip(arc**2 - (along - centre) ** 2, 0, None)
        height = np.sqrt(inside) - arc / np.sqrt(2)
    else:
        height = half - along
    return nominal + sign * np.clip(height, -root, crest)


@pytest.mark.parametrize("body", BODIES)
def test_mass_and_inertia_are_those_of_the_profile_in_slices(body):
    """The midpoint rule over half a pitch; its kinks cost 1e-10."""
    one = _stage()
    _, other, sign, _, _ = _numbers(body)
    count = 400_000
    along = (np.arange(count) + 0.5) / count * 1e-3
    radius = _radius_over_pitch(body, along, 4e-3 * np.sqrt(2))
    area = sign * np.pi * (np.mean(radius**2) - other**2)
    moment = sign * np.pi / 2 * (np.mean(radius**4) - other**4)
    mass = DENSITY * LENGTHS[body] * area
    assert body_mass(one, body) == pytest.approx(mass, rel=1e-9)
    assert body_inertia(one, body) == pytest.approx(DENSITY * LENGTHS[body] * moment, rel=1e-9)
    given = dataclasses.replace(getattr(one, body), mass=0.5)
    heavier = dataclasses.replace(one, **{body: given})
    assert body_inertia(heavier, body) == pytest.approx(0.5 * moment / area, rel=1e-9)


@pytest.mark.parametrize("body", ["screw", "nut"])
def test_straight_flanks_have_the_closed_form(body):
    """Frusta: ∫ r² ds of crest, root and two straight flanks of slope 1, to rounding."""
    nominal, _, sign, crest, root = _numbers(body)
    half = 0.5e-3 - THINNINGS[body] / 2
    high, low = nominal + sign * crest, nominal - sign * root
    at_crest, at_root = half - crest, half + root
    flank = (crest + root) * (high**2 + high * low + low**2) / 3
    total = 2 * at_crest * high**2 + (2e-3 - 2 * at_root) * low**2 + 2 * flank
    area = thread_section(_stage(), body).area
    assert area == pytest.approx(np.pi * total / 2e-3, rel=1e-14)


@pytest.mark.parametrize("arc", [4e-3, 4e-3 * np.sqrt(2), 50e-3])
def test_the_arc_of_a_roller_has_the_closed_form(arc):
    """Segments of a circle: ∫ √(ρ² − u²) (R' + u) du by its antiderivative, with 50 digits."""
    import mpmath

    with mpmath.workdps(50):
        rho, root2 = mpmath.mpf(float(arc)), mpmath.sqrt(2)
        centre = rho / root2
        nominal, _, _, crest, root = (mpmath.mpf(one) for one in _numbers("roller"))
        level = mpmath.mpf("0.0005") - mpmath.mpf(THINNINGS["roller"]) / 2 - centre

        def antiderivative(u):
            square = rho**2 - u**2
            arcs = (u * mpmath.sqrt(square) + rho**2 * mpmath.asin(u / rho)) / 2
            return (
                (nominal - centre) * arcs
                - square ** mpmath.mpf("1.5") / 3
                + level * ((nominal - centre) * u + u**2 / 2)
            )

        inner = antiderivative(crest + centre) - antiderivative(centre - root)
        area = mpmath.pi * ((nominal - root) ** 2 + 4 / mpmath.mpf("0.002") * inner)
        expected = float(area)
    found = thread_section(_stage(roller_profile_radius=arc), "roller").area
    assert found == pytest.approx(expected, rel=1e-13)


def test_dedenda_are_given_or_leave_a_clearance():
    given = thread_heights(_stage())
    assert [float(given.of(body)[1]) for body in BODIES] == pytest.approx(
        [ROOTS[body] for body in BODIES], rel=1e-15
    )
    shaft = Strength(shaft=ScrewShaft("fixed_free", root_radius=11.6e-3))
    by_root = thread_heights(dataclasses.replace(_stage(), strength=shaft))
    assert by_root.screw_dedendum == pytest.approx(0.4e-3, rel=1e-12)
    bare = dataclasses.replace(_stage(), load_sharing=None)
    # Pointed teeth of 2 mm pitch and 45° are 0.5 mm high above the nominal radius; 0.98 of it.
    heights = [1e3 * float(one) for one in thread_heights(bare)]
    assert heights == pytest.approx([0.3, 0.4, 0.449, 0.349, 0.449], rel=1e-12)
    usual = thread_heights(stage())
    assert 1e3 * usual.screw_addendum == pytest.approx(0.343, rel=1e-12)


def test_the_default_is_the_nominal_cylinder_and_traces_no_profile():
    cylinder, profile = _stage("nominal_cylinder"), _stage()
    assert stage().mass_rule == "nominal_cylinder"
    for body in BODIES:
        mass = {"screw": 128e-6, "roller": 15e-6, "nut": 500e-6}[body]
        mass *= np.pi * DENSITY * LENGTHS[body]
        assert body_mass(cylinder, body) == pytest.approx(mass, rel=1e-14)
        assert traced_physics(lambda one, b=body: body_mass(one, b), cylinder) == set()
        traced = traced_physics(lambda one, b=body: body_mass(one, b), profile)
        assert traced == {"thread_section"}


def test_a_given_mass_needs_no_profile():
    one = dataclasses.replace(stage(), mass_rule="thread_profile")
    assert body_mass(one, "roller") == 0.03
    assert traced_physics(lambda s: body_mass(s, "roller"), one) == set()


def test_a_profile_without_its_height_is_an_error():
    one = dataclasses.replace(_stage(), thread=thread(screw_addendum=0.3e-3))
    with pytest.raises(prsm.MissingDataError, match=r"give stage\.thread\.roller_addendum, or"):
        body_mass(one, "roller")
    assert body_mass(one, "nut") > 0


def test_a_pointed_tooth_ends_in_a_point():
    """An addendum beyond the point is cut to 0.98 of the height of a pointed tooth."""
    pointed = dataclasses.replace(
        _stage(), thread=thread(screw_addendum=5e-3), load_sharing=None, strength=None
    )
    assert thread_heights(pointed).screw_addendum == pytest.approx(0.49e-3, rel=1e-12)
    section = thread_section(pointed, "screw")
    assert 0 < float(section.area) < np.pi * 12.5e-3**2


def test_designs_of_a_batch_have_their_own_sections():
    mechanism = prsm.Mechanism((_stage(),))

    def mass(radius):
        moved = prsm.set_parameter(mechanism, "roller_radius", radius).stages[0]
        return body_mass(moved, "roller"), body_inertia(moved, "nut")

    radii = np.array([3.5e-3, 4e-3, 5e-3])
    together = jax.vmap(mass)(radii)
    for index, radius in enumerate(radii):
        for many, alone in zip(together, mass(radius), strict=True):
            assert float(many[index]) == pytest.approx(float(alone), rel=1e-14)


@pytest.mark.parametrize(("rule", "words"), [("thread_profile", "profiles"), (None, "cylinders")])
def test_the_assumptions_state_the_rule(rule, words):
    actuator = prsm.load("actuator")
    if rule is not None:
        actuator = prsm.file.apply_settings(actuator, [f"mass_rule={rule}"])
        assert actuator.stages[0].mass_rule == rule
    (stated,) = prsm.assumptions(actuator, ["mass"])
    assert words in stated
    assert stated in prsm.assumptions(actuator)
    assert prsm.assumptions(prsm.Mechanism((stage(),)), ["mass"]) == ()
