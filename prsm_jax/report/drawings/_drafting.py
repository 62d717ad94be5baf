"""What views are drawn on, in real millimetres; and a sheet of a figure, of a known scale."""

import math
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np

from .._parts import CHAIN
from .._style import BODY_COLOURS, INK, MUTED, SMALL, Axes, Figure, place_axes

#: A length on the drawing or on paper [mm].
Length: TypeAlias = float | int
CONTACT_COLOURS = {"screw": "#d55e00", "nut": "#0072b2"}

_ARROW = {"arrowstyle": "<|-|>", "mutation_scale": 5.5, "shrinkA": 0, "shrinkB": 0}


@runtime_checkable
class Canvas(Protocol):
    """What a view is drawn on: a `Sheet` of a figure, or a drawing of another format.

    Lengths and places are in real millimetres. A style has the words of matplotlib; a format
    without them ignores it, but for dashes (`ls`).
    """

    @property
    def ends(self) -> tuple[float, float]:
        """The abscissae at which the canvas ends on the left and on the right."""
        ...

    def paper(self, millimetres: Length) -> float:
        """A length on paper as a length on the drawing."""
        ...

    def text(self, x: Length, y: Length, words: str, **style: Any) -> None:
        """Words at a point."""
        ...

    def line(self, xs: Any, ys: Any, *, body: str = "", **style: Any) -> None:
        """A line through points, an edge of a body if it is named."""
        ...

    def centre_line(self, xs: Any, ys: Any) -> None:
        """A chain line: an axis or a pitch circle."""
        ...

    def area(self, xs: Any, ys: Any, body: str, hatch: str = "", outlined: bool = True) -> None:
        """A closed area of a body, cut if it is hatched."""
        ...

    def circle(
        self, radius: Length, name: str, at: tuple[Length, Length] = (0, 0), **style: Any
    ) -> None:
        """A circle; its name begins with the body: "nut outside"."""
        ...

    def marks(self, xs: Any, ys: Any, side: str) -> None:
        """Contact points with the screw or the nut."""
        ...

    def horizontal_dimension(
        self, x0: Length, x1: Length, y: Length, words: str, start: Length, beside: bool = False
    ) -> None:
        """A dimension between two abscissae at height y, with extension lines from `start`."""
        ...

    def leader(
        self, x: Length, y: Length, words_x: Length, words_y: Length, words: str, **style: Any
    ) -> None:
        """Words with an arrow to a point."""
        ...

    def scale_bar(self, x: Length, y: Length, length: Length) -> None:
        """A bar of a real length."""
        ...


@dataclass(frozen=True)
class Sheet:
    """Axes in real millimetres, `scale` millimetres on paper for each."""

    axes: Axes
    scale: Length

    @property
    def ends(self) -> tuple[float, float]:
        """The abscissae at which the sheet ends on the left and on the right."""
        return self.axes.get_xlim()

    def paper(self, millimetres: Length) -> float:
        """A length on paper as a length on the drawing."""
        return millimetres / self.scale

    def text(self, x: Length, y: Length, words: str, **kwargs) -> None:
        """Words at a point."""
        style = {"fontsize": SMALL, "color": INK, "ha": "center", "va": "center"} | kwargs
        self.axes.text(x, y, words, **style)

    def area(self, xs, ys, body: str, hatch: str = "", outlined: bool = True) -> None:
        """A closed area of a body in its colour, cut if it is hatched."""
        from matplotlib.patches import Polygon

        points = np.column_stack([xs, ys])
        style = {"facecolor": BODY_COLOURS[body], "linewidth": 0, "edgecolor": MUTED}
        self.axes.add_patch(Polygon(points, closed=True, hatch=hatch, **style))
        if outlined:
            outline = {"facecolor": "none", "edgecolor": INK, "linewidth": 0.6}
            self.axes.add_patch(Polygon(points, closed=True, label=body, **outline))

    def circle(
        self, radius: Length, name: str, at: tuple[Length, Length] = (0, 0), **kwargs
    ) -> None:
        """A circle, by default without filling."""
        from matplotlib.patches import Circle

        style = {"facecolor": "none", "edgecolor": INK, "linewidth": 0.8} | kwargs
        self.axes.add_patch(Circle(at, radius, label=name, **style))

    def marks(self, xs, ys, side: str) -> None:
        """Contact points with the screw or the nut."""
        style = {"ms": 2.6, "mfc": CONTACT_COLOURS[side], "mec": "white", "mew": 0.3, "zorder": 4}
        self.axes.plot(xs, ys, "o", **style)

    def line(self, xs, ys, *, body: str = "", **kwargs) -> None:
        """A thin line."""
        self.axes.plot(xs, ys, **({"color": MUTED, "lw": 0.5, "solid_capstyle": "butt"} | kwargs))

    def centre_line(self, xs, ys) -> None:
        """A chain line: an axis or a pitch circle."""
        self.line(xs, ys, ls=CHAIN)

    def horizontal_dimension(
        self, x0: Length, x1: Length, y: Length, words: str, start: Length, beside: bool = False
    ) -> None:
        """A dimension between two abscissae at height y, with extension lines from height `start`.

        The words stand over the line, or beside it where there is no room.
        """
        overshoot = math.copysign(self.paper(0.8), y - start)
        for x in (x0, x1):
            self.line((x, x), (start, y + overshoot), lw=0.35)
        arrow = {**_ARROW, "color": INK, "lw": 0.5}
        self.axes.annotate("", (x0, y), (x1, y), arrowprops=arrow, annotation_clip=False)
        if beside:
            self.text(x1 + self.paper(1.2), y, words, ha="left")
        else:
            # Extension lines of wider dimensions pass behind the words, not through them.
            behind = {"facecolor": "white", "edgecolor": "none", "pad": 0.4}
            above = y + self.paper(0.7)
            self.text((x0 + x1) / 2, above, words, va="bottom", bbox=behind, zorder=6)

    def leader(
        self, x: Length, y: Length, words_x: Length, words_y: Length, words: str, **kwargs
    ) -> None:
        """Words with an arrow to a point."""
        arrow = {"arrowstyle": "-|>", "mutation_scale": 5.5, "color": INK, "lw": 0.5, "shrinkB": 0}
        self.axes.annotate(
            words,
            (x, y),
            (words_x, words_y),
            fontsize=SMALL,
            color=INK,
            arrowprops=arrow,
            annotation_clip=False,
            **({"ha": "left", "va": "center"} | kwargs),
        )

    def scale_bar(self, x: Length, y: Length, length: Length) -> None:
        """A bar of a real length."""
        tick = self.paper(0.8)
        self.line((x, x + length), (y, y), color=INK, lw=1.2)
        for end in (x, x + length):
            self.line((end, end), (y - tick, y + tick), color=INK, lw=0.7)
        self.text(x + length / 2, y + self.paper(0.9), f"{length:g} mm", va="bottom")


def place_sheet(
    figure: Figure,
    left: Length,
    bottom: Length,
    width: Length,
    height: Length,
    scale: Length,
    lowest_y: Length,
) -> Sheet:
    """A sheet at a place on the page [mm], centred on x = 0, from `lowest_y` upwards."""
    axes = place_axes(figure, left, bottom, width, height)
    axes.set_axis_off()
    axes.set_xlim(-width / scale / 2, width / scale / 2)
    axes.set_ylim(lowest_y, lowest_y + height / scale)
    axes.set_aspect("equal")
    return Sheet(axes, scale)
