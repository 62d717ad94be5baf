"""The stages seen along and across their axis, drawn once and then moved."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...mechanism import Mechanism
from .._style import BODY_COLOURS, INK, MUTED, Axes
from ..drawings import DrawingDimensions, drawing_dimensions, roller_places
from ._body_motion import BodyMotion, ModeMotion, drawn_radii
from ._moving_view import MovingView

_EDGE = "#3c4043"
#: Gap between two nuts in a row, in roller radii.
_GAP = 1.0


@dataclass(frozen=True)
class Pose:
    """Positions of all bodies: angles from the start [rad], travel of each nut [mm].

    `turned` has the body that turns; of an inverted roller screw the travel is that of the screw.
    """

    turned: dict[str, float]
    carriers: tuple[float, ...]
    rollers: tuple[float, ...]
    travel: tuple[float, ...]


def turning_view(axes: Axes, mechanism: Mechanism, stage: int) -> MovingView:
    """The view along the axis of one stage, whose bodies `turn_to` moves."""
    part = mechanism.stages[stage - 1]
    screw, roller, nut, centre = drawn_radii(part)
    still = {"shift_x": 0.0, "shift_y": 0.0, "rotation_displacement": 1.0}
    bodies = [
        BodyMotion("nut", "nut", 0.0, 0.0, nut, **still),
        BodyMotion("screw", "screw", 0.0, 0.0, screw, **still),
    ]
    for number, (angle, present) in enumerate(roller_places(part), start=1):
        if present:
            x, y = centre * math.cos(angle), centre * math.sin(angle)
            bodies.append(BodyMotion(f"roller {number}", "roller", x, y, roller, **still))
    bodies.append(BodyMotion("carrier", "carrier", 0.0, 0.0, centre, **still))
    motion = ModeMotion(1, 1, 0.0, "rigid", tuple(bodies), (), {}, {})
    view = MovingView(axes, motion, arrows=False, line=0.9)
    for artist in view.resting:
        artist.set_visible(False)
    return view


def turn_to(view: MovingView, pose: Pose, stage: int) -> None:
    """Turn screw, carrier and rollers; the rollers circle with the carrier."""
    carrier, roller = pose.carriers[stage - 1], pose.rollers[stage - 1]
    angles = {"nut": 0.0, "screw": 0.0, "carrier": carrier} | pose.turned

    def place(body: BodyMotion) -> tuple[float, float, float]:
        if body.kind != "roller":
            return body.x, body.y, angles[body.kind]
        angle = math.atan2(body.y, body.x) + carrier
        centre = math.hypot(body.x, body.y)
        return centre * math.cos(angle), centre * math.sin(angle), carrier + roller

    view.place(place)


class TelescopeView:
    """Half-section of all stages along their common axis, each screw carried by the nut before it.

    Lengths that the mechanism does not give are drawn as long as the travel requires.
    """

    def __init__(self, axes: Axes, mechanism: Mechanism, travel: np.ndarray):
        """`travel`: of every nut [mm], stage × time."""
        self._axes = axes
        self._dims = [drawing_dimensions(mechanism, k + 1) for k in range(len(mechanism.stages))]
        self._moving: list[tuple[int, str, list[Any]]] = []
        self._screws: list[Any] = []
        own = np.diff(np.concatenate([np.zeros((1, travel.shape[1])), travel]), axis=0)
        start = 0.0
        edges = []
        for stage, dims in enumerate(self._dims):
            nut = dims.drawn_nut_length
            gap = _GAP * dims.roller_radius
            back, ahead = float(own[stage].min()), float(own[stage].max())
            first = start - min(back, 0.0) + gap
            self._screw(stage, dims, start, first + nut + max(ahead, 0.0) + gap)
            self._nut(stage, dims, first, first + nut)
            edges.append(first + nut + max(ahead, 0.0) + gap)
            # The next screw begins at the far end of this nut.
            start = first + nut
        outer = max(dims.drawn_outer_radius for dims in self._dims)
        left = min(0.0, float(travel.min())) - 3
        right = max(edge + max(float(travel.max()), 0.0) for edge in edges) + 3
        axes.set_axis_off()
        axes.set_aspect("equal")
        axes.set_xlim(left, right)
        axes.set_ylim(-0.12 * outer, 1.06 * outer)
        axes.plot((left, right), (0, 0), color=MUTED, lw=0.7, ls=(0, (9, 2, 1.5, 2)))

    def move(self, pose: Pose) -> None:
        """Shift every screw and nut by its travel; threads move along as the screw turns."""
        from matplotlib.transforms import Affine2D

        for stage, body, artists in self._moving:
            before = pose.travel[stage - 1] if stage else 0.0
            # An inverted screw takes its thread and the rollers along, and its nut turns in place.
            inverted = self._dims[stage].family.turning == "nut"
            moves = body != "nut" if inverted else body in ("nut", "rollers")
            shift = pose.travel[stage] if moves else before
            if body == "thread" and not inverted:
                dims = self._dims[stage]
                # A thread of n starts looks the same after a pitch, L / n.
                along = dims.lead * pose.turned["screw"] / (2 * math.pi)
                shift = before + along % dims.pitch
            place = Affine2D().translate(shift, 0.0) + self._axes.transData
            for artist in artists:
                artist.set_transform(place)
                if body == "thread":
                    # Lines end at the ends of their screw; a clip path does not follow by itself.
                    artist.set_clip_path(self._screws[stage])

    def _box(self, left: float, right: float, low: float, high: float, body: str, layer: int):
        from matplotlib.patches import Rectangle

        style: Any = {"facecolor": BODY_COLOURS[body], "edgecolor": _EDGE, "lw": 0.6}
        box = Rectangle((left, low), right - left, high - low, zorder=layer, **style)
        return self._axes.add_patch(box)

    def _screw(self, stage: int, dims: DrawingDimensions, left: float, right: float) -> None:
        inner = dims.bore_radius or 0.0
        if stage:
            # A later screw is a tube around the one before it.
            inner = max(inner, self._dims[stage - 1].screw_radius)
        box = self._box(left, right, inner, dims.screw_radius, "screw", 2 + 4 * stage)
        self._moving.append((stage, "screw", [box]))
        self._screws.append(box)
        lines = []
        for x in np.arange(left - dims.pitch, right, dims.pitch).tolist():
            (line,) = self._axes.plot(
                (x, x + 0.5 * dims.pitch),
                (max(inner, 0.55 * dims.screw_radius), dims.screw_radius),
                color=INK,
                lw=0.35,
                alpha=0.6,
                zorder=3 + 4 * stage,
            )
            lines.append(line)
        self._moving.append((stage, "thread", lines))

    def _nut(self, stage: int, dims: DrawingDimensions, left: float, right: float) -> None:
        layer = 4 + 4 * stage
        top = self._box(left, right, dims.nut_radius, dims.drawn_outer_radius, "nut", layer)
        half = min(dims.drawn_roller_length, 0.92 * (right - left)) / 2
        middle = (left + right) / 2
        ends, radii = (middle - half, middle + half), (dims.screw_radius, dims.nut_radius)
        self._moving.append((stage, "nut", [top]))
        artists = [self._box(*ends, *radii, "roller", layer + 1)]
        for sign in (-1, 1)[: dims.carrier_count or 0]:
            end = middle + sign * half
            near, far = sorted((end, end + sign * 0.35 * dims.roller_radius))
            low, high = (dims.centre_distance + k * dims.roller_radius for k in (-0.5, 0.5))
            artists.append(self._box(near, far, low, high, "carrier", layer + 1))
        self._moving.append((stage, "rollers", artists))
