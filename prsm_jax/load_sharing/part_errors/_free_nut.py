r"""A nut that moves sideways and leans: how its displacement changes the gaps on its side.

Its unknowns are $p = (d_x, d_y, r\tau_x, r\tau_y)$ [m]: displacement, and lean times the radius of
its thread. They minimise the same convex energy as all others, less the work of the given load.
An elastic seat adds $\tfrac12 k\,(d_x^2 + d_y^2) + \tfrac12 k_\tau(\tau_x^2 + \tau_y^2)$.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...mechanism import FreeNut, Stage
from ...programs import physics
from ._displacements import Displacements, SideCoupling
from ._places import Places


def directions(places: Places) -> Float[Array, "2 rollers 1"]:
    """Cosine and sine of each roller's angle."""
    return jnp.stack([jnp.cos(places.angle), jnp.sin(places.angle)])[:, :, None]


def unit_displacements(stage: Stage, places: Places) -> tuple[Array, Array]:
    r"""Radial and axial opening of the nut's gaps per unknown, $\tan\alpha$ u and w as for errors.

    **Returns:** two arrays of shape [4, rollers, threads], dimensionless.
    """
    slope = jnp.tan(stage.thread.flank_angle)
    across = jnp.broadcast_to(directions(places), (2, *places.axial.shape))
    levers = places.axial / stage.thread.nut_radius
    radial = slope * jnp.concatenate([across, levers[None] * across])
    return radial, jnp.concatenate([jnp.zeros_like(across), -across])


def _vector(amount: Scalar | None, angle: Scalar | None, dtype) -> Float[Array, " 2"]:
    if amount is None:
        return jnp.zeros((2,), dtype)
    if angle is None:
        return jnp.stack([amount, jnp.zeros_like(amount)])
    return amount * jnp.stack([jnp.cos(angle), jnp.sin(angle)])


@physics("nut_seat")
def _seat(stage: Stage, nut: FreeNut, dtype) -> Float[Array, " 4"]:
    """Stiffness of the seat over each displacement [N/m]; a lean is one over the radius."""
    none = jnp.zeros((), dtype)
    sideways = none if nut.radial_stiffness is None else nut.radial_stiffness
    tilting = none if nut.tilting_stiffness is None else nut.tilting_stiffness
    leaning = tilting / stage.thread.nut_radius**2
    return jnp.stack([sideways, sideways, leaning, leaning])


@physics("free_nut")
def free_nut_displacements(stage: Stage, nut: FreeNut, places: Places, both: bool) -> Displacements:
    """Displacements of a free nut sideways, and its leans times its radius.

    **Arguments:**

    - `stage`: the stage.
    - `nut`: the loads on its nut.
    - `places`: of the contacts.
    - `both`: whether reverse flanks are modelled.
    """
    radial, axial = unit_displacements(stage, places)
    dtype = places.axial.dtype
    force = _vector(nut.radial_load, nut.radial_load_angle, dtype)
    moment = _vector(nut.overturning_moment, nut.overturning_moment_angle, dtype)
    load = jnp.concatenate([force, moment / stage.thread.nut_radius])
    given = nut.radial_stiffness is not None or nut.tilting_stiffness is not None
    seat = jnp.diag(_seat(stage, nut, dtype)) if given else None
    side = SideCoupling(axial, radial) if both else SideCoupling(axial + radial, None)
    return Displacements(side, None, load, seat)
