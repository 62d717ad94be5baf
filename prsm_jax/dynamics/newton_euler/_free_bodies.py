"""Newton–Euler's equations of every single body of a stage.

Vectors are in the frame that turns with the carrier: radial from the screw's axis through that of
the roller, tangential, axial. The load pushes the nut along the axis. Moments are about the axis
of the screw, those on a roller about its own. As in the rest of this room "screw" is the body that
turns and on which rollers slide, "nut" the one that is held and on which they roll; an inverted
roller screw is looked at from the other end, so that its load, too, pushes the "nut" along the
axis.
"""

import dataclasses
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...mechanism import Gear, Stage
from ...programs import physics
from .._kinematics import StageKinematics, slip_velocity
from ..friction import (
    Rubbing,
    Slip,
    friction_on_roller,
    law_inputs_of,
    rubbing,
    rubbing_of,
    slip_direction,
    turned,
)
from ._part_masses import PartMasses


class StageUnknowns(NamedTuple):
    """Unknowns of the equations of one stage; all as forces [N]."""

    #: Normal force of the screw on one roller, negative where the opposite flanks carry.
    screw_contact: Scalar
    #: Normal force of the nut on one roller.
    nut_contact: Scalar
    #: Tangential force of the ring gear on one end of a roller.
    ring_gear: Scalar
    #: Force of one carrier's pin on one end of a roller.
    pin_radial: Scalar
    pin_tangential: Scalar
    #: ω̇ times the reference of `PartMasses.reference`.
    carrier_acceleration: Scalar
    #: Axial force of the nut on its carriers.
    carrier_axial: Scalar
    #: Axial force of the screw on its support: the previous nut, or the housing.
    support: Scalar
    #: Torque of the spline (or motor) over the nominal radius of the screw.
    drive_torque: Scalar
    #: Friction of the spline on the screw.
    spline_friction: Scalar
    #: Friction torque of the thrust bearing over the nominal radius of the screw.
    bearing_torque: Scalar
    #: Torque that keeps the nut from turning, over its nominal radius.
    anti_rotation: Scalar


class ScrewAcceleration(NamedTuple):
    """Ω̇ of the screws, and z̈ of the nut and of the screw of one stage."""

    turning: Scalar
    nut: Scalar
    screw: Scalar


class StageSurroundings(eqx.Module):
    """Known quantities of a stage: motion, and friction other than that of the threads."""

    screw_speed: Scalar
    carrier_speed: Scalar
    #: Unit vector of the slip; `None` takes it from the slip itself.
    slip_direction: Float[Array, "3"] | None
    #: Deflection of the bristles between the threads, if their law has bristles [m].
    deflection: Float[Array, "3"] | None
    #: Sense of turning of screw over roller, Ω + (n − 1) ω, and of roller over nut.
    screw_sense: Scalar
    nut_sense: Scalar
    #: Spline friction per drive torque [1/m], and independent of it [N].
    spline: tuple[Scalar, Scalar]
    #: Bearing torque per axial force [m], and independent of it [N·m].
    bearing: tuple[Scalar, Scalar]
    drag_torque: Scalar
    #: Accelerations, if the screw accelerates.
    acceleration: ScrewAcceleration | None


class FromNext(NamedTuple):
    """Forces of the following screw (or the load) on the nut and the screw of a stage."""

    #: Axial force on the nut.
    load: Scalar
    #: Torque that the spline takes from the screw, friction of the spline, torque of the thrust
    #: bearing on the nut.
    drive_torque: Scalar
    spline_friction: Scalar
    bearing_torque: Scalar


class RollerForces(NamedTuple):
    """Forces on one roller; those of ring gear and pin at each end."""

    normal: Float[Array, "3"]
    friction: Float[Array, "3"]
    nut: Float[Array, "3"]
    ring_gear: Float[Array, "3"]
    pin: Float[Array, "3"]


def outside_of(kinematics: StageKinematics) -> int:
    """+1 where rollers roll on the body around them, −1 where on the one that they surround."""
    return kinematics.spin_sense


def radii_of(stage: Stage) -> tuple[Scalar, Scalar]:
    """Nominal radii of the body that is held and of the one that turns [m]."""
    thread = stage.thread
    if thread.family.turning == "screw":
        return thread.nut_radius, thread.screw_radius
    return thread.screw_radius, thread.nut_radius


