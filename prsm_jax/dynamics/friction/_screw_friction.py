"""Friction laws of splines, thrust bearings and drag.

As with threads, a law says what is proportional to the normal force and what is not: a new law is
one more class and its `_coefficient` or `_free_of_load` here.
"""

import functools

import jax.numpy as jnp

from ...mechanism import (
    Drag,
    RegularisedSplineFriction,
    RegularisedThrustBearingFriction,
    Scalar,
    SplineFriction,
    SplineLaw,
    StribeckSplineFriction,
    StribeckThrustBearingFriction,
    ThrustBearingFriction,
    ThrustBearingLaw,
    ViscousSplineFriction,
    ViscousThrustBearingFriction,
)
from ...programs import physics


@functools.singledispatch
def _coefficient(law, speed: Scalar, sense: Scalar) -> Scalar:
    """Signed friction coefficient at a sliding speed [m/s] and its sense, +1 or −1."""
    raise TypeError(f"no friction law is known for {type(law).__name__}")


@_coefficient.register(SplineFriction)
@_coefficient.register(ThrustBearingFriction)
def _coulomb(law, speed, sense):
    return law.coefficient * sense


@_coefficient.register(RegularisedSplineFriction)
@_coefficient.register(RegularisedThrustBearingFriction)
def _regularised(law, speed, sense):
    return law.coefficient * speed / jnp.sqrt(speed**2 + law.width**2)


@_coefficient.register(StribeckSplineFriction)
@_coefficient.register(StribeckThrustBearingFriction)
def _stribeck(law, speed, sense):
    falling = (law.static_coefficient - law.coefficient) * jnp.exp(
        -((speed / law.stribeck_speed) ** 2)
    )
    return (law.coefficient + falling) * sense


@physics("spline_friction")
def spline_force(
    law: SplineLaw, sliding: Scalar, sense: Scalar
) -> tuple[Scalar | None, Scalar | None]:
    """Friction force of a spline: per drive torque [1/m], and independent of it [N].

    **Arguments:**

    - `law`: the friction law.
    - `sliding`: axial speed of the screw over its driver [m/s].
    - `sense`: the sense of that, +1 or −1, known even at standstill.

    **Returns:** both parts, `None` where there is none.
    """
    if isinstance(law, ViscousSplineFriction):
        return None, law.coefficient * sliding
    constant = None
    if isinstance(law, StribeckSplineFriction) and law.viscous_coefficient is not None:
        constant = law.viscous_coefficient * sliding
    return _coefficient(law, sliding, sense) / law.radius, constant


@physics("thrust_bearing_friction")
def bearing_torque(
    law: ThrustBearingLaw, screw_speed: Scalar, sense: Scalar
) -> tuple[Scalar | None, Scalar | None]:
    """Friction torque of a thrust bearing: per axial force [m], and independent of it [N·m].

    **Arguments:**

    - `law`: the friction law; its sliding speed is that of the screw at the bearing's radius.
    - `screw_speed`: Ω [rad/s].
    - `sense`: the sense of that, +1 or −1, known even at standstill.

    **Returns:** both parts, `None` where there is none.
    """
    if isinstance(law, ViscousThrustBearingFriction):
        return None, law.coefficient * screw_speed
    constant = None
    if isinstance(law, StribeckThrustBearingFriction) and law.viscous_coefficient is not None:
        constant = law.viscous_coefficient * screw_speed
    return _coefficient(law, screw_speed * law.radius, sense) * law.radius, constant


@physics("drag")
def drag_torque(law: Drag, screw_speed: Scalar, sense: Scalar) -> Scalar:
    """Drag torque on a screw: constant, and proportional to the speed [N·m]."""
    torque = law.torque * sense
    if law.width is not None:
        torque = law.torque * screw_speed / jnp.sqrt(screw_speed**2 + law.width**2)
    if law.viscous_coefficient is not None:
        torque = torque + law.viscous_coefficient * screw_speed
    return torque
