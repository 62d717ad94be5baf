"""Places of the contacts around the screw and along it."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...mechanism import Stage

#: Rounding must not move a contact by a whole pitch.
_ROUNDING = 1e-6


class Places(NamedTuple):
    """Where each thread of each roller touches; a row per roller present."""

    #: Angle of each roller around the screw, φ [rad].
    angle: Float[Array, " rollers"]
    #: Axial place of each contact from the middle of the first roller's threads, z [m].
    axial: Float[Array, "rollers threads"]


def contact_places(stage: Stage, rollers: tuple[tuple[int, ...], ...], thread_count: int) -> Places:
    r"""Places of the contacts, each roller at its true place within a pitch.

    Roller i is at the angle $\varphi_i = 2\pi(i - 1)/N$, plus its `position_offset`. The threads of
    screw and nut have n starts and the lead n p, so at that angle they lie $p\,n\varphi_i/2\pi$
    further on, of which whole pitches do not count. Right-hand threads.

    **Arguments:**

    - `stage`: the stage.
    - `rollers`: the number of each roller, one in each class.
    - `thread_count`: engaged threads of one roller.
    """
    thread, dtype = stage.thread, stage.thread.lead.dtype
    unequal = {roller.number: roller for roller in stage.unequal_roller}
    turns = jnp.asarray([(n - 1) / stage.roller_count for (n,) in rollers], dtype)
    offsets = [getattr(unequal.get(n), "position_offset", None) for (n,) in rollers]
    if any(offset is not None for offset in offsets):
        none = jnp.zeros((), dtype)
        given = jnp.stack([none if offset is None else offset for offset in offsets])
        turns = turns + given / (2 * jnp.pi)
    pitches = thread.starts * turns
    within = pitches - jnp.floor(pitches + _ROUNDING)
    places = jnp.arange(thread_count, dtype=dtype) - (thread_count - 1) / 2
    axial = thread.pitch * (places[None, :] + within[:, None])
    return Places(2 * jnp.pi * turns, axial)
