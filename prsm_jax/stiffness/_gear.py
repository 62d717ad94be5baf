"""Mesh stiffness of the roller gear and the ring gear."""

import jax.numpy as jnp

from .._errors import MissingDataError
from ..fields import Scalar
from ..mechanism import Gear, Stage
from ..programs import physics

#: Correction factor C_M, rim factor C_R and basic rack factor C_B of ISO 6336-1.
_CORRECTION, _RIM, _BASIC_RACK = 0.8, 1.0, 1.0
#: q is in mm·µm/N; its inverse in N/(mm·µm) is this many Pa.
_PASCAL_PER_UNIT = 1e9


def tooth_flexibility(gear: Gear, starts: Scalar) -> Scalar:
    """Minimum flexibility q' of a pair of teeth [mm·µm/N], ISO 6336-1.

    **Arguments:**

    - `gear`: the gear pair; z₁ = z_R, x₁ on the roller, z₂ (given or n z_R), x₂ on the ring, or
        on the screw of an inverted roller screw.
    - `starts`: number of thread starts n, the ratio of the gear pair.

    **Raises:** `MissingDataError` if the number of teeth is not given.
    """
    if gear.roller_teeth is None:
        raise MissingDataError("the gear has no roller_teeth; give stage.gear.roller_teeth")
    first = gear.roller_teeth
    second = starts * first if gear.ring_teeth is None else gear.ring_teeth
    shift_first, shift_second = gear.roller_profile_shift, gear.ring_profile_shift
    return (
        0.04723
        + 0.15551 / first
        + 0.25791 / second
        - 0.00635 * shift_first
        - 0.11654 * shift_first / first
        - 0.00193 * shift_second
        - 0.24188 * shift_second / second
        + 0.00529 * shift_first**2
        + 0.00182 * shift_second**2
    )


@physics("gear_mesh_stiffness")
def gear_mesh_stiffness(gear: Gear, starts: Scalar) -> Scalar:
    """Mesh stiffness of one roller with the ring gear [N/m].

    `k = C_M C_R C_B cos β / q' · b`, times the mesh factor for the mean number of teeth in
    contact. Source: ISO 6336-1, as in Wu et al. 2022, equations 48 to 50.

    **Arguments:**

    - `gear`: the gear pair.
    - `starts`: number of thread starts n.

    **Raises:** `MissingDataError` if the number of teeth or the face width is not given.
    """
    if gear.face_width is None:
        raise MissingDataError("the gear has no face_width; give stage.gear.face_width")
    factors = _CORRECTION * _RIM * _BASIC_RACK * jnp.cos(gear.helix_angle)
    single = factors / tooth_flexibility(gear, starts) * _PASCAL_PER_UNIT
    return single * gear.face_width * gear.mesh_factor


def ring_roller_stiffness(stage: Stage) -> Scalar | None:
    """Gear mesh stiffness of one roller: given, derived, or `None` without a gear [N/m]."""
    if stage.stiffness is not None and stage.stiffness.ring_roller is not None:
        return stage.stiffness.ring_roller
    if stage.gear is None:
        return None
    return gear_mesh_stiffness(stage.gear, stage.thread.starts)
