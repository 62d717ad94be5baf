"""Creep friction: closed forms, slip of the steady state, and a dense quadratic eigenproblem."""

import dataclasses
import functools

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from damped_spectrum import assert_all_among, quadratic_eigenvalues
from present import present
from scenes import array, example

import prsm_jax as prsm
from prsm_jax import vibration
from prsm_jax.dynamics import sliding_contact
from prsm_jax.friction import (
    CoulombFriction,
    RegularisedCoulombFriction,
    StribeckFriction,
    ViscousFriction,
)
from prsm_jax.response import creep_friction, spatial_damping
from prsm_jax.response._damped_modes import damped_modes
from prsm_jax.vibration import Coordinate, Spring, SpringNetwork


def _one_program(function):
    """Compiled for all speeds and loads: of floats each would have a program of its own."""
    program = eqx.filter_jit(function)
    return lambda one, *, speed, load: program(one, speed=array(speed), load=array(load))


_damping = _one_program(spatial_damping)
_creep = _one_program(creep_friction)
_system = eqx.filter_jit(vibration.stage_spatial_system)
_damped = eqx.filter_jit(lambda network, dashpots: damped_modes(
    vibration.spring_modes(network), dashpots
))  # fmt: skip


def _with_law(law):
    """The actuator whose only friction is that of the threads."""
    one = example("actuator")
    friction = dataclasses.replace(
        present(one.stages[0].friction), thread=law, spin=None, rolling_hysteresis=None
    )
    return dataclasses.replace(one, stages=(dataclasses.replace(one.stages[0], friction=friction),))


LAWS = {
    "coulomb": CoulombFriction(0.06),
    "stribeck": StribeckFriction(0.15, 0.05, 0.3, viscous_coefficient=2.0),
    "regularised": RegularisedCoulombFriction(0.06, 0.01),
    "viscous": ViscousFriction(3.0),
}


@functools.cache
def _found():
    return _damping(_with_law(LAWS["coulomb"]), speed=157.0, load=12e3)


@functools.cache
def _networks(harmonic):
    """Springs and masses, and dashpots, of a harmonic of the rollers."""
    system = _system(_with_law(LAWS["coulomb"]), 1, 12e3)
    return vibration.spatial_harmonic_network(system, harmonic), _found().creep.network(
        system, harmonic
    )


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("load", [12e3, -12e3])
def test_power_is_the_friction_loss_of_the_steady_state(name, load):
    one = _with_law(LAWS[name])
    creep = _creep(one, speed=157.0, load=load)
    loss = prsm.steady_state(one, 157.0, load).losses["thread_sliding"]
    assert float(creep.power) * one.stages[0].roller_count == pytest.approx(float(loss), rel=1e-12)
    # For either sign of the load, slip and direction are in the frame of the flank that carries it.
    sliding = sliding_contact(one, 1, 157.0, load)
    slip = np.asarray(sliding.velocity)
    assert slip / np.linalg.norm(slip) == pytest.approx(np.asarray(sliding.direction), abs=1e-12)
    assert slip @ np.asarray(sliding.contact.normal) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_dampings_are_the_slopes_of_the_friction_force(name):
    one, law = _with_law(LAWS[name]), LAWS[name]
    creep = _creep(one, speed=157.0, load=12e3)
    force, speed = float(creep.contact_force), float(creep.slip_speed)
    resistance = float(present(law.viscous_resistance)) if name in ("stribeck", "viscous") else 0.0
    mean = np.array([speed, 0.0])

    def friction(slip):
        size = np.linalg.norm(slip)
        sliding = prsm.friction.Sliding(jnp.asarray(size))
        return (force * float(law.friction_coefficient(sliding)) / size + resistance) * slip

    step = 1e-4 * speed
    for row, way in enumerate(np.eye(2)):
        slope = (friction(mean + step * way) - friction(mean - step * way)) / (2 * step)
        expected = [creep.damping_along_slip, creep.damping_across_slip][row]
        assert slope[row] == pytest.approx(float(expected), rel=1e-6, abs=1e-6)
        assert slope[1 - row] == pytest.approx(0.0, abs=1e-6)


