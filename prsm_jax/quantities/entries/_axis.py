"""Quantities of the axis around a mechanism: its frequencies in space, and its servo stiffness."""

import functools

import jax.numpy as jnp

from ..._errors import MissingDataError
from ...vibration import spatial_transverse_modes
from .._analysis import Analysis
from .._axis_modes import (
    AxialModes,
    axial_modes,
    axis_spatial_system,
    axis_stiffness,
    motor_of,
    reduced_inertia,
)
from .._catalogue import quantity

_of_axis = functools.partial(
    quantity,
    assumes=("equal_stiffness", "stiffness_without_preload"),
    shares=("operating_point",),
)


@_of_axis(
    "first_axial_frequency",
    "f_a1",
    "Hz",
    "lowest natural frequency in space, of stage and axis, with most of its strain energy in "
    "springs along the axis",
)
def first_axial_frequency(analysis: Analysis):
    return axial_modes(analysis).first(axial=True)


@_of_axis(
    "first_torsional_frequency",
    "f_u1",
    "Hz",
    "lowest natural frequency in space, of stage and axis, with most of its strain energy in "
    "torsional springs: shafts, coupling, gain of the position controller, supports, teeth",
)
def first_torsional_frequency(analysis: Analysis):
    return axial_modes(analysis).first(axial=False)


@_of_axis(
    "first_transverse_frequency",
    "f_w1",
    "Hz",
    "lowest transverse natural frequency in space (double)",
)
def first_transverse_frequency(analysis: Analysis):
    frequencies = spatial_transverse_modes(axis_spatial_system(analysis)).frequencies
    return AxialModes(frequencies, jnp.zeros_like(frequencies)).first()


@_of_axis(
    "antiresonance_frequency",
    "f_ar",
    "Hz",
    "lowest natural frequency in space with the motor held: first zero of the compliance at the "
    "motor, where the load swings and the motor stands still",
)
def antiresonance_frequency(analysis: Analysis):
    motor_of(analysis)
    return axial_modes(analysis, motor_held=True).first()


@_of_axis(
    "servo_stiffness",
    "K_sv",
    "N/m",
    "static stiffness at the load (without one, at the body that moves along the axis) with the "
    "motor held by the gain of its position controller; held rigidly without a controller",
)
def servo_stiffness(analysis: Analysis):
    return axis_stiffness(analysis, motor_held=motor_of(analysis).controller is None)


@_of_axis(
    "held_motor_stiffness",
    "K_hm",
    "N/m",
    "static stiffness at the load (without one, at the body that moves along the axis) with the "
    "motor held rigidly, as by a position controller with an integral part",
)
def held_motor_stiffness(analysis: Analysis):
    motor_of(analysis)
    return axis_stiffness(analysis, motor_held=True)


@_of_axis(
    "position_loop_frequency",
    "f_p",
    "Hz",
    "natural frequency of all that the motor moves, rigidly, on the gain of the position "
    "controller: its bandwidth",
)
def position_loop_frequency(analysis: Analysis):
    controller = motor_of(analysis).controller
    if controller is None:
        raise MissingDataError("the motor has no position controller; give [axis.motor.controller]")
    inertia = reduced_inertia(analysis)
    return jnp.sqrt(controller.proportional_gain / inertia) / (2 * jnp.pi)
