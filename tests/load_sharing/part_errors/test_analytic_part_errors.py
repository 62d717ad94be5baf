"""Errors of parts against a solution of its own, closed forms, and the work that forces do."""

import numpy as np
import pytest
from error_scenes import (
    ERRORS,
    FREE,
    LOAD,
    NO_ERRORS,
    ROLLERS,
    Own,
    shared,
    stage_with,
)
from scenes import array

import prsm_jax as prsm
from prsm_jax.load_sharing import stage_load_distribution
from prsm_jax.mechanism import FreeNut, PartErrors, UnequalRoller


def test_no_errors_give_what_a_stage_without_them_has():
    """All errors 0: each roller carries what one carries for all of them."""
    plain, found = shared(stage_with()), shared(stage_with({}))
    for side in ("screw", "nut"):
        expected = np.broadcast_to(getattr(plain, side).forward, (ROLLERS, 20))
        np.testing.assert_allclose(getattr(found, side).forward, expected, rtol=1e-12)
    for name in ("deflection", "tangent_stiffness", "max_pressure"):
        assert float(getattr(found, name)) == pytest.approx(float(getattr(plain, name)), rel=1e-12)
    # Forces around the screw cancel to rounding.
    assert np.abs(found.nut_radial_force).max() < 1e-12 * LOAD
    # Contacts lie at their places within a pitch of 2 mm: with 5 starts, 0, 5/6, 4/6 … of it.
    turns = np.arange(ROLLERS) / ROLLERS
    lever = 2e-3 * np.exp(2j * np.pi * turns) @ ((5 * turns) % 1)
    moment = np.asarray(found.nut_overturning_moment) @ [1, 1j]
    # tan 45° = 1.
    assert abs(moment - LOAD / ROLLERS * lever) < 1e-12 * abs(moment)
    assert plain.nut_radial_force is None


def test_against_displacements_by_newton():
    """All errors at once; weak springs on nodes that nothing holds differ by some 1e-8."""
    # Its place is a static choice: this comparison is the only one with a roller away from it.
    stage = stage_with(ERRORS, (UnequalRoller(2, position_offset=0.05),))
    found = shared(stage)
    own = Own(stage, found, ERRORS)
    assert own.residual < 1e-10
    loads = np.asarray(found.nut.forward)
    assert np.sum(loads == 0) > 10
    assert np.any(np.all(loads < 1e-6, axis=1))
    np.testing.assert_allclose(loads, own.nut, atol=1e-7 * loads.max())
    np.testing.assert_allclose(found.screw.forward, own.screw, atol=1e-7 * loads.max())
    assert float(found.deflection) == pytest.approx(own.deflection, rel=1e-7)


def test_free_nut_against_displacements_by_newton():
    """Position and lean are those of the same energy, less the work of load and moment."""
    stage = stage_with(ERRORS, free_nut=FREE)
    found = shared(stage)
    own = Own(stage, found, ERRORS, FREE)
    assert own.residual < 1e-10
    loads = np.asarray(found.nut.forward)
    np.testing.assert_allclose(loads, own.nut, atol=1e-7 * loads.max())
    np.testing.assert_allclose(found.nut_displacement, own.displacement[:2], rtol=1e-6)
    np.testing.assert_allclose(found.nut_lean, own.displacement[2:], rtol=1e-6)


@pytest.mark.parametrize("backlash", [None, 3e-6])
def test_free_nut_is_in_balance(backlash):
    """Rollers press back what is given; the springs that hold one or two rollers take 1e-9."""
    play = {} if backlash is None else {"backlash": backlash}
    found = shared(stage_with(ERRORS, free_nut=FREE, **play))
    for forces, amount, angle in (
        (found.nut_radial_force, FREE.radial_load, FREE.radial_load_angle),
        (found.nut_overturning_moment, FREE.overturning_moment, FREE.overturning_moment_angle),
    ):
        given = float(amount) * np.array([np.cos(angle), np.sin(angle)])
        np.testing.assert_allclose(forces, -given, rtol=1e-8)
    assert float(np.sum(found.nut.roller_load)) == pytest.approx(LOAD, rel=1e-9)


