"""Thread contacts under a reference load, from which all capacities are scaled."""

import jax.numpy as jnp

from .._errors import MissingDataError
from ..contact import (
    StageContact,
    contact_frames,
    contact_pair,
    contact_side,
    engaged_threads,
    meshing_of,
)
from ..fields import Scalar
from ..geometry import Meshing
from ..mechanism import SplitNut, Stage, Strength
from ._powers import positive_power

#: Axial load [N]. Its value has no effect: pressures are exactly proportional to its cube root.
REFERENCE_LOAD = 1e4


def reference_contact(stage: Stage, meshing: Meshing | None = None) -> StageContact:
    """Hertz contacts of a stage under `REFERENCE_LOAD`, shared equally by all threads.

    **Arguments:**

    - `stage`: the stage; needs materials and `engaged_threads`.
    - `meshing`: its meshing, if already known; used only by the `"exact"` convention.

    **Raises:** `MissingDataError` if materials or engaged threads are not given.
    """
    load = jnp.asarray(REFERENCE_LOAD, stage.thread.lead.dtype)
    threads = engaged_threads(stage)
    frames = contact_frames(stage.thread, meshing_of(stage, meshing), stage.curvature)
    axial = load / (stage.present_roller_count * threads)
    forces = axial * frames[0].normal_per_axial, axial * frames[1].normal_per_axial
    pair = contact_pair(stage, frames, forces)
    sides = [
        contact_side(hertz, force, frame, threads)
        for hertz, force, frame in zip(pair, forces, frames, strict=True)
    ]
    return StageContact(*sides)


def known_contact(
    stage: Stage, meshing: Meshing | None, contact: StageContact | None
) -> tuple[Meshing | None, StageContact]:
    """Meshing and `reference_contact` of a stage, as far as they are not known already."""
    meshing = meshing_of(stage, meshing)
    return meshing, reference_contact(stage, meshing) if contact is None else contact


def strength_of(stage: Stage) -> Strength:
    """The strength data of a stage.

    **Raises:** `MissingDataError` if there are none.
    """
    if stage.strength is None:
        raise MissingDataError("the stage has no strength data; give [stage.strength]")
    return stage.strength


def split_nut_of(stage: Stage) -> SplitNut | None:
    """The split nut of a stage's load sharing, or `None`."""
    return None if stage.load_sharing is None else stage.load_sharing.split_nut


def preload_of(stage: Stage) -> Scalar | None:
    """The preload of a stage [N], or `None` if its nut is not preloaded.

    As given for strength, or else the preload of the split nut of load sharing.

    **Raises:** `MissingDataError` if only the offset of a split nut is given, from which the
    preload results.
    """
    play = None if stage.strength is None else stage.strength.play
    if play is not None and play.preload_force is not None:
        return play.preload_force
    split = split_nut_of(stage)
    if split is None:
        return None
    if split.preload is None:
        raise MissingDataError(
            "the preload of the split nut results from its offset; give it as "
            'stage.strength.play.preload_force with arrangement = "split_nut" (the quantity '
            "spacer_force at load 0), or stage.load_sharing.split_nut.preload instead of the offset"
        )
    return split.preload


def is_preloaded(stage: Stage) -> bool:
    """Whether two nuts, or the halves of one, are preloaded; the force need not be known."""
    play = None if stage.strength is None else stage.strength.play
    force_given = play is not None and play.preload_force is not None
    return force_given or split_nut_of(stage) is not None


def thread_share(stage: Stage) -> float:
    """Share of the engaged threads that carry a load of one direction.

    Half of them in a split nut, whose halves preload the same rollers; the share of the smaller
    half if load sharing gives the thread after which the nut is split.
    """
    play = None if stage.strength is None else stage.strength.play
    split = split_nut_of(stage)
    if play is not None and play.preload_force is not None:
        if play.arrangement == "double_nut":
            return 1.0
        if split is None:
            return 0.5
    if split is None:
        return 1.0
    assert stage.load_sharing is not None
    count = stage.load_sharing.thread_count
    return min(split.after_thread, count - split.after_thread) / count


def axial_approach(
    stage: Stage,
    load: Scalar,
    meshing: Meshing | None = None,
    contact: StageContact | None = None,
) -> Scalar:
    """Axial approach of screw and nut by the contacts on both sides of the rollers [m].

    All threads share the load; shafts, teeth and bodies are rigid. Proportional to the power 2/3 of
    the load, and not singular at 0.

    **Arguments:**

    - `stage`: the stage; needs materials and `engaged_threads`.
    - `load`: axial load; its sign is ignored [N].
    - `meshing`: its meshing, if already known.
    - `contact`: `reference_contact` of the stage, if already known.

    **Raises:** `MissingDataError` if materials or engaged threads are not given.
    """
    if contact is None:
        contact = reference_contact(stage, meshing)
    contact_load = REFERENCE_LOAD / (stage.present_roller_count * engaged_threads(stage))
    compliance = 1 / contact.screw.axial_stiffness + 1 / contact.nut.axial_stiffness
    return contact_load * compliance * positive_power(jnp.abs(load) / REFERENCE_LOAD, 2 / 3)
