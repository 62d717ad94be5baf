"""Inputs of friction laws besides the slip speed: normal force, pressure, rolling speed.

Each is evaluated only if the law asks for it.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...friction import FrictionLaw
from ...mechanism import Stage
from ...numerics import above_or_nan, cube_root_or_zero, length_few
from .._kinematics import StageKinematics


class Slip(NamedTuple):
    """Slip of the screw over the roller, and the speeds that determine it."""

    #: [m/s].
    velocity: Float[Array, "3"]
    #: Unit vector; at standstill that of impending motion. Shorter than 1 while the screw is held
    #: and friction reaches only a share of its limit.
    direction: Float[Array, "3"]
    #: Angular speeds of screw and carrier [rad/s].
    screw_speed: Scalar
    carrier_speed: Scalar


def rolling_speed(kinematics: StageKinematics, slip: Slip) -> Scalar:
    """Mean speed of the surfaces of screw and roller through their contact [m/s].

    In the frame of the carrier the screw's surface moves at `(Ω − ω) r × e_z`, and at `Ω L/2π`
    axially. The velocity of the roller's surface is smaller by the slip.
    """
    circumferential = (slip.screw_speed - slip.carrier_speed) * kinematics.slip_per_screw[:2]
    screw_velocity = jnp.concatenate([circumferential, slip.velocity[2:]])
    return length_few(screw_velocity - slip.velocity / 2)


def law_inputs_of(
    law: FrictionLaw, kinematics: StageKinematics, slip: Slip, force: Scalar
) -> dict[str, Scalar]:
    """Inputs that a law asks for, by name.

    **Arguments:**

    - `law`: the law.
    - `kinematics`: of its stage; with the contact losses if the law asks for the pressure.
    - `slip`: of the screw over the roller.
    - `force`: normal force of one roller [N].
    """
    inputs: dict[str, Scalar] = {}
    for name in law.asks:
        if name == "normal_force":
            inputs[name] = jnp.where(above_or_nan(force), force, 0.0)
        elif name == "pressure":
            unit_pressure = getattr(kinematics.resistance, "pressure", None)
            assert unit_pressure is not None
            inputs[name] = unit_pressure * cube_root_or_zero(force)
        else:
            inputs[name] = rolling_speed(kinematics, slip)
    return inputs


def asks_for_force(stage: Stage) -> bool:
    """Whether the law of thread friction asks for the normal force or the pressure."""
    law = stage.thread_law
    return law is not None and bool({"normal_force", "pressure"} & set(law.asks))


def asks_for_pressure(stage: Stage) -> bool:
    """Whether the law of thread friction asks for the pressure."""
    law = stage.thread_law
    return law is not None and "pressure" in law.asks
