"""Quantities of the axis: derivatives through contacts and meshing, limits, and absent parts."""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from scenes import example
from spatial_scenes import AXIS, THREADS, axis_stage, system_of

import prsm_jax as prsm
from prsm_jax.mechanism import Axis, AxisLoad, AxisShaft, FarBearing, Motor
from prsm_jax.vibration import (
    Coordinate,
    axial_torsional_modes,
    spatial_harmonic_network,
    static_compliance,
)

_VARIABLES = ("lead", "contact_angle", "roller_radius", "axis.shaft.nut_distance")
_QUANTITIES = (
    "first_axial_frequency",
    "first_torsional_frequency",
    "first_transverse_frequency",
    "antiresonance_frequency",
    "position_loop_frequency",
    "servo_stiffness",
    "held_motor_stiffness",
)
_axial = eqx.filter_jit(axial_torsional_modes)


def _logarithms(mechanism, changes):
    for variable, change in zip(_VARIABLES, changes, strict=True):
        value = prsm.get_parameter(mechanism, variable)
        mechanism = prsm.set_parameter(mechanism, variable, value * (1 + change))
    return jnp.log(jnp.stack(list(prsm.compute(mechanism, _QUANTITIES).values())))


@functools.cache
def _program():
    """Values, and slopes along a direction: one program."""
    return eqx.filter_jit(
        lambda mechanism, at, direction: jax.jvp(
            lambda c: _logarithms(mechanism, c), (at,), (direction,)
        )
    )


@functools.cache
def _reverse():
    return eqx.filter_jit(
        lambda mechanism, weights: jax.grad(lambda c: weights @ _logarithms(mechanism, c))(
            jnp.zeros(len(_VARIABLES))
        )
    )


def test_forward_and_reverse_derivatives_are_central_differences():
    mechanism = example("actuator_axis")
    program, unit = _program(), jnp.eye(len(_VARIABLES))
    slopes = []
    for direction in unit:
        slope = np.asarray(program(mechanism, 0 * direction, direction)[1])
        inner, outer = (
            (
                np.asarray(program(mechanism, h * direction, direction)[0])
                - np.asarray(program(mechanism, -h * direction, direction)[0])
            )
            / (2 * h)
            for h in (1e-3, 2e-3)
        )
        # Of fourth order: 1e-12; rounding 1e-14/1e-3.
        np.testing.assert_allclose(slope, (4 * inner - outer) / 3, rtol=0, atol=2e-10)
        slopes.append(slope)
    slopes = np.stack(slopes, axis=1)
    # Each variable moves each frequency in space, and the stiffness.
    assert (np.abs(slopes[0]) > 1e-4).all()
    assert (np.abs(slopes[5]) > 1e-6).all()
    weights = np.cos(np.arange(len(_QUANTITIES)))
    pulled = _reverse()(mechanism, jnp.asarray(weights))
    np.testing.assert_allclose(pulled, weights @ slopes, rtol=0, atol=1e-12)


def test_quantities_are_numbers_of_the_modes():
    mechanism = example("actuator_axis")
    values = prsm.compute(mechanism, _QUANTITIES)
    modes = prsm.spatial_modal(mechanism)
    families, frequencies = modes.families, np.asarray(modes.frequencies)
    for family in ("axial", "torsional", "transverse"):
        first = frequencies[families.index(family)]
        assert float(values[f"first_{family}_frequency"]) == pytest.approx(first, rel=1e-12)
    held = prsm.spatial_modal(mechanism, motor_held=True)
    group = np.asarray(present(held.group("axial_torsional")).frequencies)
    least = group[group > 1e-10 * group[-1]][0]
    assert float(values["antiresonance_frequency"]) == pytest.approx(least, rel=1e-12)
    # All that the motor moves, on its gain; the springs of the axis are much stiffer.
    assert values["first_torsional_frequency"] < values["position_loop_frequency"]
    assert values["first_torsional_frequency"] > 0.9 * values["position_loop_frequency"]
    assert values["servo_stiffness"] < values["held_motor_stiffness"]
    lever = float(prsm.get_parameter(mechanism, "lead")) / (2 * np.pi)
    gain = 1 / values["servo_stiffness"] - 1 / values["held_motor_stiffness"]
    assert float(gain) == pytest.approx(lever**2 / 60.0, rel=1e-9)


def test_sensitivities_are_half_the_energies_of_the_springs():
    """By the names of the file, through the whole chain."""
    mechanism = example("actuator_axis")
    springs = {
        "tube_stiffness": "thrust_tube",
        "coupling_stiffness": "coupling",
        "proportional_gain": "position_gain",
        "screw.support.axial_stiffness": "screw_support_axial",
    }
    table = prsm.sensitivity(
        mechanism, quantities=["first_axial_frequency"], parameters=list(springs)
    )
    modes = prsm.spatial_modal(mechanism, shapes=True).elastic_modes()
    first = next(mode for mode in modes if mode.family == "axial")
    shares = [first.strain[name] / 2 for name in springs.values()]
    # Both are sums over springs, in which nothing cancels.
    np.testing.assert_allclose(np.ravel(table.elasticity), shares, rtol=1e-9)


def test_a_part_that_is_absent_leaves_no_trace():
    mechanism = dataclasses.replace(example("wu2022"), stages=(axis_stage(),))

    def traced(axis):
        one = dataclasses.replace(mechanism, axis=axis)
        return prsm.programs.traced_physics(prsm.spatial_modal, one)

    assert "axis_system" in traced(AXIS)
    assert "axis_system" not in traced(None)

    def springs(axis):
        system = system_of(axis_stage(), THREADS, axis=axis)
        return {spring.name for spring in spatial_harmonic_network(system, 0).springs}

    none = springs(Axis())
    assert springs(Axis(load=AxisLoad(mass=10.0))) == none
    assert springs(Axis(motor=Motor(inertia=1e-3))) == none
    assert springs(Axis(motor=Motor(1e-3, coupling_stiffness=1e4))) - none == {"coupling"}
    shaft = {"screw_shaft_axial", "screw_shaft_torsional", "screw_support_torsional"}
    assert springs(Axis(shaft=AxisShaft(0.2))) - none == shaft - none
    assert springs(Axis(load=AxisLoad(10.0, 1e8))) - none == {"thrust_tube"}


