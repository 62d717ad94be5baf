"""Which flanks of the threads carry the load: without backlash, it changes sides at no load.

A stage whose rollers are pushed the other way is the same stage seen from its other end. A half
turn about a radial axis maps it on one that is pushed the usual way: axial and tangential
components, torques and speeds change their signs, radial components and the handedness of the
threads do not. So a stage is evaluated as if at `flank · (Ω, ω, F, z̈)`, and what it does to its
screw and carrier is turned back.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...friction import FrictionLaw
from ...mechanism import Scalar


def loaded_flank(law: FrictionLaw | None, axial_force: Scalar, axial_slip: Scalar) -> Scalar:
    """+1 if the usual flanks carry one roller, −1 if the others do.

    Friction that needs no normal force helps to carry it: the sides change where what is left for
    the normal force does.

    **Arguments:**

    - `law`: thread friction.
    - `axial_force`: what one roller carries axially [N].
    - `axial_slip`: axial part of the slip, Ω L/2π [m/s].
    """
    coefficient = None if law is None else law.viscous_resistance
    left = axial_force if coefficient is None else axial_force + coefficient * axial_slip
    return jnp.where(left < 0, -1.0, 1.0).astype(left.dtype)


def turned(vector: Float[Array, "3"], flank: Scalar) -> Float[Array, "3"]:
    """A vector (radial, tangential, axial) from the frame of the loaded flank, or into it."""
    return vector * jnp.stack([jnp.ones_like(flank), flank, flank])
