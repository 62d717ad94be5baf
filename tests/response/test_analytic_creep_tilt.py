"""Creep friction of tilting bodies: one pair of dashpots at each thread, and the axis."""

import dataclasses
import functools

import equinox as eqx
import numpy as np
import pytest
from damped_spectrum import assert_all_among, quadratic_eigenvalues
from present import present
from scenes import array, example

import prsm_jax as prsm
from prsm_jax import vibration
from prsm_jax.friction import CoulombFriction
from prsm_jax.response import axis_compliance, creep_friction, spatial_damping


def _actuator():
    """The actuator whose only friction is that of the threads."""
    one = example("actuator")
    friction = dataclasses.replace(
        present(one.stages[0].friction),
        thread=CoulombFriction(0.06),
        spin=None,
        rolling_hysteresis=None,
    )
    return dataclasses.replace(one, stages=(dataclasses.replace(one.stages[0], friction=friction),))


@functools.cache
def _found():
    run = eqx.filter_jit(lambda speed, load: spatial_damping(
        _actuator(), speed=speed, load=load, tilt=True
    ))  # fmt: skip
    return run(array(157.0), array(12e3))


def _threads_one_by_one(network, creep, stage):
    """Damping matrix of dashpots at every thread, each between points of two rigid bodies."""
    count, pitch = stage.load_sharing.thread_count, float(stage.thread.pitch)
    places = (np.arange(count) - (count - 1) / 2) * pitch
    distance = float(stage.thread.centre_distance)
    screw_radius = float(stage.thread.screw_radius)
    roller_radius = float(stage.thread.roller_radius)
    contact = prsm.mesh(stage.thread).screw
    angle = float(contact.contact_angle_position)
    point = float(contact.contact_radius) * np.array([np.cos(angle), np.sin(angle), 0.0])
    matrix = np.zeros((len(network.coordinates),) * 2)
    for at in range(stage.roller_count):
        turn = 2 * np.pi * at / stage.roller_count
        cosine, sine = np.cos(turn), np.sin(turn)
        frame = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        for way, damping in (
            (creep.along, creep.damping_along_slip), (creep.across, creep.damping_across_slip)
        ):  # fmt: skip
            for place in places:
                row = np.zeros(len(network.coordinates))
                arm = point + place * np.array([0.0, 0.0, 1.0])
                # Of the screw in the fixed frame, of the roller in its own.
                fixed = frame @ np.asarray(way)
                turning = np.cross(frame @ arm, fixed) / screw_radius
                own = -np.asarray(way)
                own_arm = arm - np.array([distance, 0.0, 0.0])
                own_turning = np.cross(own_arm, own) / roller_radius
                of_screw = ("x", "y", "z", "tilt_x", "tilt_y", "u")
                of_roller = ("radial", "tangential", "z", "tilt_radial", "tilt_tangential", "u")
                for name, value in zip(of_screw, (*fixed, *turning), strict=True):
                    row[network.index(f"screw {name}")] = value
                for name, value in zip(of_roller, (*own, *own_turning), strict=True):
                    row[network.index(f"roller {at + 1} {name}")] = value
                matrix += float(damping) / count * np.outer(row, row)
    return matrix


def test_the_matrix_is_that_of_single_threads():
    one = _actuator()
    system = vibration.stage_spatial_system(one, 1, 12e3, tilt=True)
    network = vibration.spatial_network(system)
    creep = _found().creep
    found = np.asarray(creep.viscous_matrix(system))
    expected = _threads_one_by_one(network, creep, one.stages[0])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_ratios_are_those_of_the_dense_eigenproblem():
    one = _actuator()
    system = vibration.stage_spatial_system(one, 1, 12e3, tilt=True)
    network = vibration.spatial_network(system)
    exact = quadratic_eigenvalues(network, np.asarray(_found().creep.viscous_matrix(system)))
    assert _found().result_name == "successful"
    assert assert_all_among(_found(), exact) >= 20


def test_frequencies_do_not_depend_on_whether_damping_is_asked_for():
    expected = prsm.spatial_modal(_actuator(), load=12e3, tilt=True).groups
    for found, group in zip(_found().modes.groups, expected, strict=True):
        near = 1e-12 * np.asarray(group.frequencies).max()
        np.testing.assert_allclose(found.frequencies, group.frequencies, rtol=1e-12, atol=near)


def test_compliance_of_the_axis_is_a_solution_of_all_coordinates():
    one = example("actuator_axis")
    hertz = 400.0
    found = axis_compliance(one, np.array([hertz]), damping=None, tilt=True)
    system = vibration.stage_spatial_system(one, 1, tilt=True)
    network = vibration.spatial_network(system)
    omega = 2 * np.pi * hertz
    matrix = np.asarray(network.stiffness_matrix()) - omega**2 * np.diag(np.asarray(network.mass))
    force = np.zeros(len(matrix))
    at = network.index("nut z")
    force[at] = 1.0
    expected = np.linalg.solve(matrix, force)[at]
    assert float(np.real(found.nut[0])) == pytest.approx(expected, rel=1e-9)
    # Below the first mode a body that may not tilt is displaced less.
    slow = np.array([1.0])
    plain, tilting = (
        float(np.real(axis_compliance(one, slow, damping=None, tilt=tilt).nut[0]))
        for tilt in (False, True)
    )
    assert 0 < plain < tilting * (1 - 1e-6)


def test_springs_and_dashpots_that_do_not_fit_are_refused():
    one = _actuator()
    for creep_tilts in (False, True):
        creep = creep_friction(one, speed=157.0, load=12e3, tilt=creep_tilts)
        system = vibration.stage_spatial_system(one, 1, 12e3, tilt=not creep_tilts)
        with pytest.raises(ValueError, match="give the same tilt"):
            creep.network(system)


def test_without_tilt_there_is_one_pair_of_dashpots():
    creep = creep_friction(_actuator(), speed=157.0, load=12e3)
    assert len(creep.dashpots) == 2
    assert all(one.roller_tilt is None for one in creep.dashpots)
