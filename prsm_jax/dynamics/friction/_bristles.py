"""Bristles in the thread contacts: the LuGre law on its way to steady slip.

Canudas de Wit, Olsson, Åström, Lischinsky, A new model for control of systems with friction, IEEE
Transactions on Automatic Control 40 (1995) 419–425, here per unit of normal force and for a vector
of slip. The deflection z lies in the tangent plane of the contact, as the slip does, so its
transverse part says it all.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...mechanism import LuGreFriction, Mechanism, Scalar, Stage
from ...numerics import dot_few, length_few, sum_few
from ...programs import physics
from .._kinematics import StageKinematics
from ._thread_friction import stribeck_coefficient


def bristles_of(stage: Stage) -> LuGreFriction | None:
    """The LuGre law of a stage's threads, if it has that."""
    law = None if stage.friction is None else stage.friction.thread
    return law if isinstance(law, LuGreFriction) else None


def has_bristles(mechanism: Mechanism) -> bool:
    """Whether the threads of any stage follow the LuGre law."""
    return any(bristles_of(stage) is not None for stage in mechanism.stages)


def breakaway_deflection(law: LuGreFriction) -> Scalar:
    """Deflection at which bristles hold the most, μ_s/σ₀ [m]."""
    return law.static_coefficient / law.bristle_stiffness


def in_tangent_plane(
    kinematics: StageKinematics, transverse: Float[Array, "2"]
) -> Float[Array, "3"]:
    """The vector of the contact's tangent plane that has this transverse part."""
    normal = kinematics.meshing.screw.normal
    axial = -dot_few(normal[:2], transverse) / normal[2]
    return jnp.concatenate([transverse, axial[None]])


@physics("bristles")
def bristle_rate(
    law: LuGreFriction,
    slip: Float[Array, "3"],
    deflection: Float[Array, "3"],
    held: Float[Array, "3"] | None = None,
    mean_speed: Scalar | None = None,
) -> Float[Array, "3"]:
    """How fast bristles bend, `ż = v − σ₀ |v| z / g(v)` [m/s].

    In an ellipse that spins too, bristles settle where their force is that of slip and spin
    together, `g(Φ) T` with `T = ∂Φ/∂v`, and the faster the more of the slip is spin:
    `ż = |v|/|T| (T − σ₀ z/g(Φ))`.

    **Arguments:**

    - `law`, `slip`, `deflection`: as in `bristle_friction`.
    - `held`, `mean_speed`: T and Φ [m/s], where spin is modelled.
    """
    speed = length_few(slip)
    if held is None or mean_speed is None:
        return slip - law.bristle_stiffness * speed / stribeck_coefficient(law, slip) * deflection
    length = length_few(held)
    rate = speed / jnp.where(length > 0, length, 1.0)
    coefficient = stribeck_coefficient(law, mean_speed[None])
    return rate * (held - law.bristle_stiffness / coefficient * deflection)


def bristle_friction(
    law: LuGreFriction,
    slip: Float[Array, "3"],
    deflection: Float[Array, "3"],
    held: Float[Array, "3"] | None = None,
    mean_speed: Scalar | None = None,
) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
    """Friction on one roller: per unit of normal force `σ₀ z + σ₁ ż`, and `σ₂ v` [N].

    **Arguments:**

    - `law`: the friction law.
    - `slip`: slip velocity of the screw over the roller [m/s].
    - `deflection`: of the bristles, z [m].
    - `held`, `mean_speed`: of an ellipse that spins, as in `bristle_rate`.
    """
    damping = law.bristle_damping
    if law.damping_speed is not None:
        damping = damping * jnp.exp(-sum_few(slip**2) / law.damping_speed**2)
    rate = bristle_rate(law, slip, deflection, held, mean_speed)
    force = law.bristle_stiffness * deflection + damping * rate
    if law.viscous_coefficient is None:
        return force, jnp.zeros_like(slip)
    return force, law.viscous_coefficient * slip


def bristle_power(
    stage: Stage, slip, deflection, contact_force: Scalar, held=None, mean_speed=None
) -> Scalar:
    """Rate at which the bristles of all rollers of a stage store energy, N F σ₀ z·ż [W].

    That at the normal force of the instant: an energy ½ F σ₀ z² would change with the force too,
    but a spring that stiffens under load takes that from the load, not from the slip.
    """
    law = bristles_of(stage)
    assert law is not None
    bending = dot_few(deflection, bristle_rate(law, slip, deflection, held, mean_speed))
    return stage.present_roller_count * contact_force * law.bristle_stiffness * bending
