"""Friction laws between screw and roller threads.

A law says what force acts on the roller: a part proportional to the normal force along the slip
direction, and a part proportional to the slip itself. A new law is one more function here.
"""

import functools

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...mechanism import (
    CoulombFriction,
    LuGreFriction,
    RegularisedCoulombFriction,
    Scalar,
    StribeckFriction,
    ThreadFriction,
    ViscousFriction,
)
from ...numerics import above_or_nan, sum_few
from ...programs import physics


def slip_direction(slip: Float[Array, "3"]) -> Float[Array, "3"]:
    """Unit vector along the slip; zero, with zero derivative, where nothing slips."""
    square = sum_few(slip**2)
    slipping = above_or_nan(square)
    length = jnp.sqrt(jnp.where(slipping, square, 1.0))
    return jnp.where(slipping, slip / length, 0.0)


@functools.singledispatch
def thread_friction(
    law: ThreadFriction | None, slip: Float[Array, " axes"], direction: Float[Array, " axes"]
) -> tuple[Float[Array, " axes"], Float[Array, " axes"]]:
    """Friction on one roller: force per unit of normal force, and force independent of it [N].

    **Arguments:**

    - `law`: the friction law, or `None` for none.
    - `slip`: slip velocity of the screw over the roller [m/s].
    - `direction`: its unit vector (known even at standstill, from the sense of turning).

    Laws are isotropic: along a single axis, that of the slip, they are the same.
    """
    raise TypeError(f"no thread friction law is known for {type(law).__name__}")


@thread_friction.register
def _none(law: None, slip, direction):
    return jnp.zeros_like(slip), jnp.zeros_like(slip)


@thread_friction.register
@physics("coulomb_friction")
def _coulomb(law: CoulombFriction, slip, direction):
    return law.coefficient * direction, jnp.zeros_like(slip)


@thread_friction.register
@physics("viscous_friction")
def _viscous(law: ViscousFriction, slip, direction):
    return jnp.zeros_like(slip), law.coefficient * slip


@thread_friction.register
@physics("regularised_coulomb_friction")
def _regularised(law: RegularisedCoulombFriction, slip, direction):
    smooth = slip / jnp.sqrt(sum_few(slip**2) + law.width**2)
    return law.coefficient * smooth, jnp.zeros_like(slip)


def stribeck_coefficient(
    law: StribeckFriction | LuGreFriction, slip: Float[Array, " axes"]
) -> Scalar:
    """Friction coefficient between a static and a sliding one, `μ + (μ_s − μ) e^{−(v/v_S)²}`."""
    share = sum_few(slip**2) / law.stribeck_speed**2
    return law.coefficient + (law.static_coefficient - law.coefficient) * jnp.exp(-share)


@thread_friction.register(StribeckFriction)
@physics("stribeck_friction")
def _stribeck(law, slip, direction):
    constant = jnp.zeros_like(slip)
    if law.viscous_coefficient is not None:
        constant = law.viscous_coefficient * slip
    return stribeck_coefficient(law, slip) * direction, constant


@thread_friction.register(LuGreFriction)
@physics("lugre_friction")
def _steady_bristles(law, slip, direction):
    """Bristles that have settled: Stribeck's law. On their way there see `_bristles`."""
    constant = jnp.zeros_like(slip)
    if law.viscous_coefficient is not None:
        constant = law.viscous_coefficient * slip
    return stribeck_coefficient(law, slip) * direction, constant


def normal_force(
    normal: Float[Array, "3"],
    per_force: Float[Array, "3"],
    constant: Float[Array, "3"],
    axial: Scalar,
) -> Scalar:
    """Normal force on one roller from its axial balance F (|n_z| − μ v_z/‖v‖) = F_a + f_z [N].

    The mechanism locks where the bracket vanishes.
    """
    return (axial + constant[2]) / (-normal[2] - per_force[2])
