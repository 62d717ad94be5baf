"""One stage in a few scalars, for the many evaluations of an integrator.

The slip is linear in the two speeds, `v = Ω v₀ − ω (d, 0)`, and thread friction is parallel to it.
So its part along d, `s = Ω v₀·d/|d| − ω |d|`, determines friction, because the other part depends
on the screw speed alone: `‖v‖² = s² + Ω² q²`. Forces on all parts need vectors; the equation of
motion does not.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp

from ...fields import Scalar
from ...mechanism import Stage
from ...numerics import above_or_nan, dot_few, inverse_root, quotient
from ...programs import physics
from .._kinematics import StageKinematics
from ..friction import friction_coefficient, has_contact_losses


class ReducedStage(eqx.Module):
    """Geometry of a stage's slip as scalars, lengths per radian [m]."""

    #: Slip along d per radian of screw turn, v₀·d/|d|.
    along: Scalar
    #: Slip across d per radian of screw turn, q.
    across: Scalar
    #: Axial slip per radian of screw turn, L/2π.
    axial: Scalar
    #: |d|, change of the slip per radian of carrier rotation.
    drive: Scalar
    #: Contact radius at the screw.
    contact_radius: Scalar
    #: Moment of the unit normal about the screw's axis [m].
    normal_moment: Scalar
    #: |n_z|.
    normal_axial: Scalar


class ReducedForces(NamedTuple):
    """Forces of a stage on its screw and its carrier."""

    #: Torque of all rollers on the screw [N·m].
    torque_on_screw: Scalar
    #: Axial force of all rollers on the screw [N].
    axial_on_screw: Scalar
    #: Generalised force of all rollers on the carrier speed [N·m].
    carrier_drive: Scalar


def is_reducible(stage: Stage) -> bool:
    """Whether the scalars suffice.

    They do not with losses inside the contact ellipses, nor with a friction law that asks for more
    than the slip speed, nor where the carriers move the nut along the axis.
    """
    law = stage.thread_law
    asks = law is not None and law.asks
    return stage.thread.family.lead_is_fixed and not (has_contact_losses(stage.friction) or asks)


def reduced_stage(kinematics: StageKinematics) -> ReducedStage:
    """Collect the scalars of a stage."""
    drive, slip, screw = kinematics.drive, kinematics.slip_per_screw, kinematics.sliding
    length = jnp.sqrt(dot_few(drive, drive))
    across = kinematics.crossing / length
    return ReducedStage(
        along=dot_few(slip[:2], drive) / length,
        across=jnp.sqrt(across**2 + slip[2] ** 2),
        axial=slip[2],
        drive=length,
        contact_radius=screw.contact_radius,
        normal_moment=dot_few(slip[:2], screw.normal[:2]),
        normal_axial=-screw.normal[2],
    )


@physics("reduced_stage")
def reduced_forces(
    stage: Stage, reduced: ReducedStage, speed: Scalar, carrier_speed: Scalar, axial_force: Scalar
) -> ReducedForces:
    """Forces of the rollers of one stage, by its scalars; the same as those of `stage_forces`.

    **Arguments:**

    - `stage`, `reduced`: the stage and its scalars.
    - `speed`, `carrier_speed`: Ω and ω [rad/s].
    - `axial_force`: axial force of all rollers together [N]; negative on the opposite flanks.
    """
    count = stage.present_roller_count
    law = stage.thread_law
    along = speed * reduced.along - carrier_speed * reduced.drive
    square = along**2 + (speed * reduced.across) ** 2
    slips = above_or_nan(square)
    # Divisions and roots dominate the cost of a step: here are one root and one division; XLA takes
    # others out of loops, such as that by the number of rollers.
    inverse_speed = jnp.where(slips, inverse_root(jnp.where(slips, square, 1.0)), 0.0)
    slip_speed = square * inverse_speed
    # Friction per slip speed: it is parallel to the slip.
    per_force = constant = jnp.zeros_like(slip_speed)
    if law is not None and not law.load_independent:
        per_force = friction_coefficient(law, slip_speed) * inverse_speed
    if law is not None and law.viscous_resistance is not None:
        constant = jnp.where(slips, law.viscous_resistance, 0.0)

    axial_slip = speed * reduced.axial
    remainder = axial_force * (1 / count) + constant * axial_slip
    # A stage that is loaded in the other direction is the same stage seen from its other end.
    flank_sign = jnp.where(remainder < 0, -1.0, 1.0).astype(remainder.dtype)
    resistance = reduced.normal_axial - per_force * flank_sign * axial_slip
    force = quotient(flank_sign * remainder, resistance)
    friction = per_force * force + constant
    turning = speed * reduced.contact_radius**2 - carrier_speed * reduced.drive * reduced.along
    moment = flank_sign * force * reduced.normal_moment + friction * turning
    return ReducedForces(
        torque_on_screw=-count * moment,
        axial_on_screw=axial_force,
        carrier_drive=count * friction * along * reduced.drive,
    )
