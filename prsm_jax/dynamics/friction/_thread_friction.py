"""Friction of screw and roller threads, by any law.

A law gives a coefficient; here it becomes a force on the roller: a part proportional to the normal
force along the slip, and a part proportional to the slip itself.
"""

from collections.abc import Mapping

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...friction import FrictionLaw, Sliding
from ...mechanism import Scalar
from ...numerics import above_or_nan, length_few, sum_few
from ...programs import physics

#: Slip below which friction that is smooth at standstill is proportional to the slip, whatever the
#: law: far below any width, and its square is a number in float32 [m/s].
_LEAST_SLIP = 1e-15


def slip_direction(slip: Float[Array, "3"]) -> Float[Array, "3"]:
    """Unit vector along the slip; zero, with zero derivative, where nothing slips."""
    square = sum_few(slip**2)
    slipping = above_or_nan(square)
    length = jnp.sqrt(jnp.where(slipping, square, 1.0))
    return jnp.where(slipping, slip / length, 0.0)


def friction_coefficient(
    law: FrictionLaw, speed: Scalar, asked: Mapping[str, Scalar] | None = None
) -> Scalar:
    """Friction coefficient of a law at a slip speed [m/s], labelled with the law's name.

    **Arguments:**

    - `law`, `speed`: the law and the slip speed, 0 or more.
    - `asked`: what else the law asks for, by name.
    """
    return physics(_label(law))(law.friction_coefficient)(Sliding(speed, dict(asked or {})))


def _label(law: FrictionLaw) -> str:
    return f"{law.law or type(law).__name__}_friction"


def thread_friction(
    law: FrictionLaw | None,
    slip: Float[Array, " axes"],
    direction: Float[Array, " axes"],
    asked: Mapping[str, Scalar] | None = None,
) -> tuple[Float[Array, " axes"], Float[Array, " axes"]]:
    """Friction on one roller: force per unit of normal force, and force independent of it [N].

    **Arguments:**

    - `law`: the friction law, or `None` for none.
    - `slip`: slip velocity of the screw over the roller [m/s].
    - `direction`: its unit vector (known even at standstill, from the sense of turning).
    - `asked`: what the law asks for beside the slip speed.

    Laws are isotropic: along a single axis, that of the slip, they are the same.
    """
    if law is None:
        return jnp.zeros_like(slip), jnp.zeros_like(slip)
    if law.load_independent:
        per_force = jnp.zeros_like(slip)
    elif law.smooth_at_standstill and not law.has_state:
        # The direction of no slip has no derivative; friction over slip speed has one.
        speed = jnp.sqrt(sum_few(slip**2) + _LEAST_SLIP**2)
        per_force = friction_coefficient(law, speed, asked) / speed * slip
    else:
        per_force = friction_coefficient(law, length_few(slip), asked) * direction
    return per_force, slip_resistance(law, slip)


def slip_resistance(law: FrictionLaw, slip: Float[Array, " axes"]) -> Float[Array, " axes"]:
    """Friction that needs no normal force [N]."""
    resistance = law.viscous_resistance
    if resistance is None:
        return jnp.zeros_like(slip)
    return physics(_label(law))(lambda: resistance * slip)()
