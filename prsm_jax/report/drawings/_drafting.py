"""Drawing sheets of a known scale; one of them on axes of matplotlib."""

import abc
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._parts import CHAIN
from .._style import BODY_COLOURS, INK, MUTED, SMALL, Axes, Figure, place_axes
from ._canvas import CONTACT_COLOURS, Beside, Length

_ARROW = {"arrowstyle": "<|-|>", "mutation_scale": 5.5, "shrinkA": 0, "shrinkB": 0}


class AbstractSheet(abc.ABC):
    """A `Canvas` with `scale` millimetres on paper for each real one.

    What a view draws is made of the few shapes that a format has to know. Styles have matplotlib's
    names, whoever draws.
    """

    scale: Length

    @property
    @abc.abstractmethod
    def ends(self) -> tuple[float, float]:
        """The abscissae at which the sheet ends on the left and on the right."""

    @abc.abstractmethod
    def text(self, x: Length, y: Length, words: str, **kwargs: Any) -> None:
        """Words at a point."""

    @abc.abstractmethod
    def line(self, xs, ys, *, body: str = "", **kwargs: Any) -> None:
        """A thin line."""

    @abc.abstractmethod
    def polygon(self, points, **kwargs: Any) -> None:
        """A closed polygon, filled or not."""

    @abc.abstractmethod
    def disc(self, at: tuple[Length, Length], radius: Length, **kwargs: Any) -> None:
        """A circle, filled or not."""

    @abc.abstractmethod
    def dots(self, xs, ys, colour: str) -> None:
        """Points of a colour."""

    @abc.abstractmethod
    def double_arrow(self, x0: Length, x1: Length, y: Length) -> None:
        """A horizontal line with an arrow at each end."""

    @abc.abstractmethod
    def leader(
        self, x: Length, y: Length, words_x: Length, words_y: Length, words: str, **kwargs: Any
    ) -> None:
        """Words with an arrow to a point."""

    def paper(self, millimetres: Length) -> float:
        """A length on paper as a length on the drawing."""
        return millimetres / self.scale

    def area(self, xs, ys, body: str, hatch: str = "", outlined: bool = True) -> None:
        """A closed area of a body in its colour, cut if it is hatched."""
        points = np.column_stack([xs, ys])
        style = {"facecolor": BODY_COLOURS[body], "linewidth": 0, "edgecolor": MUTED}
        self.polygon(points, hatch=hatch, **style)
        if outlined:
            self.polygon(points, label=body, facecolor="none", edgecolor=INK, linewidth=0.6)

    def circle(
        self, radius: Length, name: str, at: tuple[Length, Length] = (0, 0), **kwargs: Any
    ) -> None:
        """A circle, by default without filling."""
        style = {"facecolor": "none", "edgecolor": INK, "linewidth": 0.8} | kwargs
        self.disc(at, radius, label=name, **style)

    def marks(self, xs, ys, side: str) -> None:
        """Contact points with the screw or the nut."""
        self.dots(xs, ys, CONTACT_COLOURS[side])

    def centre_line(self, xs, ys) -> None:
        """A chain line: an axis or a pitch circle."""
        self.line(xs, ys, ls=CHAIN)

    def horizontal_dimension(
        self, x0: Length, x1: Length, y: Length, words: str, start: Length, beside: Beside = ""
    ) -> None:
        """A dimension between two abscissae at height y, with extension lines from height `start`.

        The words stand over the line, or beside it on the left or right where there is no room.
        """
        overshoot = math.copysign(self.paper(0.8), y - start)
        for x in (x0, x1):
            self.line((x, x), (start, y + overshoot), lw=0.35)
        self.double_arrow(x0, x1, y)
        if beside == "right":
            self.text(x1 + self.paper(1.2), y, words, ha="left")
        elif beside == "left":
            self.text(x0 - self.paper(1.2), y, words, ha="right")
        else:
            # Extension lines of wider dimensions pass behind the words, not through them.
            behind = {"facecolor": "white", "edgecolor": "none", "pad": 0.4}
            above = y + self.paper(0.7)
            self.text((x0 + x1) / 2, above, words, va="bottom", bbox=behind, zorder=6)

    def scale_bar(self, x: Length, y: Length, length: Length) -> None:
        """A bar of a real length."""
        tick = self.paper(0.8)
        self.line((x, x + length), (y, y), color=INK, lw=1.2)
        for end in (x, x + length):
            self.line((end, end), (y - tick, y + tick), color=INK, lw=0.7)
        self.text(x + length / 2, y + self.paper(0.9), f"{length:g} mm", va="bottom")


@dataclass(frozen=True)
class Sheet(AbstractSheet):
    """A sheet on axes of matplotlib."""

    axes: Axes
    scale: Length

    @property
    def ends(self) -> tuple[float, float]:
        return self.axes.get_xlim()

    def text(self, x: Length, y: Length, words: str, **kwargs: Any) -> None:
        style = {"fontsize": SMALL, "color": INK, "ha": "center", "va": "center"} | kwargs
        self.axes.text(x, y, words, **style)

    def line(self, xs, ys, *, body: str = "", **kwargs: Any) -> None:
        self.axes.plot(xs, ys, **({"color": MUTED, "lw": 0.5, "solid_capstyle": "butt"} | kwargs))

    def polygon(self, points, **kwargs: Any) -> None:
        from matplotlib.patches import Polygon

        self.axes.add_patch(Polygon(points, closed=True, **kwargs))

    def disc(self, at: tuple[Length, Length], radius: Length, **kwargs: Any) -> None:
        from matplotlib.patches import Circle

        self.axes.add_patch(Circle(at, radius, **kwargs))

    def dots(self, xs, ys, colour: str) -> None:
        self.axes.plot(xs, ys, "o", ms=2.6, mfc=colour, mec="white", mew=0.3, zorder=4)

    def double_arrow(self, x0: Length, x1: Length, y: Length) -> None:
        arrow = {**_ARROW, "color": INK, "lw": 0.5}
        self.axes.annotate("", (x0, y), (x1, y), arrowprops=arrow, annotation_clip=False)

    def leader(
        self, x: Length, y: Length, words_x: Length, words_y: Length, words: str, **kwargs: Any
    ) -> None:
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