def _lowest(axis, count=7):
    system = system_of(axis_stage(), THREADS, axis=axis)
    # The number of rollers is traced: one program for all.
    system = eqx.tree_at(lambda s: s.roller_count, system, jnp.asarray(count))
    frequencies = np.asarray(_axial(system)[0].frequencies)
    assert np.isfinite(frequencies).all()
    return frequencies[frequencies > 1e-12 * frequencies[-1]]


def test_springs_of_very_different_stiffness():
    """A coupling 1e12 times as stiff is no coupling; one as much softer leaves the motor alone."""
    base = Axis(motor=Motor(1e-3, coupling_stiffness=1e4), load=AxisLoad(100.0, 1e8))

    def coupled(stiffness):
        return eqx.tree_at(lambda a: a.motor.coupling_stiffness, base, jnp.asarray(stiffness))

    rigid = dataclasses.replace(base, motor=Motor(1e-3))
    stiff = _lowest(coupled(1e16))
    np.testing.assert_allclose(stiff[:4], _lowest(rigid)[:4], rtol=1e-9)
    # Motor and screw against each other, on the spring: J is that of the screw and the motor.
    inertia = 1 / (1 / 1e-3 + 1 / float(present(axis_stage().screw.inertia)))
    expected = np.sqrt(1e16 / inertia) / (2 * np.pi)
    assert stiff[-1] == pytest.approx(expected, rel=1e-6)
    alone = dataclasses.replace(base, motor=None)
    np.testing.assert_allclose(_lowest(coupled(1e-8))[-4:], _lowest(alone)[-4:], rtol=1e-9)


@pytest.mark.parametrize("count", [3, 12, 30])
def test_any_number_of_rollers(count):
    """More rollers in parallel are stiffer threads: with N k constant the first mode hardly moves.

    N times the mass of a roller moves with the nut, which a load of 150 kg does not feel.
    """
    system = system_of(axis_stage(), THREADS, axis=AXIS)
    springs = tuple(
        dataclasses.replace(one, stiffness=7 / count * one.stiffness) for one in system.springs
    )
    system = dataclasses.replace(system, springs=springs, roller_count=jnp.asarray(count))
    found = np.asarray(_axial(system)[0].frequencies)
    np.testing.assert_allclose(found[:2], _lowest(AXIS)[:2], rtol=1e-2)
    assert np.isfinite(found).all()


def test_a_lead_near_zero_leaves_a_load_on_its_springs_and_a_motor_on_its_gain():
    stage = axis_stage()
    flat = eqx.tree_at(lambda s: s.thread.lead, stage, jnp.asarray(1e-9))
    found = np.asarray(_axial(system_of(flat, THREADS, axis=AXIS))[0].frequencies)
    assert np.isfinite(found).all()
    inertia = 3e-3 + float(present(stage.screw.inertia))
    # Springs between motor and screw are 500 times stiffer than the gain.
    assert found[0] == pytest.approx(np.sqrt(60.0 / inertia) / (2 * np.pi), rel=1e-3)


def test_static_compliance_is_infinite_where_a_rigid_motion_moves_the_load():
    axis = dataclasses.replace(AXIS, motor=Motor(1e-3), shaft=None)
    system = system_of(axis_stage(), THREADS, axis=axis)
    found = eqx.filter_jit(
        lambda s: static_compliance(spatial_harmonic_network(s, 0), Coordinate("load", "z"))
    )(system)
    assert np.isinf(found)


def test_what_does_not_fit_is_refused():
    mechanism, stage = example("wu2022"), axis_stage()
    with pytest.raises(ValueError, match="torsional_stiffness holds against turning"):
        dataclasses.replace(mechanism, axis=AXIS)
    two = dataclasses.replace(mechanism, stages=(stage, stage))
    with pytest.raises(ValueError, match="has 2 stages"):
        dataclasses.replace(two, axis=AXIS)
    alone = dataclasses.replace(mechanism, stages=(stage,))
    for shaft, message in (
        (AxisShaft(0.4), "is 0.4 m; it must be less than .* .stage.screw.length., 400 mm"),
        (AxisShaft(0.3, FarBearing(0.3, 1e8)), "less than the far bearing's distance, 300 mm"),
        (AxisShaft(0.3, FarBearing(0.41, 1e8)), "at most the screw's length .*, 400 mm"),
    ):
        with pytest.raises(ValueError, match=message):
            dataclasses.replace(alone, axis=Axis(shaft=shaft))
    whole = dataclasses.replace(alone, axis=AXIS)
    with pytest.raises(ValueError, match=r"nut_distance is 0\.5 m"):
        prsm.set_parameter(whole, "nut_distance", 0.5)
    for axis, quantity, message in (
        (None, "first_axial_frequency", r"no axis around it; give \[axis\]"),
        (Axis(), "antiresonance_frequency", r"give \[axis.motor\]"),
        (Axis(motor=Motor(1e-3)), "position_loop_frequency", "no position controller"),
    ):
        with pytest.raises(prsm.MissingDataError, match=message):
            prsm.compute(dataclasses.replace(alone, axis=axis), [quantity])
    with pytest.raises(ValueError, match="motor_held is True"):
        prsm.spatial_modal(alone, motor_held=True)
