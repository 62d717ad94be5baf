"""Thread profiles in the axial section through the axes of screw and roller."""

import functools
import math
from typing import Any

import numpy as np

from ._drawing_dimensions import DrawingDimensions

_SAMPLES = 12


def screw_half_thickness(dims: DrawingDimensions, height: Any) -> Any:
    """Half the thickness of a screw tooth at a height above the nominal radius [mm]."""
    return dims.pitch / 4 - dims.screw_thinning / 2 - height * math.tan(dims.flank_angle)


def nut_half_thickness(dims: DrawingDimensions, height: Any) -> Any:
    """Half the thickness of a nut tooth at a height inside the nominal radius [mm]."""
    return dims.pitch / 4 - dims.nut_thinning / 2 - height * math.tan(dims.flank_angle)


def roller_half_thickness(dims: DrawingDimensions, height: Any) -> Any:
    """Half the thickness of a roller tooth: two convex arcs; p/2 thick less the thinning."""
    radius, angle = dims.profile_radius, dims.flank_angle
    square = radius**2 - (height + radius * math.sin(angle)) ** 2
    arc = np.sqrt(np.maximum(square, 0.0))
    return dims.pitch / 4 - dims.roller_thinning / 2 + arc - radius * math.cos(angle)


def thread_profile(half_thickness, addendum: float, dedendum: float, centres):
    """Outline of a row of teeth.

    **Arguments:**

    - `half_thickness`: function of the height above the nominal radius [mm].
    - `addendum`, `dedendum`: height of the crest above it and depth of the root below it [mm].
    - `centres`: axial positions of the teeth, ascending [mm].

    **Returns:** axial positions and heights above the nominal radius, two arrays [mm].
    """
    heights = np.linspace(-dedendum, addendum, _SAMPLES)
    # A tooth ends in a point where its flanks meet below the crest.
    heights = heights[half_thickness(heights) > 0]
    halves = half_thickness(heights)
    along = np.concatenate([[*(c - halves), *(c + halves)[::-1]] for c in centres])
    return along, np.tile(np.concatenate([heights, heights[::-1]]), len(centres))


def screw_profile(dims: DrawingDimensions, centres):
    """Outline of the screw's thread: axial position and radius [mm]."""
    half = functools.partial(screw_half_thickness, dims)
    along, height = thread_profile(half, dims.screw_addendum, dims.screw_dedendum, centres)
    return along, dims.screw_radius + height


def roller_profile(dims: DrawingDimensions, centres, side: int):
    """Outline of the roller's thread towards the nut (+1) or the screw (−1) [mm]."""
    half = functools.partial(roller_half_thickness, dims)
    along, height = thread_profile(half, dims.roller_addendum, dims.roller_dedendum, centres)
    return along, dims.centre_distance + side * (dims.roller_radius + height)


def nut_profile(dims: DrawingDimensions, centres):
    """Outline of the nut's thread, which points inwards: axial position and radius [mm]."""
    half = functools.partial(nut_half_thickness, dims)
    along, height = thread_profile(half, dims.screw_addendum, dims.nut_dedendum, centres)
    return along, dims.nut_radius - height


def screw_shift(dims: DrawingDimensions) -> float:
    """How far the screw is drawn from the middle, so that its loaded flanks touch [mm]."""
    return -(dims.screw_thinning + dims.roller_thinning) / 2


def nut_shift(dims: DrawingDimensions) -> float:
    """How far the nut is drawn from the middle, so that its loaded flanks touch [mm]."""
    return (dims.nut_thinning + dims.roller_thinning) / 2


def tooth_centres(dims: DrawingDimensions, start: float, end: float, shifted: bool):
    """Axial positions of whole teeth between two ends, without `screw_shift`, `nut_shift` [mm].

    The teeth of the roller's single thread towards the nut are half a pitch (`shifted`) from those
    towards the screw; the screw's teeth lie in the gaps of the latter, the nut's in the gaps of the
    former.
    """
    shift = 0.5 if shifted else 0.0
    first = math.ceil(start / dims.pitch + 0.5 - shift)
    last = math.floor(end / dims.pitch - 0.5 - shift)
    return dims.pitch * (np.arange(first, last + 1) + shift)