def test_dashpots_see_the_slip_of_the_steady_motion():
    # Levers of the vibration room against the kinematics of the dynamics room: all bodies move as
    # in the steady state, seen from the carrier.
    one = _with_law(LAWS["coulomb"])
    thread, speed = one.stages[0].thread, 157.0
    carrier = speed * float(prsm.steady_state(one, speed, 12e3).carrier_ratio[0])
    along, across = _found().creep.dashpots
    around = (speed - carrier) * float(thread.screw_radius)
    rolling = -float(thread.starts) * carrier * float(thread.roller_radius)
    advance = speed * float(thread.lead) / (2 * np.pi)
    for dashpot, expected in ((along, float(_found().creep.slip_speed)), (across, 0.0)):
        rate = float(dashpot.central[3]) * around + float(dashpot.roller[3]) * rolling
        rate += float(dashpot.central[2]) * advance
        assert rate == pytest.approx(expected, abs=1e-12)
    normal = np.asarray(sliding_contact(one, 1, speed, 12e3).contact.normal)
    frame = np.stack([_found().creep.along, _found().creep.across, normal])
    assert np.abs(frame @ frame.T - np.eye(3)).max() < 1e-12


def test_two_bodies_with_one_dashpot_have_the_ratio_of_a_textbook():
    # Masses m₁, m₂ with a spring k and a dashpot c between them: ζ = c/(2 √(k μ)), exactly.
    stiffness, damping, masses = 2e7, 900.0, np.array([1.3, 0.7])
    coordinates = (Coordinate("a", "x"), Coordinate("b", "x"))
    row, ground = [[1.0, -1.0]], [[1e-9, 0.0]]
    network = SpringNetwork(
        jnp.asarray([stiffness, 1e-9]), jnp.asarray(row + ground), jnp.asarray(masses),
        coordinates, (Spring("k"), Spring("none")),
    )  # fmt: skip
    dashpots = dataclasses.replace(
        network, stiffness=jnp.asarray([damping, 0.0]), rows=jnp.asarray(row + ground)
    )
    found = _damped(network, dashpots)
    reduced = masses.prod() / masses.sum()
    expected = damping / (2 * np.sqrt(stiffness * reduced))
    assert float(found.ratios[1]) == pytest.approx(expected, rel=1e-12)
    assert float(found.first_order[1]) == pytest.approx(expected, rel=1e-12)
    assert abs(complex(found.eigenvalues[1])) == pytest.approx(np.sqrt(stiffness / reduced))
    # A repeated root: two equal masses on equal springs, one damped. The mean is the trace.
    equal = dataclasses.replace(
        network, stiffness=jnp.full(2, 1e6), rows=jnp.eye(2), mass=jnp.ones(2)
    )
    mixed = _damped(equal, dataclasses.replace(dashpots, rows=jnp.eye(2)))
    assert np.asarray(mixed.ratios) == pytest.approx(damping / (4 * 1e3), rel=1e-12)


@pytest.mark.parametrize("harmonic", [0, 1, 2])
def test_ratios_are_those_of_the_dense_quadratic_eigenproblem(harmonic):
    network, dashpots = _networks(harmonic)
    exact = quadratic_eigenvalues(network, np.asarray(dashpots.stiffness_matrix()))
    found = _damped(network, dashpots)
    assert found.found.all()
    for value in np.asarray(found.eigenvalues)[np.asarray(found.ratios) != 0]:
        # LAPACK's eigenvalues have the rounding of the largest one.
        assert np.abs(exact - value).min() < 1e-13 * np.abs(exact).max()
    ratios = np.asarray(_found().ratios[harmonic])
    assert ratios == pytest.approx(np.asarray(found.ratios), rel=1e-10, abs=1e-16)