def test_free_nut_does_not_notice_where_it_was_mounted():
    """It takes back its own eccentricity and tilt; loads are those without them."""
    free = {"free_nut": FREE}
    own_errors = {name: value for name, value in ERRORS.items() if not name.startswith("nut_")}
    found, other = shared(stage_with(ERRORS, **free)), shared(stage_with(own_errors, **free))
    np.testing.assert_allclose(found.nut.forward, other.nut.forward, atol=1e-7 * LOAD / 120)
    angle, lean = ERRORS["nut_eccentricity_angle"], ERRORS["nut_tilt_angle"]
    taken = other.nut_displacement - found.nut_displacement
    np.testing.assert_allclose(taken, 20e-6 * np.array([np.cos(angle), np.sin(angle)]), rtol=1e-6)
    taken = other.nut_lean - found.nut_lean
    np.testing.assert_allclose(taken, 1e-4 * np.array([np.cos(lean), np.sin(lean)]), rtol=1e-6)


def test_screw_and_nut_displaced_alike_change_nothing():
    """Rollers follow: only the distance of both axes counts; their own radial place does not."""
    alike = {
        "nut_eccentricity": 20e-6,
        "nut_eccentricity_angle": 0.7,
        "screw_eccentricity": 20e-6,
        "screw_eccentricity_angle": 0.7,
    }
    found, plain = shared(stage_with(alike)), shared(stage_with({}))
    np.testing.assert_allclose(found.nut.forward, plain.nut.forward, rtol=1e-9)
    apart = shared(stage_with(alike | {"screw_eccentricity_angle": 0.7 + np.pi}))
    assert float(apart.nut.roller_sharing_factor) > 1.5


def test_thicker_rollers_all_alike_move_only_the_nut():
    """By tan α Δd, of both sides; one of them alone takes more load."""
    alike = {"roller_diameter_deviation": np.full(ROLLERS, 3e-6)}
    found, plain = shared(stage_with(alike)), shared(stage_with({}))
    np.testing.assert_allclose(found.nut.forward, plain.nut.forward, rtol=1e-9)
    travel = float(plain.deflection) - float(found.deflection)
    # tan 45°.
    assert travel == pytest.approx(3e-6, rel=1e-9)
    one = {"roller_diameter_deviation": np.eye(ROLLERS)[2] * 1e-6}
    assert int(np.argmax(shared(stage_with(one)).nut.roller_load)) == 2


def test_force_is_where_rollers_are_pressed():
    """A nut displaced towards roller 1 leaves it; those opposite push the nut back."""
    found = shared(stage_with({"nut_eccentricity": 5e-6}))
    loads = np.asarray(found.nut.roller_load)
    assert loads[0] == loads.min()
    assert loads[3] == loads.max()
    angle = 2 * np.pi * np.arange(ROLLERS) / ROLLERS
    # tan 45° = 1, and the moment by hand, of single threads.
    np.testing.assert_allclose(
        found.nut_radial_force, [loads @ np.cos(angle), loads @ np.sin(angle)], atol=1e-9 * LOAD
    )
    assert float(found.nut_radial_force[0]) < 0
    spread = np.std(loads) / np.mean(loads)
    assert float(found.nut.roller_load_unbalance) == pytest.approx(spread, rel=1e-12)


def test_only_what_a_stage_mentions_is_traced():
    def physics(stage):
        found = prsm.programs.traced_physics(
            lambda s: stage_load_distribution(s, array(LOAD)), stage
        )
        return found & {"part_errors", "free_nut"}

    assert physics(stage_with()) == set()
    assert physics(stage_with({})) == {"part_errors"}
    assert physics(stage_with(free_nut=FREE)) == {"free_nut"}


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: PartErrors(), "part_errors has no error"),
        (lambda: PartErrors(nut_tilt_angle=1.0), "nut_tilt_angle, but no nut_tilt"),
        (lambda: FreeNut(radial_load_angle=1.0), "radial_load_angle, but no radial_load"),
        (
            lambda: stage_with(NO_ERRORS | {"roller_tilt": np.zeros(4)}),
            "roller_tilt has 4 numbers, but roller_count is 6",
        ),
    ],
)
def test_wrong_input(make, words):
    with pytest.raises(ValueError, match=words):
        make()
