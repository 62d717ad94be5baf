"""Laws with a state between the threads, such as LuGre's bristles, on their way to steady slip.

The state is a deflection in the tangent plane of the contact, as the slip is, so its transverse
part says it all.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...friction import Deflected, StatefulFrictionLaw
from ...mechanism import Mechanism, Scalar, Stage
from ...numerics import dot_few
from ...programs import physics
from .._kinematics import StageKinematics
from ._thread_friction import slip_resistance


def bristles_of(stage: Stage) -> StatefulFrictionLaw | None:
    """The law of a stage's threads, if it has a state."""
    law = stage.thread_law
    # The class is the declaration, and tells the type checker of the methods.
    return law if isinstance(law, StatefulFrictionLaw) else None


def has_bristles(mechanism: Mechanism) -> bool:
    """Whether friction between the threads of any stage has a state."""
    return any(bristles_of(stage) is not None for stage in mechanism.stages)


def in_tangent_plane(
    kinematics: StageKinematics, transverse: Float[Array, "2"]
) -> Float[Array, "3"]:
    """The vector of the contact's tangent plane that has this transverse part."""
    normal = kinematics.meshing.screw.normal
    axial = -dot_few(normal[:2], transverse) / normal[2]
    return jnp.concatenate([transverse, axial[None]])


@physics("bristles")
def bristle_rate(law: StatefulFrictionLaw, contact: Deflected) -> Float[Array, "3"]:
    """How fast the deflection of a law with a state changes [m/s]."""
    return law.deflection_rate(contact)


@physics("bristles")
def bristle_friction(
    law: StatefulFrictionLaw, contact: Deflected
) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
    """Friction on one roller: per unit of normal force, and beside it [N]."""
    return law.deflected_friction(contact), slip_resistance(law, contact.slip)


def bristle_power(stage: Stage, contact: Deflected, contact_force: Scalar) -> Scalar:
    """Rate at which the deflections of all rollers of a stage store energy, N F σ₀ z·ż [W].

    That at the normal force of the instant: an energy ½ F σ₀ z² would change with the force too,
    but a spring that stiffens under load takes that from the load, not from the slip.
    """
    law = bristles_of(stage)
    assert law is not None
    return stage.present_roller_count * contact_force * law.stored_power(contact)
