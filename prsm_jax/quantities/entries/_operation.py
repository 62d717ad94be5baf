"""Quantities of the steady operating point."""

import functools

import jax
import jax.numpy as jnp

from ..._errors import MissingDataError
from ...dynamics import (
    STEADY_RESULTS,
    free_carrier_ratio,
    has_contact_losses,
    roller_migration as stage_roller_migration,
    steady_state,
    travel_per_radian,
    travel_share,
)
from ...strength import load_spectrum
from .._analysis import Analysis
from .._catalogue import quantity

_with_friction = functools.partial(quantity, assumes=("equal_friction", "friction_without_preload"))


@_with_friction(
    "efficiency",
    "η",
    "1",
    "output over input power at the operating point; negative if the load drives and the thread is "
    "self-locking, or the load of a differential roller screw sinks while the screw drives",
)
def efficiency(analysis: Analysis):
    return analysis.steady.efficiency


@_with_friction(
    "efficiency_forward", "η_f", "1", "efficiency when the body that turns drives the other"
)
def efficiency_forward(analysis: Analysis):
    return analysis.driven(1).efficiency


@_with_friction(
    "efficiency_backward",
    "η_b",
    "1",
    "efficiency when the load drives; negative means self-locking",
)
def efficiency_backward(analysis: Analysis):
    return analysis.driven(-1).efficiency


@_with_friction(
    "carrier_ratio",
    "ζ",
    "1",
    "carrier speed over the speed of the body that turns, steady state",
    ("stage",),
)
def carrier_ratio(analysis: Analysis):
    stages = analysis.mechanism.stages
    families = [stage.thread.family for stage in stages]
    geometric = all(one.carrying is not None and one.lead_is_fixed for one in families)
    if geometric and not any(has_contact_losses(stage.friction) for stage in stages):
        # The ratio depends on geometry only; no force is needed.
        return jnp.stack([free_carrier_ratio(geometry) for geometry in analysis.kinematics])
    return analysis.steady.carrier_ratio


def _of_steady_state(name: str):
    return lambda analysis: getattr(analysis.steady, name)


for _name, _symbol, _unit, _description, _dimensions in (
    (
        "drive_torque",
        "M_S",
        "N·m",
        "torque at the body that turns: the first screw, or the nut of an inverted roller screw",
        (),
    ),
    (
        "contact_force",
        "F",
        "N",
        "normal force of the body that turns (the screw; the nut of an inverted roller screw) on "
        "one roller, sum of all threads",
        ("stage",),
    ),
    ("slip_speed", "‖v‖", "m/s", "sliding speed of the body that turns on the roller", ("stage",)),
    ("ring_gear_force", "F_RG", "N", "tooth force at one end of a roller", ("stage",)),
    ("carrier_force", "F_RP", "N", "pin force at one end of a roller", ("stage",)),
):
    _with_friction(_name, _symbol, _unit, _description, _dimensions)(_of_steady_state(_name))


@_with_friction("loss_power", "P_loss", "W", "sum of all modelled losses")
def loss_power(analysis: Analysis):
    return sum(analysis.steady.losses.values(), jnp.zeros_like(analysis.steady.efficiency))


def _of_loss(name: str):
    def loss(analysis: Analysis):
        losses = analysis.steady.losses
        if name not in losses:
            raise MissingDataError(f"the mechanism does not model the loss {name!r}")
        return losses[name]

    return loss


for _name, _description in (
    ("thread_sliding", "power lost by sliding in the thread contacts"),
    ("spin", "power lost by spin in the contact ellipses"),
    ("rolling_hysteresis", "power lost by rolling hysteresis in the contact ellipses"),
    ("spline", "power lost in the splines"),
    ("thrust_bearing", "power lost in the thrust bearings"),
    ("drag", "power lost by drag, constant and viscous"),
):
    _with_friction(f"loss_{_name}", f"P_{_name}", "W", _description)(_of_loss(_name))


@quantity(
    "nut_speed",
    "v_n",
    "m/s",
    "axial speed of the last nut (of the screw, if the nut turns), magnitude",
)
def nut_speed(analysis: Analysis):
    stages = analysis.mechanism.stages
    speed = jnp.abs(analysis.speed) * travel_per_radian(stages, len(stages))
    if stages[-1].thread.family.lead_is_fixed:
        return speed
    share = travel_share(stages[-1].thread, analysis.steady.carrier_ratio[-1])
    return speed if share is None else speed * jnp.abs(share)


@quantity(
    "roller_migration",
    "Δ_R",
    "m",
    "axial travel of the rollers in the nut (on the screw of an inverted roller screw) per turn of "
    "the carrier: 0 unless the gear does not match the thread; the lead of a recirculating one",
    ("stage",),
)
def roller_migration(analysis: Analysis):
    return jnp.stack([stage_roller_migration(stage) for stage in analysis.mechanism.stages])


@_with_friction("duty_efficiency", "η_duty", "1", "output over input energy of the duty cycle")
def duty_efficiency(analysis: Analysis):
    duty = analysis.require_duty_cycle()
    kinematics = analysis.kinematics
    phases = jax.vmap(
        lambda speed, load: steady_state(analysis.mechanism, speed, load, kinematics)
    )(duty.speed, duty.load)
    # A load that sinks while the screw drives gives energy to the mechanism, too.
    output, given = phases.output_power, phases.input_power
    sinks = phases.code == STEADY_RESULTS.index("sinking_load")
    given, output = jnp.where(sinks, given - output, given), jnp.where(sinks, 0.0, output)
    output_energy, input_energy = (jnp.sum(power * duty.duration) for power in (output, given))
    # A cycle at standstill takes no energy and has no efficiency.
    moves = input_energy != 0
    analysis.require(phases.computed.all() & load_spectrum(duty).possible & moves)
    return output_energy / jnp.where(moves, input_energy, 1.0)
