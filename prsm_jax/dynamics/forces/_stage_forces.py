"""Forces in one stage at given speeds: the screw side first, the rest from balances."""

import contextlib

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._errors import MissingDataError
from ...fields import Scalar
from ...mechanism import Stage, body_inertia, body_mass, mean_roller_inertia, mean_roller_mass
from ...numerics import dot_few
from ...programs import physics
from .._kinematics import StageKinematics
from ..friction import (
    ResistingMoment,
    Rubbing,
    ScrewContact,
    Slip,
    has_contact_losses,
    resisting_moments,
    screw_contact,
)


class Motion(eqx.Module):
    """Instantaneous motion of one stage, in the frame of the loaded flank."""

    screw_speed: Scalar
    carrier_speed: Scalar
    slip: Float[Array, "3"]
    #: Unit vector of the slip; at standstill that of impending motion.
    direction: Float[Array, "3"]
    #: Sense of turning of screw over roller, Ω + (n − 1) ω, and of roller over nut: +1 or −1.
    screw_sense: Scalar
    nut_sense: Scalar
    #: Axial acceleration of nut and rollers z̈ [m/s²]; `None` at constant speed, where the masses
    #: are not needed.
    axial_acceleration: Scalar | None = None
    #: Deflection of the bristles in one contact [m]; `None` where friction has no state.
    deflection: Float[Array, "3"] | None = None
    #: Share of the normal force that carries axially, if it is solved for with other unknowns
    #: (`_rubbing`).
    share: Scalar | None = None
    #: Contact of the screw side, if known already.
    contact: ScrewContact | None = None


class StageForces(eqx.Module):
    """Forces on one roller of a stage, and those of all rollers on screw and carrier.

    Those on one roller are in the frame of the loaded flank (`_flank`), as in `Motion`. Those of
    all rollers (`axial_on_screw`, `torque_on_screw`, `carrier_drive`) are not: they couple the
    stage to others.
    """

    #: Normal force of the screw on one roller, all threads together, F [N].
    contact_force: Scalar
    #: Friction of the screw on one roller [N].
    friction: Float[Array, "3"]
    #: Force of the screw on one roller, F n̂ + f [N].
    screw_on_roller: Float[Array, "3"]
    #: Normal force of the nut on one roller [N].
    nut_contact_force: Scalar
    screw_moment: ResistingMoment | None
    nut_moment: ResistingMoment | None
    #: Axial force of all rollers on the screw [N].
    axial_on_screw: Scalar
    #: Torque of all rollers on the screw about its axis [N·m].
    torque_on_screw: Scalar
    #: Generalised force of all rollers on the carrier speed [N·m].
    carrier_drive: Scalar
    #: Combined slip and spin in the ellipse of the screw side; `None` where not modelled.
    rubbing: Rubbing | None = None
    #: Residual of the axial balance at an assumed share of the normal force.
    residual: Scalar | None = None


@physics("axial_inertia")
def axial_inertia(stage: Stage) -> Scalar:
    """Mass that moves axially with the held body: N m_R + m_n + the carriers [kg].

    In an inverted roller screw that body is the screw.
    """
    return stage.present_roller_count * mean_roller_mass(stage) + held_mass(stage)


def held_mass(stage: Stage) -> Scalar:
    """Mass of the held body and of the carriers beside it [kg]."""
    mass = body_mass(stage, stage.thread.family.held)
    carrier = stage.carrier
    if carrier is not None:
        # Papers give the carriers' inertia without their mass; it is small compared with the nut's.
        with contextlib.suppress(MissingDataError):
            mass = mass + carrier.count * body_mass(stage, "carrier")
    return mass


def stage_forces(
    stage: Stage,
    kinematics: StageKinematics,
    motion: Motion,
    axial_force: Scalar,
    flank_sign: Scalar,
) -> StageForces:
    """All forces of the rollers of one stage.

    Axial balance of rollers, nut and carriers: `N (F |n_z| − f_z) = F_n − m z̈`
    (Li et al. 2020, equations 17 and 25; Li et al. 2021, equation 26).

    **Arguments:**

    - `stage`, `kinematics`: the stage and its meshing.
    - `motion`: speeds and slip, in the frame of the loaded flank.
    - `axial_force`: F_n − m z̈, axial force of all rollers together, in that frame [N].
    - `flank_sign`: +1 or −1, to turn forces on other parts back from that frame.
    """
    count = stage.present_roller_count
    screw_side, nut_side = kinematics.sliding, kinematics.rolling
    contact = motion.contact
    if contact is None:
        slip = Slip(motion.slip, motion.direction, motion.screw_speed, motion.carrier_speed)
        axial = axial_force / count
        contact = screw_contact(stage, kinematics, slip, axial, motion.deflection, motion.share)
    force, per_force, constant, rub, residual = contact
    friction = force * per_force + constant
    on_roller = force * screw_side.normal + friction
    nut_axial = -on_roller[2]
    if motion.axial_acceleration is not None:
        nut_axial = nut_axial + mean_roller_mass(stage) * motion.axial_acceleration
    nut_force = nut_axial / nut_side.normal[2]

    screw_moment = nut_moment = None
    radius, angle = screw_side.contact_radius, screw_side.contact_angle_position
    arm = radius * jnp.stack([-jnp.sin(angle), jnp.cos(angle)])
    torque = -count * dot_few(arm, on_roller[:2])
    drive = count * dot_few(friction[:2], kinematics.drive)
    if kinematics.axial_drive is not None:
        # The load moves with the carrier, too.
        drive = drive + kinematics.axial_drive * (count * friction[2] + axial_force)
    if has_contact_losses(stage.friction):
        screw_moment, nut_moment = resisting_moments(stage, kinematics, force, nut_force, rub)
        on_screw_side = count * motion.screw_sense * screw_moment.total
        on_nut_side = count * motion.nut_sense * nut_moment.total
        torque = torque - on_screw_side
        drive = drive - kinematics.relative_spin_ratio * (on_screw_side + on_nut_side)
    return StageForces(
        contact_force=force,
        friction=friction,
        screw_on_roller=on_roller,
        nut_contact_force=nut_force,
        screw_moment=screw_moment,
        nut_moment=nut_moment,
        # From the balance itself: close to jamming, the product of a large force and the small
        # share of it that carries has no correct digits in its derivatives.
        axial_on_screw=flank_sign * axial_force,
        torque_on_screw=flank_sign * torque,
        carrier_drive=flank_sign * drive,
        rubbing=rub,
        residual=residual,
    )


@physics("carrier_inertia")
def carrier_inertia(stage: Stage) -> Scalar:
    """Inertia referred to the carrier speed: n_P J_P + N J_R (n − 1)² + N m_R a² [kg·m²].

    n_P carriers; rollers rotate at −(n − 1) ω about their axes and orbit with the carriers
    (Li et al. 2021, equation 11). In general it is κ − 1 in place of n − 1 (`rolling_ratio`).
    """
    thread, count = stage.thread, stage.present_roller_count
    spinning = mean_roller_inertia(stage) * (thread.rolling_ratio - 1) ** 2
    circling = mean_roller_mass(stage) * thread.centre_distance**2
    inertia = count * (spinning + circling)
    if stage.carrier is not None:
        inertia = inertia + stage.carrier.count * body_inertia(stage, "carrier")
    return inertia
