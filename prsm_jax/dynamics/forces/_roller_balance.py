"""Forces on one roller from ring gear and carriers, by Newton's law."""

import contextlib

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array

from ..._errors import MissingDataError
from ...fields import Scalar
from ...mechanism import Gear, Stage, body_inertia, mean_roller_inertia, mean_roller_mass
from ...numerics import root_or_zero
from ...programs import physics
from .._kinematics import StageKinematics
from ..friction import turned
from ._chain import StageState


class RollerSupportForces(eqx.Module):
    """Forces at each end of one roller."""

    #: Tangential force of the ring gear on one end of a roller [N].
    ring_gear_tangential: Scalar
    #: Tooth force there, |F_t| / cos α_RG [N].
    ring_gear_force: Scalar
    #: Force of one carrier pin on one end of a roller [N].
    carrier_force: Scalar
    #: Residual of the roller's moment balance about its axis [N·m].
    moment_residual: Scalar


@physics("gear_tooth_force")
def _tooth_forces(gear: Gear, tangential: Scalar) -> tuple[Scalar, Scalar]:
    """Radial force (towards the axis, so negative) and magnitude of a tooth force [N]."""
    magnitude = jnp.abs(tangential)
    return -magnitude * jnp.tan(gear.pressure_angle), magnitude / jnp.cos(gear.pressure_angle)


def roller_support_forces(
    stage: Stage,
    kinematics: StageKinematics,
    state: StageState,
    carrier_acceleration: Scalar | None,
) -> RollerSupportForces:
    """Ring gear and carrier forces from the balances of one roller.

    Roller: `F n̂ + f + F_RN + 2 F_RG + 2 F_RP = m_R a_R` (Li et al. 2020, equation 17, with the
    ring gear), carrier: `−N F_RPy a = J_P ω̇` for each of the two. The moment balance about the
    roller's axis is not needed for this; its residual checks that the carrier acceleration of
    Lagrange's equations also satisfies Newton's law.

    The radial part of the ring gear force needs the pressure angle; without a gear it is 0.

    **Arguments:**

    - `stage`, `kinematics`, `state`: the stage, its kinematics and its forces.
    - `carrier_acceleration`: ω̇ [rad/s²], or `None` in a steady state, where only the centripetal
      force of the roller remains (and only if its mass is known).
    """
    thread, forces, motion = stage.thread, state.forces, state.motion
    # All in the frame of the loaded flank.
    if carrier_acceleration is not None:
        carrier_acceleration = state.flank_sign * carrier_acceleration
    nut_force = forces.nut_contact_force * kinematics.rolling.normal
    on_roller = forces.screw_on_roller + nut_force
    inward = jnp.zeros_like(forces.contact_force)
    with contextlib.suppress(MissingDataError):
        mass = mean_roller_mass(stage)
        inward = -mass * motion.carrier_speed**2 * thread.centre_distance
    pin_tangential = jnp.zeros_like(inward)
    tangential_inertia = jnp.zeros_like(inward)
    if carrier_acceleration is not None:
        tangential_inertia = mean_roller_mass(stage) * carrier_acceleration * thread.centre_distance
        if stage.carrier is not None:
            # The pin forces of all rollers accelerate both carriers together.
            inertia = stage.carrier.count * body_inertia(stage, "carrier")
            both_pins = (
                inertia
                * carrier_acceleration
                / (stage.present_roller_count * thread.centre_distance)
            )
            pin_tangential = -both_pins / 2
    gear_tangential = (tangential_inertia - on_roller[1]) / 2 - pin_tangential
    pin_radial, gear_force = (inward - on_roller[0]) / 2, jnp.abs(gear_tangential)
    if thread.family.no_gear:
        # Friction of the threads that roll takes the place of the teeth.
        gear_force = jnp.zeros_like(gear_force)
    if stage.gear is not None:
        gear_radial, gear_force = _tooth_forces(stage.gear, gear_tangential)
        # Teeth of a screw push the rollers outwards.
        outwards = kinematics.spin_sense < 0
        pin_radial = pin_radial + gear_radial if outwards else pin_radial - gear_radial

    side = kinematics.sliding
    arm, angle = side.roller_contact_radius, side.roller_angle_position
    screw_on_roller = forces.screw_on_roller
    moment = thread.roller_radius * (nut_force[1] + 2 * gear_tangential)
    across = arm * jnp.cos(angle) * screw_on_roller[1]
    if kinematics.spin_sense < 0:
        # Rollers around a held screw touch it, and its teeth, on the side of its axis.
        moment, across = -moment, -across
    moment = moment - across
    moment = moment - arm * jnp.sin(angle) * screw_on_roller[0]
    if forces.screw_moment is not None and forces.nut_moment is not None:
        moment = moment + motion.screw_sense * forces.screw_moment.total
        moment = moment + motion.nut_sense * forces.nut_moment.total
    if carrier_acceleration is not None:
        spin_acceleration = -kinematics.relative_spin_ratio * carrier_acceleration
        moment = moment - mean_roller_inertia(stage) * spin_acceleration
    return RollerSupportForces(
        ring_gear_tangential=state.flank_sign * gear_tangential,
        ring_gear_force=gear_force,
        carrier_force=root_or_zero(pin_radial**2 + pin_tangential**2),
        moment_residual=moment,
    )


def forces_by_stage(
    kinematics: tuple[StageKinematics, ...],
    states: tuple[StageState, ...],
    supports: list[RollerSupportForces],
) -> dict[str, Array]:
    """Forces of all stages, and the directions of slip, under the names that results give them."""
    no_spline = jnp.zeros_like(states[0].screw.drive_torque)
    contact_forces = [state.forces.contact_force for state in states]
    splines = [state.screw.spline_friction for state in states]
    rows: dict[str, list[Scalar]] = {
        "contact_force": contact_forces,
        "screw_roller_axial_force": [
            -force * geometry.sliding.normal[2]
            for force, geometry in zip(contact_forces, kinematics, strict=True)
        ],
        "ring_gear_force": [support.ring_gear_force for support in supports],
        "carrier_force": [support.carrier_force for support in supports],
        "spline_friction": [no_spline if spline is None else spline for spline in splines],
        "slip_direction": [turned(state.motion.direction, state.flank_sign) for state in states],
    }
    return {name: jnp.stack(row) for name, row in rows.items()}