def flank_of(unknowns: StageUnknowns) -> Scalar:
    """+1 where the usual flanks carry, −1 where the opposite flanks do."""
    return jnp.where(unknowns.screw_contact < 0, -1.0, 1.0).astype(unknowns.screw_contact.dtype)


def slip_of(kinematics: StageKinematics, known: StageSurroundings, flank_sign: Scalar) -> Slip:
    """Slip of the screw over the roller."""
    slip = turned(
        slip_velocity(kinematics, flank_sign * known.screw_speed, flank_sign * known.carrier_speed),
        flank_sign,
    )
    direction = slip_direction(slip) if known.slip_direction is None else known.slip_direction
    return Slip(slip, direction, known.screw_speed, known.carrier_speed)


def seen_from_flank(slip: Slip, flank_sign: Scalar) -> Slip:
    """The slip in the frame of the loaded flank, or back from it."""
    return Slip(
        turned(slip.velocity, flank_sign),
        turned(slip.direction, flank_sign),
        flank_sign * slip.screw_speed,
        flank_sign * slip.carrier_speed,
    )


def rubbing_on_screw_side(
    stage: Stage, kinematics: StageKinematics, known: StageSurroundings, unknowns: StageUnknowns
) -> Rubbing | None:
    """Slip and spin in the ellipse of the screw side, where that is modelled."""
    ellipse = rubbing_of(stage, kinematics)
    if ellipse is None:
        return None
    flank_sign = flank_of(unknowns)
    slip = seen_from_flank(slip_of(kinematics, known, flank_sign), flank_sign)
    law = stage.thread_law
    rub = rubbing(ellipse, kinematics, slip, jnp.abs(unknowns.screw_contact), law)
    return dataclasses.replace(rub, direction=turned(rub.direction, flank_sign))


def roller_forces(
    stage: Stage,
    kinematics: StageKinematics,
    known: StageSurroundings,
    unknowns: StageUnknowns,
) -> RollerForces:
    """The unknowns of a roller as vectors (Li et al. 2020, equations 9 to 16).

    With the opposite flanks loaded, all contacts lie as after a half turn about the radial axis.
    """
    flank_sign, tooth = flank_of(unknowns), unknowns.ring_gear
    slip, force = slip_of(kinematics, known, flank_sign), jnp.abs(unknowns.screw_contact)
    law = stage.thread_law
    rub = rubbing_on_screw_side(stage, kinematics, known, unknowns)
    law_inputs = {}
    if law is not None:
        law_inputs = law_inputs_of(law, kinematics, seen_from_flank(slip, flank_sign), force)
    per_force, constant = friction_on_roller(stage, slip, known.deflection, rub, law_inputs)
    zero = jnp.zeros_like(tooth)
    separating = zero
    if stage.gear is not None:
        separating = outside_of(kinematics) * _separating_force(stage.gear, tooth)
    return RollerForces(
        normal=force * turned(kinematics.sliding.normal, flank_sign),
        friction=force * per_force + constant,
        nut=unknowns.nut_contact * turned(kinematics.rolling.normal, flank_sign),
        ring_gear=jnp.stack([separating, tooth, zero]),
        pin=jnp.stack([unknowns.pin_radial, unknowns.pin_tangential, zero]),
    )


@physics("gear_tooth_force")
def _separating_force(gear: Gear, tangential: Scalar) -> Scalar:
    return -jnp.abs(tangential) * jnp.tan(gear.pressure_angle)


def roller_acceleration(
    stage: Stage, known: StageSurroundings, carrier_acceleration: Scalar
) -> Float[Array, "3"]:
    """Acceleration of a roller's centre of mass [m/s²]."""
    distance = stage.thread.centre_distance
    inward = -(known.carrier_speed**2) * distance
    axial = jnp.zeros_like(inward) if known.acceleration is None else known.acceleration.nut
    return jnp.stack([inward, carrier_acceleration * distance, axial])


