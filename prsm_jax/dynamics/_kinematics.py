"""Slip where rollers slide, in the frame that turns with the carrier.

Rollers of a standard roller screw slide on its screw and roll in its nut; those of an inverted one
slide in its nut and roll on its screw. The equations are the same in the frame of the body that is
held against rotation, with the speed Ω of the other body, which the motor turns. Names in this room
are those of the standard type: "screw" is the body that turns, "nut" the one that is held.
"""

import dataclasses
from collections.abc import Sequence
from warnings import warn

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar
from ..geometry import Meshing, ThreadContact, mesh
from ..mechanism import Stage, Thread
from ..numerics import dot_few


class StageKinematics(eqx.Module):
    """Geometry that determines the motion of one stage.

    The slip is linear in the two speeds: `v = Ω slip_per_screw − ω (drive, axial_drive)`. The screw
    thread advances along the roller's axis by `lead / 2π` per radian, at any speed of the carrier,
    unless the nut has grooves: then by `lead / 2π` per radian of screw over carrier.
    """

    thread: Thread
    meshing: Meshing
    #: Components of `slip_per_screw` and `drive` as scalars, as in `ThreadContact`.
    slip_parts: tuple[Scalar, Scalar, Scalar]
    drive_parts: tuple[Scalar, Scalar]
    #: −∂v_z/∂ω of the slip; `None` where it is 0 [m/rad].
    axial_drive: Scalar | None = None
    #: Contact ellipses and resisting moments of one roller at a normal force of 1 N
    #: (`_contact_losses.ContactResistance`); `None` until they are needed.
    resistance: eqx.Module | None = None

    @property
    def sliding(self) -> ThreadContact:
        """Contact on which the rollers slide, in the frame in which it presses them towards −z."""
        return _sliding_side(self.thread, self.meshing)

    @property
    def rolling(self) -> ThreadContact:
        """Contact on which the rollers roll, in the same frame."""
        if self.thread.family.turning == "screw":
            return self.meshing.nut
        return turned_contact(self.meshing.screw)

    @property
    def rolling_ratio(self) -> Scalar:
        """κ: against the carrier, a roller turns at −κ ω; n in a standard roller screw."""
        return self.thread.rolling_ratio

    @property
    def spin_sense(self) -> int:
        """Sign of `relative_spin_ratio`."""
        return -1 if self.thread.family.carrying == "screw" else 1

    @property
    def slip_per_screw(self) -> Float[Array, "*batch 3"]:
        """∂v/∂Ω of the slip of the screw over the roller [m/rad]."""
        return jnp.stack(self.slip_parts, axis=-1)

    @property
    def drive(self) -> Float[Array, "*batch 2"]:
        """∂/∂ω of the velocity of the roller's contact point, in the transverse plane [m/rad]."""
        return jnp.stack(self.drive_parts, axis=-1)

    @property
    def reach(self) -> Scalar:
        """|d|, change of the slip per radian of the carrier [m/rad]."""
        square = dot_few(self.drive, self.drive)
        return jnp.sqrt(square if self.axial_drive is None else square + self.axial_drive**2)

    def along(self, vector: Float[Array, "3"]) -> Scalar:
        """Product of a vector with d, −∂v/∂ω."""
        product = dot_few(vector[:2], self.drive)
        return product if self.axial_drive is None else product + self.axial_drive * vector[2]

    @property
    def crossing(self) -> Scalar:
        """v₀ × d, of the transverse parts of the slip per screw turn and of d [m²/rad²].

        With v₀ = (−y, x) and d = v₀ + κ (y, a − x) at the contact (x, y) it is −κ a y. At small
        leads the slip is nearly parallel to d; the difference of products would be rounding noise.
        """
        screw = self.sliding
        contact_y = screw.contact_radius * jnp.sin(screw.contact_angle_position)
        return -self.rolling_ratio * self.thread.centre_distance * contact_y

    @property
    def relative_spin_ratio(self) -> Scalar:
        """κ − 1: the roller turns about its axis at −(κ − 1) ω; n − 1 in a standard one."""
        return self.rolling_ratio - 1


def stage_kinematics(stage: Stage) -> StageKinematics:
    """Mesh one stage and collect its slip vectors (Li et al. 2020, equation 13)."""
    thread = stage.thread
    meshing = mesh(thread)
    side, ratio = _sliding_side(thread, meshing), thread.rolling_ratio
    screw_angle, roller_angle = side.contact_angle_position, side.roller_angle_position
    screw_x = -side.contact_radius * jnp.sin(screw_angle)
    screw_y = side.contact_radius * jnp.cos(screw_angle)
    roller_x = side.roller_contact_radius * jnp.sin(roller_angle)
    roller_y = side.roller_contact_radius * jnp.cos(roller_angle)
    if thread.family.turning == "nut":
        # In the nut the contact lies beyond the roller's axis.
        roller_y = -roller_y
    axial = thread.lead / (2 * jnp.pi)
    return StageKinematics(
        thread=thread,
        meshing=meshing,
        slip_parts=(screw_x, screw_y, axial),
        drive_parts=(screw_x + ratio * roller_x, screw_y + ratio * roller_y),
        axial_drive=None if thread.family.lead_is_fixed else axial,
    )


