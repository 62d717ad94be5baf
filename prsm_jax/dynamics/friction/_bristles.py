"""Friction laws of the threads that have a state, such as LuGre's bristles, before steady slip.

The state is a deflection. Like the slip it lies in the tangent plane of the contact, so its
transverse part determines it.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...friction import Deflected, StatefulFrictionLaw
from ...mechanism import Mechanism, Stage
from ...numerics import dot_few
from ...programs import physics
from .._kinematics import StageKinematics
from ._thread_friction import slip_resistance


def bristles_of(stage: Stage) -> StatefulFrictionLaw | None:
    """The law of a stage's threads, if it has a state."""
    law = stage.thread_law
    # The class declares the state, and gives the type checker its methods.
    return law if isinstance(law, StatefulFrictionLaw) else None


def has_bristles(mechanism: Mechanism) -> bool:
    """Whether friction between the threads of any stage has a state."""
    return any(bristles_of(stage) is not None for stage in mechanism.stages)


def in_tangent_plane(
    kinematics: StageKinematics, transverse: Float[Array, "2"]
) -> Float[Array, "3"]:
    """The vector in the contact's tangent plane with this transverse part."""
    normal = kinematics.sliding.normal
    axial = -dot_few(normal[:2], transverse) / normal[2]
    return jnp.concatenate([transverse, axial[None]])


@physics("bristles")
def bristle_rate(law: StatefulFrictionLaw, contact: Deflected) -> Float[Array, "3"]:
    """Rate of change of the deflection of a law with a state [m/s]."""
    return law.deflection_rate(contact)


@physics("bristles")
def bristle_friction(
    law: StatefulFrictionLaw, contact: Deflected
) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
    """Friction on one roller: per unit of normal force, and independent of it [N]."""
    return law.deflected_friction(contact), slip_resistance(law, contact.slip)


def bristle_power(stage: Stage, contact: Deflected, contact_force: Scalar) -> Scalar:
    """Rate at which the deflections of all rollers of a stage store energy, N F σ₀ z·ż [W].

    F is the normal force at that instant. The energy ½ F σ₀ z² would change with F as well, but a
    spring that stiffens under load takes that energy from the load, not from the slip.
    """
    law = bristles_of(stage)
    assert law is not None
    return stage.present_roller_count * contact_force * law.stored_power(contact)
