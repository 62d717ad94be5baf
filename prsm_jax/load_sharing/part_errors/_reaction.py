"""Radial force and overturning moment of the rollers on the nut."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...mechanism import Stage
from ._free_nut import unit_displacements
from ._places import Places


class NutForces(NamedTuple):
    """What the rollers do to the nut across its axis, components at 0 and 90 degrees."""

    #: [N]
    radial_force: Float[Array, " 2"]
    #: About the middle of the first roller's threads, positive towards where it tips the nut's end
    #: with the highest thread number [N·m].
    overturning_moment: Float[Array, " 2"]


def forces_on_nut(
    stage: Stage,
    places: Places,
    forward: Float[Array, "rollers threads"],
    reverse: Float[Array, "rollers threads"] | None,
) -> NutForces:
    r"""Force and moment by the principle of virtual work, from the loads on the nut side.

    $F = \sum f\tan\alpha\,e_\varphi$ and $M = \sum f (z\tan\alpha - r)\,e_\varphi$ with the unit
    vector $e_\varphi$ towards each roller; reverse flanks press outward too, but the other way
    along the axis. A nut that is held takes the opposite from its seat.

    **Arguments:**

    - `stage`: the stage.
    - `places`: of the contacts.
    - `forward`, `reverse`: axial loads on the flanks of the nut side [N].
    """
    radial, axial = unit_displacements(stage, places)
    back = jnp.zeros_like(forward) if reverse is None else reverse
    work = radial * (forward + back)[None] + axial * (forward - back)[None]
    force = jnp.sum(work, axis=(1, 2))
    return NutForces(force[:2], force[2:] * stage.thread.nut_radius)