def _sliding_side(thread: Thread, meshing: Meshing) -> ThreadContact:
    return meshing.screw if thread.family.turning == "screw" else turned_contact(meshing.nut)


def turned_contact(contact: ThreadContact) -> ThreadContact:
    """A contact after half a turn about the line of centres: y and z change their signs."""
    x, y, z = contact.normal_parts
    return dataclasses.replace(
        contact,
        contact_angle_position=-contact.contact_angle_position,
        roller_angle_position=-contact.roller_angle_position,
        normal_parts=(x, -y, -z),
    )


def slip_velocity(
    kinematics: StageKinematics, screw_speed: Scalar, carrier_speed: Scalar
) -> Float[Array, "3"]:
    """Velocity of the screw's contact point over the roller's [m/s]."""
    in_plane = kinematics.slip_per_screw[:2] * screw_speed - kinematics.drive * carrier_speed
    axial = kinematics.slip_per_screw[2] * screw_speed
    if kinematics.axial_drive is not None:
        axial = axial - kinematics.axial_drive * carrier_speed
    return jnp.concatenate([in_plane, axial[None]])


def free_carrier_ratio(kinematics: StageKinematics) -> Scalar:
    """Steady carrier ratio ζ∞ = ω/Ω when only thread friction acts on the rollers.

    The friction then has no component along ∂v_R/∂ω. This condition is linear in ω, and depends on
    geometry alone, not on friction or load.
    """
    drive = kinematics.drive
    along, square = dot_few(kinematics.slip_per_screw[:2], drive), dot_few(drive, drive)
    if kinematics.axial_drive is not None:
        along = along + kinematics.slip_per_screw[2] * kinematics.axial_drive
        square = square + kinematics.axial_drive**2
    return along / square


def turning_range(kinematics: StageKinematics) -> Scalar:
    """Range of carrier ratios ω/Ω about ζ∞ within which the slip turns from along d to across it.

    It is the slip across d, `√(((v₀ × d)/|d|)² + (L/2π)²)` per radian, over |d|.
    """
    drive = kinematics.drive
    square = dot_few(drive, drive)
    across = kinematics.crossing**2 / square + kinematics.slip_per_screw[2] ** 2
    return jnp.sqrt(across / square)


def ideal_carrier_ratio(thread: Thread) -> Scalar:
    """Carrier ratio of rolling without slip on the nominal circles: r_s / (2 a), or r_n / (2 a).

    The radius is that of the body that turns; the ratio is carrier speed over its speed.
    """
    return thread.ideal_carrier_ratio


def travel_per_radian(stages: Sequence[Stage], upto: int) -> Scalar:
    """Axial travel of the nut of stage `upto` (1-based count) per radian of screw turn [m/rad].

    If the nut has grooves, times 1 − ζ with the carrier ratio ζ (`travel_share`).
    """
    travel = jnp.zeros_like(stages[0].thread.lead)
    for stage in stages[:upto]:
        travel = travel + stage.thread.lead
    return travel / (2 * jnp.pi)


def travel_per_turn(stages: Sequence[Stage], upto: int) -> Scalar:
    """Old name of `travel_per_radian`: its unit is m/rad, and "turn" suggested m per revolution."""
    warn("travel_per_turn: the name is now travel_per_radian", DeprecationWarning, stacklevel=2)
    return travel_per_radian(stages, upto)


def travel_share(thread: Thread, carrier_ratio: Scalar) -> Scalar | None:
    """Axial travel per turn over the lead, 1 − ζ if the nut has grooves; `None` where it is 1."""
    return None if thread.family.lead_is_fixed else 1 - carrier_ratio


def roller_migration(stage: Stage) -> Scalar:
    r"""Axial travel of the rollers in the held body per turn of the carrier over it [m].

    In a standard roller screw $p\,(n - z_r/z_R)$ with the teeth of ring gear and roller: 0 if gear
    and thread match. In an inverted one it is the travel on the screw, with its teeth. Where no
    gear determines their rotation rollers roll without slip; those of a recirculating roller screw
    advance in the nut by its lead, and a cam lifts them back (Jones and Velinsky 2012).
    """
    thread, gear = stage.thread, stage.gear
    if thread.family.carrying is None:
        return thread.lead
    if gear is None or gear.ring_teeth is None or gear.roller_teeth is None:
        return jnp.zeros_like(thread.lead)
    return thread.pitch * (thread.starts - gear.ring_teeth / gear.roller_teeth)
