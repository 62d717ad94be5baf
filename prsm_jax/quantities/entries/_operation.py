"""Quantities of the steady operating point."""

import jax
import jax.numpy as jnp

from ..._errors import MissingDataError
from ...dynamics import free_carrier_ratio, has_contact_losses, steady_state, travel_per_turn
from ...strength import load_spectrum
from .._analysis import Analysis
from .._catalogue import quantity


@quantity(
    "efficiency",
    "η",
    "1",
    "output over input power at the operating point",
    assumes=("equal_friction",),
)
def efficiency(analysis: Analysis):
    return analysis.steady.efficiency


@quantity(
    "efficiency_forward",
    "η_f",
    "1",
    "efficiency when the screw drives the nut",
    assumes=("equal_friction",),
)
def efficiency_forward(analysis: Analysis):
    return analysis.driven(1).efficiency


@quantity(
    "efficiency_backward",
    "η_b",
    "1",
    "efficiency when the load drives the screw; negative means self-locking",
    assumes=("equal_friction",),
)
def efficiency_backward(analysis: Analysis):
    return analysis.driven(-1).efficiency


@quantity(
    "carrier_ratio",
    "ζ",
    "1",
    "carrier speed over screw speed, steady state",
    ("stage",),
    assumes=("equal_friction",),
)
def carrier_ratio(analysis: Analysis):
    if not any(has_contact_losses(stage.friction) for stage in analysis.mechanism.stages):
        # The ratio depends on geometry only; no force is needed.
        return jnp.stack([free_carrier_ratio(geometry) for geometry in analysis.kinematics])
    return analysis.steady.carrier_ratio


@quantity("drive_torque", "M_S", "N·m", "torque at the first screw", assumes=("equal_friction",))
def drive_torque(analysis: Analysis):
    return analysis.steady.drive_torque


@quantity(
    "contact_force",
    "F",
    "N",
    "normal force of the screw on one roller, sum of all threads",
    ("stage",),
    assumes=("equal_friction",),
)
def contact_force(analysis: Analysis):
    return analysis.steady.contact_force


@quantity(
    "slip_speed",
    "‖v‖",
    "m/s",
    "sliding speed of the screw on the roller",
    ("stage",),
    assumes=("equal_friction",),
)
def slip_speed(analysis: Analysis):
    return analysis.steady.slip_speed


@quantity(
    "ring_gear_force",
    "F_RG",
    "N",
    "tooth force at one end of a roller",
    ("stage",),
    assumes=("equal_friction",),
)
def ring_gear_force(analysis: Analysis):
    return analysis.steady.ring_gear_force


@quantity(
    "carrier_force",
    "F_RP",
    "N",
    "pin force at one end of a roller",
    ("stage",),
    assumes=("equal_friction",),
)
def carrier_force(analysis: Analysis):
    return analysis.steady.carrier_force


@quantity("loss_power", "P_loss", "W", "sum of all modelled losses", assumes=("equal_friction",))
def loss_power(analysis: Analysis):
    return sum(analysis.steady.losses.values(), jnp.zeros_like(analysis.steady.efficiency))


def _register_loss(name: str, description: str) -> None:
    @quantity(f"loss_{name}", f"P_{name}", "W", description, assumes=("equal_friction",))
    def loss(analysis: Analysis):
        losses = analysis.steady.losses
        if name not in losses:
            raise MissingDataError(f"the mechanism does not model the loss {name!r}")
        return losses[name]


for _name, _description in (
    ("thread_sliding", "power lost by sliding between screw and roller threads"),
    ("spin", "power lost by spin in the contact ellipses"),
    ("rolling_hysteresis", "power lost by rolling hysteresis in the contact ellipses"),
    ("spline", "power lost in the splines"),
    ("thrust_bearing", "power lost in the thrust bearings"),
    ("drag", "power lost by constant drag"),
):
    _register_loss(_name, _description)


@quantity("nut_speed", "v_n", "m/s", "axial speed of the last nut, magnitude")
def nut_speed(analysis: Analysis):
    stages = analysis.mechanism.stages
    return jnp.abs(analysis.speed) * travel_per_turn(stages, len(stages))


@quantity(
    "duty_efficiency",
    "η_duty",
    "1",
    "output over input energy of the duty cycle",
    assumes=("equal_friction",),
)
def duty_efficiency(analysis: Analysis):
    duty = _duty(analysis)
    kinematics = analysis.kinematics
    phases = jax.vmap(
        lambda speed, load: steady_state(analysis.mechanism, speed, load, kinematics)
    )(duty.speed, duty.load)
    output_energy, input_energy = (
        jnp.sum(power * duty.duration) for power in (phases.output_power, phases.input_power)
    )
    # A cycle at standstill takes no energy and has no efficiency.
    moves = input_energy != 0
    analysis.require(phases.computed.all() & load_spectrum(duty).possible & moves)
    return output_energy / jnp.where(moves, input_energy, 1.0)


def _duty(analysis: Analysis):
    duty = analysis.mechanism.duty_cycle
    if duty is None:
        raise MissingDataError("the mechanism has no duty cycle; give [[duty_cycle]] phases")
    return duty
