"""Slip at the screw–roller contact, in the frame that turns with the carrier."""

from collections.abc import Sequence

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar
from ..geometry import Meshing, mesh
from ..mechanism import Stage, Thread
from ..numerics import dot_few


class StageKinematics(eqx.Module):
    """Geometry that determines the motion of one stage.

    The slip is linear in the two speeds: `v = Ω slip_per_screw − ω (drive, 0)`. The screw thread
    advances along the roller's axis by `lead / 2π` per radian, at any speed of the carrier.
    """

    thread: Thread
    meshing: Meshing
    #: Components of `slip_per_screw` and `drive` as scalars, as in `ThreadContact`.
    slip_parts: tuple[Scalar, Scalar, Scalar]
    drive_parts: tuple[Scalar, Scalar]
    #: Contact ellipses and resisting moments of one roller at a normal force of 1 N
    #: (`_contact_losses.ContactResistance`); `None` until they are needed.
    resistance: eqx.Module | None = None

    @property
    def slip_per_screw(self) -> Float[Array, "*batch 3"]:
        """∂v/∂Ω of the slip of the screw over the roller [m/rad]."""
        return jnp.stack(self.slip_parts, axis=-1)

    @property
    def drive(self) -> Float[Array, "*batch 2"]:
        """∂/∂ω of the velocity of the roller's contact point, in the transverse plane [m/rad]."""
        return jnp.stack(self.drive_parts, axis=-1)

    @property
    def crossing(self) -> Scalar:
        """v₀ × d, of the transverse parts of the slip per screw turn and of d [m²/rad²].

        With v₀ = (−y, x) and d = v₀ + n (y, a − x) at the contact (x, y) it is −n a y. At small
        leads the slip is nearly parallel to d; the difference of products would be rounding noise.
        """
        screw = self.meshing.screw
        contact_y = screw.contact_radius * jnp.sin(screw.contact_angle_position)
        return -self.thread.starts * self.thread.centre_distance * contact_y

    @property
    def relative_spin_ratio(self) -> Scalar:
        """(n − 1): the roller turns about its axis at −(n − 1) ω."""
        return self.thread.starts - 1


def stage_kinematics(stage: Stage) -> StageKinematics:
    """Mesh one stage and collect its slip vectors (Li et al. 2020, equation 13)."""
    thread = stage.thread
    meshing = mesh(thread)
    side, starts = meshing.screw, thread.starts
    screw_angle, roller_angle = side.contact_angle_position, side.roller_angle_position
    screw_x = -side.contact_radius * jnp.sin(screw_angle)
    screw_y = side.contact_radius * jnp.cos(screw_angle)
    roller_x = side.roller_contact_radius * jnp.sin(roller_angle)
    roller_y = side.roller_contact_radius * jnp.cos(roller_angle)
    return StageKinematics(
        thread=thread,
        meshing=meshing,
        slip_parts=(screw_x, screw_y, thread.lead / (2 * jnp.pi)),
        drive_parts=(screw_x + starts * roller_x, screw_y + starts * roller_y),
    )


def slip_velocity(
    kinematics: StageKinematics, screw_speed: Scalar, carrier_speed: Scalar
) -> Float[Array, "3"]:
    """Velocity of the screw's contact point over the roller's [m/s]."""
    in_plane = kinematics.slip_per_screw[:2] * screw_speed - kinematics.drive * carrier_speed
    return jnp.concatenate([in_plane, (kinematics.slip_per_screw[2] * screw_speed)[None]])


def free_carrier_ratio(kinematics: StageKinematics) -> Scalar:
    """Steady carrier ratio ζ∞ = ω/Ω when only thread friction acts on the rollers.

    The friction then has no component along ∂v_R/∂ω. This condition is linear in ω, and depends on
    geometry alone, not on friction or load.
    """
    drive = kinematics.drive
    return dot_few(kinematics.slip_per_screw[:2], drive) / dot_few(drive, drive)


def turning_range(kinematics: StageKinematics) -> Scalar:
    """Range of carrier ratios ω/Ω about ζ∞ within which the slip turns from along d to across it.

    It is the slip across d, `√(((v₀ × d)/|d|)² + (L/2π)²)` per radian, over |d|.
    """
    drive = kinematics.drive
    square = dot_few(drive, drive)
    across = kinematics.crossing**2 / square + kinematics.slip_per_screw[2] ** 2
    return jnp.sqrt(across / square)


def ideal_carrier_ratio(thread: Thread) -> Scalar:
    """Carrier ratio of rolling without slip on the nominal circles, r_s / (2 a)."""
    return thread.screw_radius / (2 * thread.centre_distance)


def travel_per_turn(stages: Sequence[Stage], upto: int) -> Scalar:
    """Axial travel of the nut of stage `upto` (1-based count) per radian of screw turn [m/rad]."""
    travel = jnp.zeros_like(stages[0].thread.lead)
    for stage in stages[:upto]:
        travel = travel + stage.thread.lead
    return travel / (2 * jnp.pi)
