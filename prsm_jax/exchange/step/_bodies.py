"""What a threaded body needs to become a solid: its profile and its lengths."""

import dataclasses
import functools
import math
from collections.abc import Callable
from typing import Any, Literal, TypeAlias

import numpy as np

from ..._errors import MissingDataError, PrsmError
from ...mechanism import Mechanism
from ...report.drawings import (
    DrawingDimensions,
    drawing_dimensions,
    nut_half_thickness,
    roller_half_thickness,
    screw_half_thickness,
)

StepBody: TypeAlias = Literal["screw", "roller", "nut"]
#: Points of the Gauss–Legendre rule over a flank.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclasses.dataclass(frozen=True)
class ThreadedBody:
    """A cylinder with a helical thread over its whole length [mm].

    - `radius`: nominal radius of the thread; `other_radius`: of the bore, or outside of a nut.
    - `inward`: whether the thread points to the axis, as that of a nut.
    - `addendum`, `dedendum`: height of the crest above the nominal radius, and depth of the root.
    - `half_thickness`: half the axial thickness of a tooth at a height.
    - `starts`, `pitch`, `hand`: of the thread; the hand is +1 for a right-hand one.
    - `length`: along the axis.
    """

    radius: float
    other_radius: float
    inward: bool
    addendum: float
    dedendum: float
    half_thickness: Callable[[Any], Any]
    starts: int
    pitch: float
    hand: int
    length: float

    @property
    def lead(self) -> float:
        """Axial travel of the thread in one turn [mm]."""
        return self.starts * self.pitch

    def radius_at(self, height: Any) -> Any:
        """Radius at a height above the nominal radius, towards the crest [mm]."""
        return self.radius - height if self.inward else self.radius + height

    @property
    def half_at_crest(self) -> float:
        """Half the width of the crest [mm]."""
        return float(self.half_thickness(np.asarray(self.addendum)))

    @property
    def half_at_root(self) -> float:
        """Half the thickness of a tooth at the root [mm]."""
        return float(self.half_thickness(np.asarray(-self.dedendum)))

    @property
    def volume(self) -> float:
        r"""Volume of the exact solid [mm³].

        Every transverse section has the same area,
        $\frac{\pi}{p} \int_0^p r(s)^2\,\mathrm{d}s$ over a pitch of the axial section: by Pappus'
        theorem the volume is that of the same profile turned about the axis.
        """
        crest, root = self.half_at_crest, self.half_at_root
        middle, reach = (self.addendum - self.dedendum) / 2, (self.addendum + self.dedendum) / 2
        halves = self.half_thickness(middle + reach * _NODES)
        # ∫ r² dh of a flank by parts: with dr/dy the derivatives of the profile are not needed.
        slope = -1.0 if self.inward else 1.0
        inner = reach * np.sum(_WEIGHTS * halves * self.radius_at(middle + reach * _NODES))
        squares = self.radius_at(self.addendum) ** 2, self.radius_at(-self.dedendum) ** 2
        flanks = 2 * (root * squares[1] - crest * squares[0] + 2 * slope * float(inner))
        whole = 2 * crest * squares[0] + (self.pitch - 2 * root) * squares[1] + flanks
        thread = math.pi / self.pitch * whole * self.length
        other = math.pi * self.other_radius**2 * self.length
        return other - thread if self.inward else thread - other


def threaded_body(mechanism: Mechanism, body: StepBody, stage: int) -> ThreadedBody:
    """Dimensions of a body for its solid.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `body`: `"screw"`, `"roller"` or `"nut"`.
    - `stage`: which stage, counted from 1.

    **Raises:** `MissingDataError` without length or wall of the nut; `PrsmError` for grooves,
    a number of starts that is not whole, and teeth that are pointed or touch at their roots;
    `ValueError` for another body or stage.
    """
    dims = drawing_dimensions(mechanism, stage)
    if dims.family.roller_hand == 0:
        raise PrsmError("solids are of threads, and these rollers have grooves; export the drawing")
    if dims.starts != round(dims.starts):
        raise PrsmError(f"{dims.starts} starts cannot be made; set a whole number of starts")
    found = _found(dims, body)
    if found.half_at_crest <= 0 or 2 * found.half_at_root >= found.pitch:
        raise PrsmError(
            f"the teeth of the {body} are pointed at the crest, or touch at the root; give them a "
            "lower addendum (stage.thread)"
        )
    return found


def _needed(value: float | None, name: str) -> float:
    if value is None:
        raise MissingDataError(f"a solid needs stage.{name}; give it")
    return value


def _found(dims: DrawingDimensions, body: StepBody) -> ThreadedBody:
    starts = round(dims.starts)
    if body == "roller":
        half = functools.partial(roller_half_thickness, dims)
        heights = dims.roller_addendum, dims.roller_dedendum
        radii, inward = (dims.roller_radius, dims.roller_bore_radius or 0.0), False
        length, hand, starts = dims.roller_length, dims.family.roller_hand, 1
    elif body == "screw":
        half = functools.partial(screw_half_thickness, dims)
        heights = dims.screw_addendum, dims.screw_dedendum
        radii, inward = (dims.screw_radius, dims.bore_radius or 0.0), False
        length, hand = dims.screw_length, 1
    elif body == "nut":
        half = functools.partial(nut_half_thickness, dims)
        heights = dims.screw_addendum, dims.nut_dedendum
        wall = _needed(dims.nut_outer_radius, "nut.wall_thickness")
        radii, inward = (dims.nut_radius, wall), True
        length, hand = dims.nut_length, 1
    else:
        raise ValueError(f"there are no solids of {body!r}; choose screw, roller or nut")
    return ThreadedBody(
        *radii,
        inward,
        *heights,
        half_thickness=half,
        starts=starts,
        pitch=dims.pitch,
        hand=hand,
        length=_needed(length, f"{body}.length"),
    )
