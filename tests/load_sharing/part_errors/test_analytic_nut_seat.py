"""A nut in an elastic seat: own minimisation, springs in series, and both limits."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from error_scenes import ERRORS, FREE, LOAD, Own, shared, stage_with
from scenes import array

import prsm_jax as prsm
from prsm_jax.load_sharing import stage_load_distribution

#: Radial stiffness [N/m] and tilting stiffness [N·m/rad], near those of the contacts.
SEAT: dict[str, Any] = {"radial_stiffness": 4e8, "tilting_stiffness": 2e5}
_NAMES = ("nut_eccentricity", "nut_tilt")


def _seat(**changed) -> Any:
    given = {name: None if one is None else array(one) for name, one in (SEAT | changed).items()}
    return dataclasses.replace(FREE, **given)


def test_against_displacements_by_newton():
    """All errors, loads across the axis and the seat: forces, position and lean."""
    seat = _seat()
    stage = stage_with(ERRORS, free_nut=seat)
    found = shared(stage)
    own = Own(stage, found, ERRORS, seat)
    assert own.residual < 1e-10
    loads = np.asarray(found.nut.forward)
    np.testing.assert_allclose(loads, own.nut, atol=1e-7 * loads.max())
    np.testing.assert_allclose(found.nut_displacement, own.displacement[:2], rtol=1e-6)
    np.testing.assert_allclose(found.nut_lean, own.displacement[2:], rtol=1e-6)
    # Both carry a part of what errors press: neither is negligible here.
    for name, vector in (("radial", found.nut_displacement), ("tilting", found.nut_lean)):
        assert np.hypot(*vector) * SEAT[f"{name}_stiffness"] > 1.0


@pytest.mark.parametrize("backlash", [None, 3e-6])
def test_seat_and_rollers_carry_the_loads_together(backlash):
    """What is given is what rollers press back, and stiffness times displacement."""
    play = {} if backlash is None else {"backlash": backlash}
    found = shared(stage_with(ERRORS, free_nut=_seat(), **play))
    for forces, moved, stiffness, amount, angle in (
        (found.nut_radial_force, found.nut_displacement, 4e8, 300.0, 0.2),
        (found.nut_overturning_moment, found.nut_lean, 2e5, 5.0, 1.0),
    ):
        given = amount * np.array([np.cos(angle), np.sin(angle)])
        np.testing.assert_allclose(stiffness * moved - forces, given, rtol=1e-8)


@pytest.mark.parametrize("backlash", [None, 3e-6])
def test_a_very_stiff_seat_holds_the_nut(backlash):
    """1e12 times as stiff as the contacts: loads are those of a nut that is held."""
    play = {} if backlash is None else {"backlash": backlash}
    held = shared(stage_with(ERRORS, **play))
    stiff = _seat(radial_stiffness=1e21, tilting_stiffness=1e18)
    found = shared(stage_with(ERRORS, free_nut=stiff, **play))
    loads = np.asarray(held.nut.forward)
    np.testing.assert_allclose(found.nut.forward, loads, atol=1e-12 * loads.max())
    # Regularising springs of reverse flanks follow the loads, those across the axis included.
    np.testing.assert_allclose(found.nut_radial_force, held.nut_radial_force, rtol=1e-8)
    assert np.hypot(*found.nut_displacement) < 1e-17


def test_a_very_soft_seat_leaves_it_free():
    free = shared(stage_with(ERRORS, free_nut=FREE))
    soft = _seat(radial_stiffness=1e-3, tilting_stiffness=1e-6)
    found = shared(stage_with(ERRORS, free_nut=soft))
    loads = np.asarray(free.nut.forward)
    np.testing.assert_allclose(found.nut.forward, loads, atol=1e-11 * loads.max())
    np.testing.assert_allclose(found.nut_displacement, free.nut_displacement, rtol=1e-8)


def test_springs_in_series():
    """Small eccentricity: force e/(1/K + 1/S) of the rollers' matrix K and the seat's S.

    K by eccentricities and tilts of a nut that is held, in x and in y. The loads across the axis
    are those that leave the seat without a force at no errors, so that both are at one state.
    """
    none, across = stage_with({}), dict.fromkeys([f"{name}_angle" for name in _NAMES], np.pi / 2)
    columns = [-np.asarray(_by_amounts(one)) for one in (none, _turned(none, across))]
    rollers = np.stack([columns[0][:, 0], columns[1][:, 0], columns[0][:, 1], columns[1][:, 1]], 1)
    np.testing.assert_allclose(rollers, rollers.T, atol=1e-9 * np.abs(rollers).max())
    seat = np.diag([4e8, 4e8, 2e5, 2e5])
    error = np.array([1.0, 0.0, 0.0, 0.0])
    expected = -np.linalg.inv(np.linalg.inv(rollers) + np.linalg.inv(seat)) @ error
    held = shared(none)
    loads = {}
    for name, vector in (
        ("radial_load", held.nut_radial_force),
        ("overturning_moment", held.nut_overturning_moment),
    ):
        loads[name] = array(np.hypot(*vector))
        loads[f"{name}_angle"] = array(np.arctan2(-vector[1], -vector[0]))
    stage = stage_with({}, free_nut=dataclasses.replace(_seat(), **loads))
    assert np.hypot(*shared(stage).nut_displacement) < 1e-15
    found = np.asarray(_by_amounts(stage))[:, 0]
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())


def _turned(stage, angles):
    part = stage.load_sharing.part_errors
    changed = eqx.tree_at(
        lambda e: [getattr(e, name) for name in angles], part, [array(a) for a in angles.values()]
    )
    return eqx.tree_at(lambda s: s.load_sharing.part_errors, stage, changed)


@eqx.filter_jit
def _by_amounts(stage):
    """Derivatives of force and moment on the nut by its eccentricity and tilt."""

    def forces(amounts):
        one = eqx.tree_at(
            lambda s: [getattr(s.load_sharing.part_errors, name) for name in _NAMES],
            stage,
            list(amounts),
        )
        found: Any = stage_load_distribution(one, array(LOAD))
        return jnp.concatenate([found.nut_radial_force, found.nut_overturning_moment])

    return jax.jacfwd(forces)(jnp.zeros(2))


def _stiffnesses(stage: Any):
    nut = stage.load_sharing.free_nut
    return jnp.stack([nut.radial_stiffness, nut.tilting_stiffness])


@eqx.filter_jit
def _derivatives(stage, relative):
    """Loads, travel and energy, their Jacobian by stiffnesses (relative), and one by reverse."""
    base = _stiffnesses(stage)

    def outputs(relative):
        one = eqx.tree_at(
            lambda s: [
                s.load_sharing.free_nut.radial_stiffness,
                s.load_sharing.free_nut.tilting_stiffness,
            ],
            stage,
            list(base * (1 + relative)),
        )
        found = stage_load_distribution(one, array(LOAD))
        numbers = jnp.stack([found.deflection * 1e7, found.stored_energy * 1e4])
        moved = [found.nut_displacement * 1e7, found.nut_lean * 1e6]
        return jnp.concatenate([found.nut.roller_load, numbers, *moved])

    return outputs(relative), jax.jacfwd(outputs)(relative), jax.jacrev(outputs)(relative)


def test_gradients_by_the_stiffnesses():
    """Forward and reverse against differences of the fourth order."""
    stage = stage_with(ERRORS, free_nut=_seat())
    _, forward, reverse = _derivatives(stage, jnp.zeros(2))
    np.testing.assert_allclose(reverse, forward, atol=1e-9 * np.abs(forward).max())
    for k, unit in enumerate(np.eye(2)):

        def at(step, unit=unit):
            return np.asarray(_derivatives(stage, jnp.asarray(step * unit))[0])

        one, two = (at(h) - at(-h) for h in (5e-5, 1e-4))
        difference = (8 * one - two) / (12 * 5e-5)
        np.testing.assert_allclose(forward[:, k], difference, atol=1e-6 * np.abs(difference).max())


@eqx.filter_jit
def _by_load(stage):
    def energy(load):
        found = stage_load_distribution(stage, load)
        return found.stored_energy, found.deflection

    _, moved = jax.jvp(energy, (array(LOAD),), (array(1.0),))
    return moved


def test_energy_of_the_seat_is_stored():
    """dU = F dx without loads across the axis: the seat's part is in U."""
    none = dataclasses.replace(_seat(), radial_load=array(0.0), overturning_moment=array(0.0))
    energy, travel = _by_load(stage_with(ERRORS, free_nut=none))
    assert float(energy) == pytest.approx(LOAD * float(travel), rel=1e-8)


def test_only_a_seat_that_is_given_is_traced():
    def physics(nut):
        return "nut_seat" in prsm.programs.traced_physics(
            lambda s: stage_load_distribution(s, array(LOAD)), stage_with(free_nut=nut)
        )

    assert not physics(FREE)
    assert physics(_seat())
    assert physics(_seat(tilting_stiffness=None))


@pytest.mark.parametrize("name", sorted(SEAT))
@pytest.mark.parametrize("value", [0.0, -1.0])
def test_wrong_stiffness(name, value):
    with pytest.raises(ValueError, match=f"{name} is .*must be more than 0"):
        _seat(**{name: value})
