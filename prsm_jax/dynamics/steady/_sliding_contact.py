"""The sliding contact of one stage in its steady state: slip, normal force, inputs of its law."""

from typing import Annotated

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..._errors import MissingDataError
from ...fields import In, Scalar
from ...friction import FrictionLaw
from ...geometry import ThreadContact
from ...mechanism import Mechanism, require_type, stage_at
from .._kinematics import slip_velocity
from ..friction import Slip, law_inputs_of, loaded_flank_sign, turned, with_resistance
from ._steady import all_kinematics, steady_state


class SlidingContact(eqx.Module):
    """Mean slip of the body that turns over one roller, in the frame of the flank that carries.

    In this frame that body, the screw (of an inverted roller screw the nut), presses the rollers
    towards −z; for a negative load it is turned by half a turn about the line of centres.
    """

    #: Slip of the body that turns over the roller: radial, tangential, axial [m/s].
    velocity: Annotated[Float[Array, "3"], In("m/s")]
    #: Its unit vector; at standstill that of impending motion.
    direction: Float[Array, "3"]
    #: Normal force of one roller, all its threads together [N].
    force: Annotated[Scalar, In("N")]
    law: FrictionLaw
    #: What the law asks for besides the slip speed, by name.
    law_inputs: dict[str, Scalar]
    contact: ThreadContact
    #: Whether the steady state is valid.
    valid: Bool[Array, ""]


def sliding_contact(
    mechanism: Mechanism,
    stage: int = 1,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
) -> SlidingContact:
    """The contact on which the rollers of one stage slide, at a steady operating point.

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs a law of thread friction.
    - `stage`: which stage, counted from 1.
    - `speed`, `load`: speed of the body that turns [rad/s] and load [N]; default those of the
      operating point.

    **Raises:** `MissingDataError` if speed, load or the friction of the threads is not given, or
    for a recirculating roller screw, whose rollers slide on two bodies; `ValueError` for a stage
    that does not exist.
    """
    chosen = stage_at(mechanism, stage)
    require_type((chosen,), "the sliding contact is", ("standard", "inverted", "differential"))
    law = chosen.thread_law
    if law is None:
        raise MissingDataError(
            f"stage {stage} has no thread friction; give [stage.friction.thread] with a law"
        )
    every = with_resistance(mechanism.stages, all_kinematics(mechanism))
    state = steady_state(mechanism, speed, load, every)
    kinematics, at = every[stage - 1], stage - 1
    force = state.contact_force[at]
    screw_speed = state.screw_speed
    seen = slip_velocity(kinematics, screw_speed, state.carrier_ratio[at] * screw_speed)
    flank = loaded_flank_sign(law, state.nut_load[at] / chosen.present_roller_count, seen[2])
    # All speeds change their signs with the flank.
    screw_speed = flank * state.screw_speed
    carrier_speed = state.carrier_ratio[at] * screw_speed
    velocity = slip_velocity(kinematics, screw_speed, carrier_speed)
    direction = turned(state.slip_direction[at], flank)
    slip = Slip(velocity, direction, screw_speed, carrier_speed)
    inputs = law_inputs_of(law, kinematics, slip, force)
    valid = jnp.asarray(state.valid)
    return SlidingContact(velocity, direction, force, law, inputs, kinematics.sliding, valid)
