"""Friction of screw and roller threads, by any law.

A law gives a coefficient; here it becomes a force on the roller: a part proportional to the normal
force along the slip, and a part proportional to the slip itself.
"""

from collections.abc import Mapping

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...friction import FrictionLaw, Sliding
from ...numerics import above_or_nan, length_few, sum_few
from ...programs import physics

#: Slip below which friction that is smooth at standstill is proportional to the slip under any law:
#: far below any width, and its square can be represented in float32 [m/s].
_LEAST_SLIP = 1e-15


def slip_direction(slip: Float[Array, "3"]) -> Float[Array, "3"]:
    """Unit vector along the slip; zero, with zero derivative, where nothing slips."""
    square = sum_few(slip**2)
    slipping = above_or_nan(square)
    length = jnp.sqrt(jnp.where(slipping, square, 1.0))
    return jnp.where(slipping, slip / length, 0.0)


def friction_coefficient(
    law: FrictionLaw, speed: Scalar, law_inputs: Mapping[str, Scalar] | None = None
) -> Scalar:
    """Friction coefficient of a law at a slip speed [m/s], labelled with the law's name.

    **Arguments:**

    - `law`, `speed`: the law and the slip speed, 0 or more.
    - `law_inputs`: other inputs that the law asks for, by name.
    """
    sliding = Sliding(speed, dict(law_inputs or {}))
    # A constant coefficient becomes an operation too, so that a trace shows its label.
    return physics(_label(law))(lambda: _coefficient(law, sliding) * jnp.ones_like(speed))()


def _coefficient(law: FrictionLaw, sliding: Sliding) -> Scalar:
    """**Raises:** `ValueError` if a law gives anything else than one number."""
    found = law.friction_coefficient(sliding)
    if jnp.shape(found) != jnp.shape(sliding.speed) and jnp.shape(found) != ():
        raise ValueError(
            f"friction_coefficient of {type(law).__name__} gives an array of the shape "
            f"{jnp.shape(found)}, and must give one number"
        )
    return found


def _label(law: FrictionLaw) -> str:
    return f"{law.law or type(law).__name__}_friction"


def thread_friction(
    law: FrictionLaw | None,
    slip: Float[Array, " axes"],
    direction: Float[Array, " axes"],
    law_inputs: Mapping[str, Scalar] | None = None,
    *,
    labelled: bool = True,
) -> tuple[Float[Array, " axes"], Float[Array, " axes"]]:
    """Friction on one roller: force per unit of normal force, and force independent of it [N].

    **Arguments:**

    - `law`: the friction law, or `None` for none.
    - `slip`: slip velocity of the screw over the roller [m/s].
    - `direction`: its unit vector (known even at standstill, from the sense of turning).
    - `law_inputs`: inputs that the law asks for besides the slip speed.
    - `labelled`: whether a trace shows the law; a spline or bearing has its own label.

    Laws are isotropic, so they also hold along a single axis, that of the slip.
    """
    if law is None:
        return jnp.zeros_like(slip), jnp.zeros_like(slip)
    if not labelled:
        return _friction(law, slip, direction, law_inputs)
    return physics(_label(law))(_friction)(law, slip, direction, law_inputs)


def _friction(
    law: FrictionLaw,
    slip: Float[Array, " axes"],
    direction: Float[Array, " axes"],
    law_inputs: Mapping[str, Scalar] | None,
) -> tuple[Float[Array, " axes"], Float[Array, " axes"]]:
    inputs = dict(law_inputs or {})
    if law.load_independent:
        per_force = jnp.zeros_like(slip)
    elif law.smooth_at_standstill and not law.has_state:
        # At zero slip the direction has no derivative; friction per slip speed has one.
        square = sum_few(slip**2)
        speed = jnp.sqrt(square + _LEAST_SLIP**2)
        per_force = law.coefficient_per_speed(Sliding(speed, inputs, square)) * slip
    else:
        per_force = _coefficient(law, Sliding(length_few(slip), inputs)) * direction
    return per_force, _resistance(law, slip)


def _resistance(law: FrictionLaw, slip: Float[Array, " axes"]) -> Float[Array, " axes"]:
    resistance = law.viscous_resistance
    return jnp.zeros_like(slip) if resistance is None else resistance * slip


def slip_resistance(law: FrictionLaw, slip: Float[Array, " axes"]) -> Float[Array, " axes"]:
    """Friction that is independent of the normal force [N]."""
    return physics(_label(law))(_resistance)(law, slip)
