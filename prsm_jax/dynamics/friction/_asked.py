"""What friction laws ask for beside the slip speed: normal force, pressure, rolling speed.

Evaluated only where a law asks for it.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...friction import FrictionLaw
from ...mechanism import Scalar, Stage
from ...numerics import above_or_nan, length_few
from .._kinematics import StageKinematics


class Slip(NamedTuple):
    """Slip of the screw over the roller, and the speeds that it follows from."""

    #: [m/s].
    velocity: Float[Array, "3"]
    #: Unit vector; at standstill that of the motion about to begin. Shorter where friction takes
    #: only a share of what it can, in a stage that is held.
    direction: Float[Array, "3"]
    #: Of screw and carrier [rad/s].
    screw_speed: Scalar
    carrier_speed: Scalar


def rolling_speed(kinematics: StageKinematics, slip: Slip) -> Scalar:
    """Mean speed of the surfaces of screw and roller through their contact [m/s].

    In the frame of the carrier the screw's surface moves with `(Ω − ω) r × e_z` and `Ω L/2π`
    axially, the roller's with that less the slip.
    """
    around = (slip.screw_speed - slip.carrier_speed) * kinematics.slip_per_screw[:2]
    screw = jnp.concatenate([around, slip.velocity[2:]])
    return length_few(screw - slip.velocity / 2)


def asked_of(
    law: FrictionLaw, kinematics: StageKinematics, slip: Slip, force: Scalar
) -> dict[str, Scalar]:
    """What a law asks for, by name.

    **Arguments:**

    - `law`: the law.
    - `kinematics`: of its stage; with the contact losses if it asks for the pressure.
    - `slip`: of the screw over the roller.
    - `force`: normal force of one roller [N].
    """
    found: dict[str, Scalar] = {}
    loaded = above_or_nan(force)
    for name in law.asks:
        if name == "normal_force":
            found[name] = jnp.where(loaded, force, 0.0)
        elif name == "pressure":
            unit = getattr(kinematics.resistance, "pressure", None)
            assert unit is not None
            found[name] = unit * jnp.where(loaded, jnp.cbrt(jnp.where(loaded, force, 1.0)), 0.0)
        else:
            found[name] = rolling_speed(kinematics, slip)
    return found


def asks_for_force(stage: Stage) -> bool:
    """Whether friction of the threads depends on the normal force by its law."""
    law = stage.thread_law
    return law is not None and bool({"normal_force", "pressure"} & set(law.asks))


def asks_for_pressure(stage: Stage) -> bool:
    """Whether friction of the threads depends on the pressure by its law."""
    law = stage.thread_law
    return law is not None and "pressure" in law.asks
