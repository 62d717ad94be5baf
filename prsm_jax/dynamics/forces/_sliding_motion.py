"""Motion of a stage at any carrier speed, not only that of the steady state."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from .._kinematics import StageKinematics, slip_velocity
from ..friction import slip_direction
from ._stage_forces import Motion


def sense_of(speed: Scalar) -> Scalar:
    """Sense of turning: +1, −1, or 0 at standstill; it has no derivative."""
    return jnp.sign(jax.lax.stop_gradient(speed))


def sliding_motion(
    kinematics: StageKinematics,
    screw_speed: Scalar,
    carrier_speed: Scalar,
    axial_acceleration: Scalar | None,
    deflection: Float[Array, "3"] | None = None,
    share: Scalar | None = None,
) -> Motion:
    """Motion at given speeds of screw and carrier [rad/s], in the frame of the loaded flank."""
    slip = slip_velocity(kinematics, screw_speed, carrier_speed)
    rolling = kinematics.relative_spin_ratio * carrier_speed
    return Motion(
        screw_speed=screw_speed,
        carrier_speed=carrier_speed,
        slip=slip,
        direction=slip_direction(slip),
        screw_sense=sense_of(screw_speed + rolling),
        nut_sense=sense_of(rolling),
        axial_acceleration=axial_acceleration,
        deflection=deflection,
        share=share,
    )
