r"""How far errors of nut, screw and rollers open the gaps between flanks.

Flanks are inclined by α, so a part that moves outward by u opens or closes both of its flanks by
$u\tan\alpha$; an axial shift opens one flank and closes the other.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...mechanism import LoadSharing, PartErrors, Stage
from ...programs import physics
from ._places import Places

#: Amounts of errors, and of loads on a free nut, that make rollers unlike; angles only direct them.
_AMOUNTS = {
    "part_errors": (
        *("nut_eccentricity", "nut_tilt", "screw_eccentricity", "screw_tilt"),
        *("roller_diameter_deviation", "roller_tilt"),
    ),
    "free_nut": ("radial_load", "overturning_moment"),
}

PerContact = Float[Array, "rollers threads"]


class GapOpening(NamedTuple):
    """Change of the gaps on one side [m]."""

    #: Opens forward and reverse flanks.
    radial: PerContact
    #: Opens forward flanks and closes reverse ones.
    axial: PerContact


def error_names(sharing: LoadSharing) -> tuple[str, ...]:
    """Errors of parts and loads across the axis that are given (`part_errors.nut_tilt`)."""
    return tuple(
        f"{part}.{field}"
        for part, fields in _AMOUNTS.items()
        for field in fields
        if getattr(getattr(sharing, part), field, None) is not None
    )


def towards(amount: Scalar | None, angle: Scalar | None, places: Places) -> Array | None:
    """Component of a vector across the axis in the direction of each roller, a column."""
    if amount is None:
        return None
    direction = places.angle if angle is None else places.angle - angle
    return (amount * jnp.cos(direction))[:, None]


@physics("part_errors")
def gap_opening(
    stage: Stage,
    errors: PartErrors,
    side: str,
    rollers: tuple[tuple[int, ...], ...],
    places: Places,
) -> GapOpening:
    r"""Change of the gaps on the screw or the nut side, a row per roller.

    A nut displaced by e and leaning by τ moves, at the roller at φ and at the axial place z, by
    $u = e\cos(\varphi-\varphi_e) + z\tau\cos(\varphi-\varphi_\tau)$ outward and by
    $w = -r\tau\cos(\varphi-\varphi_\tau)$ along the axis (r: radius of its thread), and opens its
    gaps by $u\tan\alpha + w$. The screw closes its own by as much. A roller whose pitch diameter is
    larger by Δd closes both sides by $\tan\alpha\,\Delta d/2$. A roller that leans outward by ψ
    moves outward by zψ; its screw side moves ahead by $r_R\psi$ and its nut side back, so that both
    gaps open by $r_R\psi$.

    **Arguments:**

    - `stage`: the stage.
    - `errors`: its errors.
    - `side`: `"screw"` or `"nut"`.
    - `rollers`: the number of each roller.
    - `places`: of the contacts.
    """
    slope, thread = jnp.tan(stage.thread.flank_angle), stage.thread
    # The nut is outside its contacts and ahead of them, the screw inside and behind.
    sign = 1.0 if side == "nut" else -1.0
    radial = axial = jnp.zeros_like(places.axial)

    def error(name: str) -> Array | None:
        return towards(getattr(errors, name), getattr(errors, f"{name}_angle"), places)

    eccentricity, tilt = error(f"{side}_eccentricity"), error(f"{side}_tilt")
    if eccentricity is not None:
        radial = radial + sign * slope * eccentricity
    if tilt is not None:
        radius = thread.nut_radius if side == "nut" else thread.screw_radius
        radial = radial + sign * slope * places.axial * tilt
        axial = axial - sign * radius * tilt
    index = jnp.asarray([number - 1 for (number,) in rollers])
    if errors.roller_diameter_deviation is not None:
        radial = radial - slope * errors.roller_diameter_deviation[index][:, None] / 2
    if errors.roller_tilt is not None:
        lean = errors.roller_tilt[index][:, None]
        radial = radial - sign * slope * places.axial * lean
        axial = axial + thread.roller_radius * lean
    return GapOpening(radial, axial)
