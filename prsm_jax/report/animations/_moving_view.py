"""The view along the axis with every body displaced: drawn once, then moved."""

import math
from collections.abc import Callable
from typing import Any

from .._style import BODY_COLOURS, INK, Axes
from ._body_motion import BodyMotion, ModeMotion

#: Radial widths of the ring gear and of the nut, in roller radii: in the real mechanism the gear
#: lies beside the nut, here inside it.
_RING, _NUT = 0.55, 0.75
#: Drawn size of the largest displacement, as a share of the roller radius.
DRAWN_SHARE = 0.75
#: A body that moves by less than this share of the largest displacement gets no arrow.
_ARROW = 0.08
_REST, _EDGE, _ARROW_COLOUR = "#9aa0a6", "#3c4043", "#b3001b"


class MovingView:
    """Bodies on axes in millimetres, at rest in grey and displaced; `move` displaces them."""

    def __init__(self, axes: Axes, motion: ModeMotion, *, arrows: bool, line: float | int = 0.6):
        self._axes, self._motion, self._line = axes, motion, line
        rollers = [body for body in motion.bodies if body.kind == "roller"]
        self._roller = rollers[0].radius
        self._gear = any(body.kind == "ring_gear" for body in motion.bodies)
        self.scale = DRAWN_SHARE * self._roller / motion.largest
        self._moving: list[tuple[BodyMotion, list[Any]]] = []
        #: Outlines at rest, which lie over the bodies.
        self.resting: list[Any] = []
        axes.set_axis_off()
        axes.set_aspect("equal")
        nut = max(body.radius for body in motion.bodies)
        reach = nut + (_NUT + _RING * self._gear + DRAWN_SHARE) * self._roller
        axes.set_xlim(-reach, reach)
        axes.set_ylim(-reach, reach)
        for x, y in motion.empty:
            self._empty(x, y)
        for layer, body in enumerate(motion.bodies):
            self._rest(body)
            self._body(body, 2 + 0.1 * layer)
        self._arrows = [
            arrow for body in motion.bodies if arrows for arrow in self._body_arrows(body)
        ]
        self.move(1.0)

    def move(self, factor: float) -> None:
        """Displace every body by this share of the drawn amplitude, from −1 to 1."""
        self.place(lambda body: body.placed(factor * self.scale))

    def place(self, pose: Callable[[BodyMotion], tuple[float, float, float]]) -> None:
        """Place every body at a centre [mm] and an angle relative to its rest position [rad]."""
        from matplotlib.transforms import Affine2D

        for body, artists in self._moving:
            x, y, angle = pose(body)
            place = Affine2D().rotate(angle).translate(x, y) + self._axes.transData
            for artist in artists:
                artist.set_transform(place)

    @property
    def moving(self) -> list[Any]:
        """The artists that `move` moves."""
        return [artist for _, artists in self._moving for artist in artists]

    def _outline(self, body: BodyMotion) -> list[float]:
        """Radii of the circles of a body."""
        r, width = body.radius, self._roller
        if body.kind == "ring_gear":
            return [r, r + _RING * width]
        if body.kind == "nut":
            inner = r + (_RING * width if self._gear else 0)
            return [inner, inner + _NUT * width]
        return [r]

    def _mark(self, body: BodyMotion) -> float:
        """Angular position of the mark that shows the rotation of a body [rad]."""
        return math.atan2(body.y, body.x) if body.kind == "roller" else math.pi / 2

    def _rest(self, body: BodyMotion) -> None:
        from matplotlib.patches import Circle

        if body.kind == "carrier":
            return
        style = {"edgecolor": _REST, "lw": 0.8 * self._line, "zorder": 4}
        for radius in self._outline(body):
            outline = Circle((body.x, body.y), radius, fill=False, **style)
            self.resting.append(self._axes.add_patch(outline))
        cos, sin = math.cos(self._mark(body)), math.sin(self._mark(body))
        for inner, outer in self._mark_radii(body):
            self.resting += self._axes.plot(
                (body.x + inner * cos, body.x + outer * cos),
                (body.y + inner * sin, body.y + outer * sin),
                color=_REST,
                lw=0.8 * self._line,
                zorder=4,
            )

    def _empty(self, x: float, y: float) -> None:
        from matplotlib.patches import Circle

        style = {"edgecolor": _REST, "lw": 0.8 * self._line, "ls": (0, (3, 3)), "zorder": 1}
        place = Circle((x, y), self._roller, fill=False, label="empty place", **style)
        self.resting.append(self._axes.add_patch(place))

    def _mark_radii(self, body: BodyMotion) -> list[tuple[float, float]]:
        radii = self._outline(body)
        return [(0.0, radii[0]) if len(radii) == 1 else (radii[0], radii[1])]

    def _body(self, body: BodyMotion, layer: float) -> None:
        from matplotlib.patches import Annulus, Circle

        style = {"lw": self._line, "edgecolor": _EDGE, "zorder": layer}
        style["facecolor"] = BODY_COLOURS[body.kind]
        radii, artists = self._outline(body), []
        if body.kind == "carrier":
            ring = {**style, "facecolor": "none", "lw": 2.2 * self._line, "edgecolor": "#7a7f85"}
            artists.append(self._axes.add_patch(Circle((0, 0), body.radius, **ring)))
            for other in self._motion.bodies:
                if other.kind == "roller":
                    pin = {**style, "facecolor": "#7a7f85"}
                    place = (other.x, other.y)
                    artists.append(self._axes.add_patch(Circle(place, 0.16 * self._roller, **pin)))
        elif len(radii) == 1:
            artists.append(self._axes.add_patch(Circle((0, 0), radii[0], **style)))
        else:
            ring = Annulus((0, 0), radii[1], radii[1] - radii[0], **style)
            artists.append(self._axes.add_patch(ring))
        artists[0].set_label(body.name)
        artists += self._marks(body, layer + 0.05)
        self._moving.append((body, artists))

    def _marks(self, body: BodyMotion, layer: float) -> list[Any]:
        """A bold radius that shows the rotation, and thin ones that show the body's frame."""
        lines = []
        if body.kind == "carrier":
            return lines
        turns = 4 if len(self._outline(body)) == 1 else 12
        for inner, outer in self._mark_radii(body):
            for step in range(turns):
                angle = self._mark(body) + 2 * math.pi * step / turns
                cos, sin = math.cos(angle), math.sin(angle)
                (line,) = self._axes.plot(
                    (inner * cos, outer * cos),
                    (inner * sin, outer * sin),
                    color=INK if step == 0 else _EDGE,
                    lw=(2.4 if step == 0 else 0.5) * self._line,
                    alpha=1.0 if step == 0 else 0.45,
                    solid_capstyle="butt",
                    zorder=layer,
                )
                lines.append(line)
        return lines

    def _body_arrows(self, body: BodyMotion) -> list[Any]:
        """Arrows from the rest position of a point to its position at the drawn extreme."""
        least = _ARROW * self._motion.largest
        x, y, angle = body.placed(self.scale)
        arrows = []
        if math.hypot(body.shift_x, body.shift_y) > least:
            arrows.append(self._arrow([(body.x, body.y), (x, y)]))
        if abs(body.rotation_displacement) > least:
            radii = self._outline(body)
            # Inside the rim, where bodies touch; the carrier is only a rim.
            inside = 1.0 if body.kind == "carrier" else 0.86
            radius = inside * radii[0] if len(radii) == 1 else sum(radii) / 2
            start = self._mark(body)
            turned = [start + angle * step / 12 for step in range(13)]
            path = [(x + radius * math.cos(t), y + radius * math.sin(t)) for t in turned]
            arrows.append(self._arrow(path))
        return arrows

    def _arrow(self, points: list[tuple[float, float]]) -> Any:
        from matplotlib.patches import FancyArrowPatch
        from matplotlib.path import Path

        arrow = FancyArrowPatch(
            path=Path(points),
            arrowstyle="-|>",
            mutation_scale=8.5 * self._line,
            lw=1.7 * self._line,
            color=_ARROW_COLOUR,
            shrinkA=0,
            shrinkB=0,
            zorder=6,
        )
        return self._axes.add_patch(arrow)
