"""The mounting of the nut: between nut and load, or between nut and housing where there is none."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from scenes import example
from spatial_assembly import assembled, assert_assembled
from spatial_scenes import (
    AXIS,
    THREADS,
    axis_stage,
    modes_of,
    network_of,
    number,
    rolling_stage,
    system_of,
)
from test_analytic_axis import axis_assembled, statics

import prsm_jax as prsm
from prsm_jax.mechanism import Axis, AxisLoad, AxisShaft, Motor, Support
from prsm_jax.response import axis_compliance
from prsm_jax.stiffness import ThreadStiffness
from prsm_jax.vibration import Coordinate, spatial_harmonic_network, static_compliance

_MOUNTING = 1.3e8


def _mounted(stage, stiffness=_MOUNTING):
    """The nut on a mounting; its other supports stay."""
    support = dataclasses.replace(present(stage.nut.support), axial_stiffness=stiffness)
    return dataclasses.replace(stage, nut=dataclasses.replace(stage.nut, support=support))


def _with_tube(stiffness):
    load = dataclasses.replace(present(AXIS.load), tube_stiffness=stiffness)
    return dataclasses.replace(AXIS, load=load)


@pytest.mark.parametrize("tube", [None, 4.5e8])
def test_matrices_are_those_of_an_assembly_from_vectors(tube):
    """Mounting and thrust tube in series from the nut to the load; nothing holds the nut else."""
    bare = axis_stage(3)
    series = _MOUNTING if tube is None else tube * _MOUNTING / (tube + _MOUNTING)
    network = network_of(system_of(_mounted(bare), THREADS, axis=_with_tube(tube)))
    expected = axis_assembled(_with_tube(series), bare)
    found, expected, _ = assert_assembled(network, expected, bare)
    for name in ("load z", "nut z"):
        at = network.index(name)
        np.testing.assert_allclose(found[at], expected[at], rtol=1e-13, atol=1e-13 * found[at, at])


def test_without_a_load_the_mounting_holds_the_nut_to_the_housing():
    stage = _mounted(axis_stage(3))
    network = network_of(system_of(stage, THREADS, axis=Axis()))
    assert_assembled(network, assembled(stage), stage)


def _chain(screw, nut, load, springs):
    """Frequencies [Hz] of three masses in a row: on bearing, threads and mounting."""
    bearing, threads, mounting = springs
    stiffness = np.array(
        [
            [bearing + threads, -threads, 0.0],
            [-threads, threads + mounting, -mounting],
            [0.0, -mounting, mounting],
        ]
    )
    root = 1 / np.sqrt(np.array([screw, nut, load]))
    return np.sqrt(np.linalg.eigvalsh(root[:, None] * stiffness * root)) / (2 * np.pi)


def test_screw_nut_and_load_vibrate_as_three_masses_in_a_row():
    """Nothing turns, and rollers move with the nut: what does that is 1e9 times as stiff."""
    soft, bearing, mounting, mass = 2e7, 6e8, 9e8, 120.0
    rigid = 1e9 * soft
    stage = rolling_stage()
    stage = dataclasses.replace(
        stage,
        screw=dataclasses.replace(
            stage.screw, support=Support(axial_stiffness=bearing, torsional_stiffness=rigid)
        ),
        nut=dataclasses.replace(
            stage.nut, support=Support(axial_stiffness=mounting, torsional_stiffness=rigid)
        ),
    )
    threads = ThreadStiffness(jnp.asarray(soft), jnp.asarray(rigid))
    axis = Axis(load=AxisLoad(mass=mass))
    modes = modes_of(system_of(stage, threads, axis=axis), shapes=True)
    count = stage.roller_count
    nut = number(stage.nut.mass) + number(present(stage.ring_gear).mass)
    nut += number(present(stage.carrier).mass) + count * number(stage.roller.mass)
    springs = bearing, count * soft, mounting
    expected = _chain(number(stage.screw.mass), nut, mass, springs)
    elastic = modes.elastic_modes()[:3]
    assert [mode.family for mode in elastic] == ["axial"] * 3
    # What is 1e9 times as stiff is not rigid.
    np.testing.assert_allclose([mode.frequency for mode in elastic], expected, rtol=1e-7)
    # The first mode is below that of the load on its mounting alone.
    assert elastic[0].frequency < np.sqrt(mounting / mass) / (2 * np.pi)
    # The energy of a series under one force is shared as its compliances, if the load is heavy.
    share = elastic[0].strain["nut_support_axial"]
    compliances = 1 / np.array(springs)
    assert share == pytest.approx(compliances[2] / compliances.sum(), rel=0.05)


def test_static_compliance_at_the_load_has_the_mounting_in_series():
    stage = rolling_stage()
    place, nut = Coordinate("load", "z"), Coordinate("nut", "z")
    mounted = system_of(_mounted(stage), THREADS, axis=AXIS)
    rigid = system_of(stage, THREADS, axis=AXIS)
    change = float(statics(mounted, place)) - float(statics(rigid, place))
    # A difference of numbers that are ten times as large.
    assert change == pytest.approx(1 / _MOUNTING, rel=1e-8)
    assert float(statics(mounted, nut)) == pytest.approx(float(statics(rigid, nut)), rel=1e-9)


def _engineer(mounting):
    """A screw of 30 mm on a thrust bearing, whose nut moves 120 kg."""
    mechanism = example("actuator_axis")
    stage = mechanism.stages[0]
    support = Support(torsional_stiffness=1e15, axial_stiffness=mounting)
    stage = dataclasses.replace(stage, nut=dataclasses.replace(stage.nut, support=support))
    axis = Axis(
        motor=Motor(inertia=1e-3), shaft=AxisShaft(nut_distance=0.3), load=AxisLoad(mass=120.0)
    )
    return dataclasses.replace(mechanism, stages=(stage,), axis=axis)


def test_servo_stiffness_is_below_each_spring_of_the_series():
    names = ["servo_stiffness", "first_axial_frequency"]
    without, mounted = (prsm.compute(_engineer(one), names) for one in (None, 9e8))
    expected = 1 / (1 / float(without["servo_stiffness"]) + 1 / 9e8)
    assert float(mounted["servo_stiffness"]) == pytest.approx(expected, rel=1e-8)
    bearing = present(example("actuator_axis").stages[0].screw.support).axial_stiffness
    assert float(mounted["servo_stiffness"]) < min(9e8, number(bearing))
    assert float(mounted["first_axial_frequency"]) < float(without["first_axial_frequency"])


def test_dynamic_compliances_at_nut_and_load_are_those_of_a_mass_on_the_mounting():
    """What is behind the nut, of the compliance A, carries the mass M on the spring k."""
    hertz = np.array([40.0, 150.0, 320.0])
    found = axis_compliance(_engineer(9e8), hertz, damping=None)
    mass, spring, square = 120.0, 9e8, (2 * np.pi * hertz) ** 2
    at_nut, at_load = (np.asarray(jnp.real(one)) for one in (found.nut, present(found.load)))
    behind = 1 / (1 / at_nut - 1 / (1 / spring - 1 / (square * mass)))
    expected = 1 / (1 / (behind + 1 / spring) - square * mass)
    np.testing.assert_allclose(at_load, expected, rtol=1e-8)


def test_a_mounting_without_stiffness_leaves_the_load_alone():
    """With finite derivatives; as where in axis_axial_stiffness one spring of the series is 0."""
    stage = rolling_stage()

    @jax.jit
    def squares(mounting):
        system = prsm.vibration.spatial_system(_mounted(stage, mounting), THREADS, axis=AXIS)
        network = spatial_harmonic_network(system, 0)
        place = Coordinate("load", "z")
        at = network.coordinates.index(place)
        return network.stiffness_matrix()[at, at], static_compliance(network, place)

    zero = jnp.asarray(0.0)
    assert [float(one) for one in squares(zero)] == [0.0, np.inf]
    assert np.isfinite(jax.jacfwd(lambda one: squares(one)[0])(zero))
