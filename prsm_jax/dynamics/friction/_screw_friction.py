"""Friction of splines and thrust bearings by any law, and drag.

As for threads, one part is proportional to the force that presses the surfaces together and one
part is not.
"""

import jax.numpy as jnp

from ...fields import Scalar
from ...friction import Drag, FrictionAtRadius, FrictionLaw
from ...programs import physics
from ._thread_friction import thread_friction


def _signed_coefficient(law: FrictionLaw, speed: Scalar, sense: Scalar) -> Scalar:
    """Friction coefficient at a sliding speed [m/s], with the sign of the sliding.

    `sense` is +1 or −1, and known even at standstill.
    """
    coefficient, _ = thread_friction(
        law, speed[None], jnp.broadcast_to(sense, speed.shape)[None], labelled=False
    )
    return coefficient[0]


@physics("spline_friction")
def spline_force(
    friction: FrictionAtRadius, sliding: Scalar, sense: Scalar
) -> tuple[Scalar | None, Scalar | None]:
    """Friction force of a spline: per drive torque [1/m], and independent of it [N].

    **Arguments:**

    - `friction`: the friction law and the radius of the spline.
    - `sliding`: axial speed of the screw over its driver [m/s].
    - `sense`: sense of this sliding, +1 or −1, known even at standstill.

    **Returns:** both parts, `None` where there is none.
    """
    law = friction.law
    resistance = law.viscous_resistance
    constant = None if resistance is None else resistance * sliding
    if law.load_independent:
        return None, constant
    return _signed_coefficient(law, sliding, sense) / friction.arm, constant


@physics("thrust_bearing_friction")
def bearing_torque(
    friction: FrictionAtRadius, screw_speed: Scalar, sense: Scalar
) -> tuple[Scalar | None, Scalar | None]:
    """Friction torque of a thrust bearing: per axial force [m], and independent of it [N·m].

    **Arguments:**

    - `friction`: the friction law and the radius of the bearing; the sliding speed is that of the
      screw at this radius, and viscous resistance is a torque per angular speed.
    - `screw_speed`: Ω [rad/s].
    - `sense`: sense of Ω, +1 or −1, known even at standstill.

    **Returns:** both parts, `None` where there is none.
    """
    law = friction.law
    resistance = law.viscous_resistance
    constant = None if resistance is None else resistance * screw_speed
    if law.load_independent:
        return None, constant
    radius = friction.arm
    return _signed_coefficient(law, screw_speed * radius, sense) * radius, constant


@physics("drag")
def drag_torque(law: Drag, screw_speed: Scalar, sense: Scalar) -> Scalar:
    """Drag torque on a screw: constant, and proportional to the speed [N·m]."""
    torque = law.torque * sense
    if law.width is not None:
        torque = law.torque * screw_speed / jnp.sqrt(screw_speed**2 + law.width**2)
    if law.viscous_coefficient is not None:
        torque = torque + law.viscous_coefficient * screw_speed
    return torque
