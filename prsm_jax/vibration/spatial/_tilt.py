"""Tilts of the bodies of a stage: where threads, teeth and pins lie along the axis, and inertias.

All places count from one plane, in which the middles of screw, nut and rollers lie.
"""

import dataclasses

import jax.numpy as jnp

from ..._errors import MissingDataError
from ...fields import Scalar
from ...mechanism import Side, Stage, body_inertia, body_mass, tilting_inertia
from ...numerics import root_or_zero
from ._bodies import SpatialBody, nominal_radius, supports

#: Both carriers where they move in opposite directions, each in its own plane.
OPPOSITE_CARRIERS = "opposite_carriers"


def thread_spread(stage: Stage) -> Scalar:
    """Root mean square distance of n engaged threads from their middle, p √((n² − 1)/12) [m].

    0 for a single thread.

    **Raises:** `MissingDataError` if their number is not known.
    """
    sharing = stage.load_sharing
    count = stage.engaged_threads if sharing is None else sharing.thread_count
    if count is None:
        raise MissingDataError(
            "the tilt of rollers needs the number of their threads in contact; give "
            "stage.engaged_threads, or stage.load_sharing.thread_count"
        )
    square = jnp.maximum((jnp.asarray(count) ** 2 - 1.0) / 12, 0.0)
    return stage.thread.pitch * root_or_zero(square)


def pin_distance(stage: Stage) -> Scalar:
    """Distance of the carriers from the middle: half the length of the rollers [m].

    **Raises:** `MissingDataError` if it is not known.
    """
    length = stage.roller.length
    if length is None:
        raise MissingDataError(
            "the tilt of rollers needs the places of their pins and teeth; give stage.roller.length"
        )
    return length / 2


def teeth_distance(stage: Stage) -> Scalar:
    """Distance of the middle of the teeth at either end from the middle of the rollers [m]."""
    width = None if stage.gear is None else stage.gear.face_width
    end = pin_distance(stage)
    return end if width is None else end - width / 2


def with_tilt(stage: Stage, body: SpatialBody, side: Side, carries: bool) -> SpatialBody:
    """Screw or nut with its tilts.

    **Arguments:**

    - `stage`: the stage.
    - `body`: screw or nut.
    - `side`: which of them.
    - `carries`: whether the planes of the carriers tilt with it.
    """
    inertia, fixed = tilting_inertia(stage, side), [side]
    if side == "nut" and stage.ring_gear is not None:
        fixed.append("ring_gear")
        apart = body_mass(stage, "ring_gear") * teeth_distance(stage) ** 2
        inertia = inertia + body_inertia(stage, "ring_gear") / 2 + apart
    if carries and stage.carrier is not None:
        fixed.append("carrier")
        inertia = inertia + stage.carrier.count * body_inertia(stage, "carrier") / 2
    squared = nominal_radius(stage.thread, side) ** 2
    held = supports(stage, tuple(fixed), "tilting", inertia)
    return dataclasses.replace(body, tilt_mass=inertia / squared, tilt_support=held / squared)


def opposite_carriers(stage: Stage, carriers: SpatialBody) -> SpatialBody:
    """Both carriers moving oppositely: equal masses and supports, so those of the sum.

    **Raises:** `ValueError` unless there are two.
    """
    assert stage.carrier is not None
    if stage.carrier.count != 2:
        raise ValueError(
            f"carrier.count is {stage.carrier.count}, but tilting rollers need a carrier at either "
            "end; give 2, or leave tilt out"
        )
    return dataclasses.replace(carriers, name=OPPOSITE_CARRIERS)