@physics("free_bodies")
def unbalanced(
    stage: Stage,
    kinematics: StageKinematics,
    masses: PartMasses,
    known: StageSurroundings,
    unknowns: StageUnknowns,
    following: FromNext,
    moments: tuple[Scalar, Scalar],
) -> list[Scalar]:
    """Residuals of forces minus inertia of every body, and of the friction laws [N].

    Li et al. 2020, equations 17 to 28, with the ring gear on both ends of the roller, Newton's law
    in all directions, all rollers on screw and nut, and the travel of all previous stages.

    **Arguments:**

    - `stage`, `kinematics`, `masses`, `known`: one stage and its known quantities.
    - `unknowns`: its forces.
    - `following`: forces of the following stage, or of the load.
    - `moments`: resisting moments in the contacts of one roller with screw and nut [N·m].
    """
    thread, count = stage.thread, stage.present_roller_count
    side, flank_sign = kinematics.sliding, flank_of(unknowns)
    outside = outside_of(kinematics)
    acceleration = unknowns.carrier_acceleration / masses.reference
    forces = roller_forces(stage, kinematics, known, unknowns)
    on_screw_side, on_nut_side = known.screw_sense * moments[0], known.nut_sense * moments[1]
    by_screw = forces.normal + forces.friction

    # Roller. Pins and the radial force of the teeth pass through its axis.
    centre = roller_acceleration(stage, known, acceleration)
    inertia = jnp.stack([masses.circling_mass, masses.roller_mass, masses.roller_mass]) * centre
    force = by_screw + forces.nut + 2 * forces.ring_gear + 2 * forces.pin - inertia
    position = flank_sign * side.roller_angle_position
    # The body that slides is inside of the roller, and the one that it rolls on outside of it.
    across = -outside * jnp.cos(position)
    roller_arm = side.roller_contact_radius * jnp.stack([across, jnp.sin(position)])
    spin_acceleration = -kinematics.relative_spin_ratio * acceleration
    moment = (
        _moment(roller_arm, by_screw)
        + outside * thread.roller_radius * (forces.nut[1] + 2 * forces.ring_gear[1])
        + on_screw_side
        + on_nut_side
        - masses.roller_inertia * spin_acceleration
    )

    # Carriers.
    distance = thread.centre_distance
    carriers = -2 * count * distance * forces.pin[1] - masses.carrier_inertia * acceleration
    carriers_axial = unknowns.carrier_axial

    # Nut, with the ring gears in it.
    nut_axial = following.load - count * forces.nut[2] - unknowns.carrier_axial
    held, turning = radii_of(stage)
    nut_moment = (
        held * (unknowns.anti_rotation - count * forces.nut[1])
        - 2 * count * held * forces.ring_gear[1]
        - count * on_nut_side
        + following.bearing_torque
        + known.drag_torque
    )

    # Screw.
    torque, bearing = turning * unknowns.drive_torque, turning * unknowns.bearing_torque
    screw_axial = (
        unknowns.spline_friction
        - unknowns.support
        - following.spline_friction
        - count * by_screw[2]
    )
    position = flank_sign * side.contact_angle_position
    screw_arm = side.contact_radius * jnp.stack([jnp.cos(position), jnp.sin(position)])
    screw_moment = (
        torque
        - following.drive_torque
        - bearing
        - known.drag_torque
        - count * (_moment(screw_arm, by_screw) + on_screw_side)
    )

    if known.acceleration is not None:
        inertia = _inertia_of_screw_and_nut(masses, known.acceleration)
        carriers_axial = carriers_axial - inertia.carriers
        nut_axial = nut_axial - inertia.nut
        screw_axial, screw_moment = screw_axial - inertia.screw, screw_moment - inertia.turning
    spline = known.spline[0] * jnp.abs(torque) + known.spline[1]
    thrust = known.bearing[0] * jnp.abs(unknowns.support) + known.bearing[1]
    return [
        force[0],
        force[1],
        force[2],
        moment / thread.roller_radius,
        carriers / (count * distance),
        carriers_axial,
        nut_axial,
        nut_moment / held,
        screw_axial,
        screw_moment / turning,
        unknowns.spline_friction - spline,
        (bearing - thrust) / turning,
    ]


class _Inertia(NamedTuple):
    carriers: Scalar
    nut: Scalar
    screw: Scalar
    turning: Scalar


@physics("screw_inertia")
def _inertia_of_screw_and_nut(masses: PartMasses, acceleration: ScrewAcceleration) -> _Inertia:
    """Masses times accelerations along the axis, and of the screw about it."""
    return _Inertia(
        masses.carrier_mass * acceleration.nut,
        masses.nut_mass * acceleration.nut,
        masses.screw_mass * acceleration.screw,
        masses.screw_inertia * acceleration.turning,
    )


def _moment(arm: Float[Array, "2"], force: Float[Array, "3"]) -> Scalar:
    """Moment about the axis."""
    return arm[0] * force[1] - arm[1] * force[0]