@pytest.mark.parametrize("harmonic", [0, 1])
def test_the_error_of_first_order_is_of_second_order(harmonic):
    network, dashpots = _networks(harmonic)
    errors = []
    for share in (1e-2, 5e-3):
        weak = dataclasses.replace(dashpots, stiffness=share * dashpots.stiffness)
        found = _damped(network, weak)
        vibrates = np.asarray(found.first_order) > 1e-9
        first, exact = np.asarray(found.first_order)[vibrates], np.asarray(found.ratios)[vibrates]
        errors.append(np.abs(first / exact - 1).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def test_the_symmetric_path_is_the_dense_one():
    one = _with_law(LAWS["coulomb"])
    system = _system(one, 1, 12e3)
    network = vibration.spatial_network(system)
    matrix = np.asarray(_found().creep.viscous_matrix(system))
    # An assembly of its own: at each roller two directions, turned with it.
    rows = []
    for at, turn in enumerate(np.asarray(system.roller_positions)):
        cosine, sine = np.cos(turn), np.sin(turn)
        for dashpot in _found().creep.dashpots:
            row = np.zeros(len(network.coordinates))
            along, around, axial, lever = map(float, dashpot.central)
            values = {"x": along * cosine - around * sine, "y": along * sine + around * cosine}
            for direction, value in (values | {"z": axial, "u": lever}).items():
                row[network.index(f"screw {direction}")] = value
            for direction, value in zip(
                ("radial", "tangential", "z", "u"), dashpot.roller, strict=True
            ):
                row[network.index(f"roller {at + 1} {direction}")] = float(value)
            rows.append(np.sqrt(float(dashpot.stiffness)) * row)
    dense = np.stack(rows).T @ np.stack(rows)
    assert np.abs(matrix - dense).max() < 1e-12 * np.abs(dense).max()
    exact = quadratic_eigenvalues(network, dense)
    assert assert_all_among(_found(), exact) > 10


def test_ratios_stand_in_the_order_of_the_frequencies():
    frequencies = np.asarray(_found().modes.frequencies)
    ratios = np.asarray(_found().damping_ratios)
    assert ratios.shape == frequencies.shape
    for group, values in zip(_found().modes.groups, _found().ratios, strict=True):
        for hertz, ratio in zip(np.asarray(group.frequencies), np.asarray(values), strict=True):
            there = ratios[frequencies == hertz]
            assert np.count_nonzero(there == ratio) == group.multiplicity


def test_falling_friction_feeds_vibration_and_the_result_says_so():
    # At this speed the law falls by more than the dashpot across the slip makes up for.
    found = _damping(_with_law(LAWS["stribeck"]), speed=157.0, load=12e3)
    assert float(found.creep.damping_along_slip) < 0 < float(found.creep.damping_across_slip)
    lowest = min(float(one.min()) for one in found.ratios)
    assert (found.result_name == "negative_damping") == (lowest < 0)
    assert lowest < 0
    assert "friction falls as the slip rises" in found.result


def test_standstill_has_a_code_and_no_nan():
    stuck = _damping(_with_law(LAWS["coulomb"]), speed=0.0, load=12e3)
    assert stuck.result_name == "standstill"
    assert all(np.all(np.asarray(one) == 0) for one in stuck.ratios)
    slow = _damping(_with_law(LAWS["coulomb"]), speed=1e-9, load=12e3)
    assert slow.result_name == "successful"
    # A dashpot that is infinitely strong is a constraint and takes no power.
    assert all(np.abs(np.asarray(one)).max() < 1e-6 for one in slow.ratios)


def test_it_needs_the_friction_and_leaves_no_trace_in_modes():
    one = example("actuator")
    stage = dataclasses.replace(one.stages[0], friction=None)
    with pytest.raises(prsm.MissingDataError, match=r"stage\.friction\.thread"):
        creep_friction(dataclasses.replace(one, stages=(stage,)))
    traced = prsm.programs.traced_physics
    plain = traced(lambda m: prsm.spatial_modal(m).frequencies, one)
    assert not plain & {"creep_friction", "spatial_damping", "coulomb_friction", "steady_state"}


def test_overdamped_modes_are_marked_and_no_others():
    # Dashpots that stop the slip of a roller within a fraction of its own period.
    one = _with_law(ViscousFriction(2.3e4))
    found = _damping(one, speed=157.0, load=12e3)
    assert found.result_name == "overdamped"
    groups = found.modes.groups

    def ascending(values):
        hertz = np.concatenate([np.repeat(g.frequencies, g.multiplicity) for g in groups])
        each = [np.repeat(v, g.multiplicity) for v, g in zip(values, groups, strict=True)]
        return np.concatenate(each)[np.argsort(hertz, kind="stable")]

    frequencies, ratios = np.asarray(found.modes.frequencies), np.asarray(found.damping_ratios)
    elastic, marked = frequencies > 1, np.asarray(found.vibrating)
    system = _system(one, 1, 12e3)
    exact = quadratic_eigenvalues(
        vibration.spatial_network(system), np.asarray(found.creep.viscous_matrix(system))
    )
    # LAPACK gives rigid motions rounding errors; they are slower than any vibration.
    slow = np.pi * frequencies[elastic].min()
    vibrating = exact[(exact.imag > 1e-3 * np.abs(exact)) & (np.abs(exact) > slow)]
    assert np.all(marked[~elastic])
    assert np.count_nonzero(marked & elastic) == len(vibrating) == 27
    assert np.count_nonzero(~marked) == 10
    # A mode that does not vibrate has the ratio of first order, and the others have their own.
    first = ascending(found.first_order_ratios)
    assert np.all((ratios == first)[elastic] == ~marked[elastic])
    size = 2 * np.pi * ascending(found.damped_frequencies)[marked & elastic]
    ratio = ratios[marked & elastic]
    values = size * (-ratio + 1j * np.sqrt(1 - ratio**2))
    near = np.abs(values[:, None] - vibrating).min(axis=0)
    assert near.max() < 1e-12 * np.abs(exact).max()
