"""A drawing sheet: real millimetres on axes of a known scale, with dimension lines."""

import abc
import math
from dataclasses import dataclass
from typing import Any, TypeAlias

from .._parts import CHAIN
from .._style import INK, MUTED, SMALL, Axes, Figure, place_axes

#: A length on the drawing or on paper [mm].
Length: TypeAlias = float | int

_ARROW = {"arrowstyle": "<|-|>", "mutation_scale": 5.5, "shrinkA": 0, "shrinkB": 0}


class AbstractSheet(abc.ABC):
    """A sheet in real millimetres, `scale` millimetres on paper for each.

    Styles have matplotlib's names, whoever draws.
    """

    scale: Length

    def paper(self, millimetres: Length) -> float:
        """A length on paper as a length on the drawing."""
        return millimetres / self.scale

    @property
    @abc.abstractmethod
    def span(self) -> tuple[float, float]:
        """Smallest and largest x."""

    @abc.abstractmethod
    def text(self, x: Length, y: Length, words: str, **kwargs: Any) -> None:
        """Words at a point."""

    @abc.abstractmethod
    def line(self, xs, ys, **kwargs: Any) -> None:
        """A thin line."""

    @abc.abstractmethod
    def circle(self, at: tuple[Length, Length], radius: Length, **kwargs: Any) -> None:
        """A circle, filled or not."""

    @abc.abstractmethod
    def polygon(self, points, **kwargs: Any) -> None:
        """A closed polygon, filled or not."""

    @abc.abstractmethod
    def dots(self, xs, ys, colour: str) -> None:
        """Points of contact."""

    @abc.abstractmethod
    def double_arrow(self, x0: Length, x1: Length, y: Length) -> None:
        """A horizontal line with an arrow at each end."""

    @abc.abstractmethod
    def leader(
        self, x: Length, y: Length, words_x: Length, words_y: Length, words: str, **kwargs: Any
    ) -> None:
        """Words with an arrow to a point."""

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
        self.double_arrow(x0, x1, y)
        if beside:
            self.text(x1 + self.paper(1.2), y, words, ha="left")
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
    def span(self) -> tuple[float, float]:
        return self.axes.get_xlim()

    def text(self, x: Length, y: Length, words: str, **kwargs: Any) -> None:
        style = {"fontsize": SMALL, "color": INK, "ha": "center", "va": "center"} | kwargs
        self.axes.text(x, y, words, **style)

    def line(self, xs, ys, **kwargs: Any) -> None:
        self.axes.plot(xs, ys, **({"color": MUTED, "lw": 0.5, "solid_capstyle": "butt"} | kwargs))

    def circle(self, at: tuple[Length, Length], radius: Length, **kwargs: Any) -> None:
        from matplotlib.patches import Circle

        self.axes.add_patch(Circle(at, radius, **kwargs))

    def polygon(self, points, **kwargs: Any) -> None:
        from matplotlib.patches import Polygon

        self.axes.add_patch(Polygon(points, closed=True, **kwargs))

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
