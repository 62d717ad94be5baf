"""Which thread flanks carry the load; without backlash, the load changes flanks at zero force.

A stage that is loaded in the other direction is the same stage seen from its other end. A half turn
about a radial axis maps it to a stage loaded in the usual direction: axial and tangential
components, torques and speeds change sign; radial components and the handedness of the threads do
not. So a stage is evaluated at `flank_sign · (Ω, ω, F, z̈)`, and the forces and torques on its
screw and carrier are turned back.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...friction import FrictionLaw


def loaded_flank_sign(law: FrictionLaw | None, axial_force: Scalar, axial_slip: Scalar) -> Scalar:
    """+1 if the usual flanks carry one roller, −1 if the others do.

    Friction that is independent of the normal force carries a part of the axial force: the flanks
    change where the remainder, which the normal force carries, changes sign.

    **Arguments:**

    - `law`: thread friction.
    - `axial_force`: axial force that one roller carries [N].
    - `axial_slip`: axial part of the slip of the screw over the roller [m/s].
    """
    coefficient = None if law is None else law.viscous_resistance
    remainder = axial_force if coefficient is None else axial_force + coefficient * axial_slip
    return jnp.where(remainder < 0, -1.0, 1.0).astype(remainder.dtype)


def turned(vector: Float[Array, "3"], flank_sign: Scalar) -> Float[Array, "3"]:
    """Turn a vector (radial, tangential, axial) into the frame of the loaded flank, or back."""
    return vector * jnp.stack([jnp.ones_like(flank_sign), flank_sign, flank_sign])
