"""A figure read as its reader does: every curve, bar, marker, limit line and word, once.

`Chart` gives the artists of a figure with their data in SI, by the units that the axes name, and
remembers which were read: `finish` fails if a curve, a bar, a marker, an image or a word with a
number was not.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from numpy.typing import ArrayLike
from reading_artists import box_of, x_data
from reading_units import assert_reads, label_unit, same_dimension, to_si

Expected = ArrayLike


def _ticks(axes: Axes) -> set[int]:
    found = set()
    for axis in (axes.xaxis, axes.yaxis):
        for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
            found |= {id(tick.label1), id(tick.label2)}
    return found


class Chart:
    """A figure, and what of it has been read."""

    def __init__(self, figure):
        self.figure = figure
        self._read: set[int] = set()

    # --- axes and their units

    @property
    def axes(self) -> list[Axes]:
        """All axes that are seen."""
        return [axes for axes in self.figure.axes if axes.get_visible()]

    def unit(self, axes: Axes, way: str) -> str:
        """The unit that an axis names, by itself or by the one it is shared with."""
        group = axes.get_shared_x_axes() if way == "x" else axes.get_shared_y_axes()
        every = [axes, *group.get_siblings(axes)]
        labels = [a.get_xlabel() if way == "x" else a.get_ylabel() for a in every]
        return label_unit(next((label for label in labels if label), ""))

    def si(self, axes: Axes, way: str, values, si_unit: str):
        """Numbers along an axis in SI; the axis must measure what is expected."""
        label = self.unit(axes, way)
        assert same_dimension(label, si_unit), f"axis in {label!r}, expected {si_unit!r}"
        return to_si(values, label)

    # --- artists

    def take(self, *artists: Any) -> None:
        """Mark artists as read."""
        self._read |= {id(artist) for artist in artists}

    def lines(self, axes: Axes, keep=lambda _: True) -> list[Line2D]:
        """Lines of axes that were not read yet."""
        return [one for one in axes.lines if id(one) not in self._read and keep(one)]

    def curve(
        self, axes: Axes, line: Line2D, x: Expected | None, y: Expected | None, units, **tolerance
    ) -> None:
        """A line lies at these coordinates [SI]; `None` is not looked at.

        **Arguments:**

        - `axes`, `line`: which.
        - `x`, `y`: expected coordinates [SI].
        - `units`: SI units of both.
        """
        for way, data, wanted, si_unit in zip(
            "xy", (line.get_xdata(), line.get_ydata()), (x, y), units, strict=True
        ):
            if wanted is None:
                continue
            found = self.si(axes, way, np.asarray(data, float), si_unit)
            wanted = np.asarray(wanted, float)
            scale = float(np.nanmax(np.abs(wanted), initial=0.0))
            limits: dict[str, Any] = {"rtol": 1e-9, "atol": 1e-9 * scale} | tolerance
            np.testing.assert_allclose(found, np.broadcast_to(wanted, found.shape), **limits)
        self.take(line)

    def level(self, axes: Axes, value: float, si_unit: str, way: str = "y") -> Line2D:
        """The line across the axes at a value [SI] of an axis."""
        for line in self.lines(axes):
            data = np.asarray(line.get_ydata() if way == "y" else line.get_xdata(), float)
            other = np.asarray(line.get_xdata() if way == "y" else line.get_ydata(), float)
            if len(data) == 2 and data[0] == data[1] and list(other) == [0, 1]:
                found = self.si(axes, way, data[0], si_unit)
                if abs(found - value) <= 1e-9 * max(abs(value), 1e-300):
                    self.take(line)
                    return line
        raise AssertionError(f"no line at {value} {si_unit}")

    def bars(
        self, axes: Axes, lengths: Expected, si_unit: str, way: str = "y", starts: Any = None
    ) -> None:
        """The next bars that were not read have these lengths [SI] and starts."""
        wanted = np.atleast_1d(np.asarray(lengths, float))
        bars = [p for p in axes.patches if id(p) not in self._read][: len(wanted)]
        assert len(bars) == len(wanted)
        size = [box_of(p).get_height() if way == "y" else box_of(p).get_width() for p in bars]
        limits: dict[str, Any] = {"rtol": 1e-9, "atol": 1e-9 * float(np.abs(wanted).max())}
        np.testing.assert_allclose(self.si(axes, way, size, si_unit), wanted, **limits)
        begin = [box_of(p).get_y() if way == "y" else box_of(p).get_x() for p in bars]
        starts = np.zeros(len(bars)) if starts is None else np.asarray(starts, float)
        np.testing.assert_allclose(self.si(axes, way, begin, si_unit), starts, **limits)
        self.take(*bars)

    # --- words

    def words(self) -> list[Text]:
        """All words to be seen that are no ticks and were not read."""
        ticks = set().union(*(_ticks(axes) for axes in self.figure.axes), set())
        hidden = {
            id(text)
            for axes in self.figure.axes
            if not axes.get_visible()
            for text in axes.findobj(Text)
        }
        return [
            text
            for text in self.figure.findobj(Text)
            if text.get_visible()
            and text.get_text().strip()
            and id(text) not in ticks | hidden | self._read
        ]

    def text(self, start: str = "", *, within: str = "", place: Axes | None = None) -> str:
        """The first words not read that begin so, or have that within; they count as read."""
        inside = None if place is None else {id(one) for one in place.findobj(Text)}
        for text in self.words():
            words = text.get_text()
            if inside is not None and id(text) not in inside:
                continue
            if words.startswith(start) and within in words:
                self.take(text)
                return words
        left = [text.get_text() for text in self.words()]
        raise AssertionError(f"no words {start!r} … {within!r}; left are {left}")

    def says(
        self, start: str, *expected: tuple, within: str = "", coarse: bool = False, place=None
    ) -> str:
        """Words that begin so have these numbers, `(SI value, SI unit)` in order."""
        words = self.text(start, within=within, place=place)
        assert_reads(words.removeprefix(start), *expected, coarse=coarse)
        return words

    def ticks(self, axes: Axes, way: str = "y") -> list[str]:
        """Labels of the ticks of an axis."""
        labels = axes.get_yticklabels() if way == "y" else axes.get_xticklabels()
        return [label.get_text() for label in labels]

    # --- the end

    def ignore(self, artists: Iterable[Any]) -> None:
        """Artists without a number: axes of symmetry, arrows, legends."""
        self.take(*artists)

    def unread(self) -> list[str]:
        """What a reader sees and no expectation has looked at."""
        left = []
        for axes in self.axes:
            for artist in [*axes.lines, *axes.patches, *axes.collections, *axes.images]:
                if id(artist) in self._read or not artist.get_visible():
                    continue
                if isinstance(artist, Line2D) and not len(x_data(artist)):
                    continue
                kind = next(
                    k for k in (Line2D, Patch, Collection, AxesImage) if isinstance(artist, k)
                )
                left.append(f"{kind.__name__} {artist.get_label()!r} of {axes.get_title('left')!r}")
        left += [
            repr(text.get_text())
            for text in self.words()
            if any(character.isdigit() for character in text.get_text())
        ]
        return left

    def finish(self) -> None:
        """Nothing with a number was left unread."""
        assert self.unread() == []


def handles(figure) -> list[str]:
    """Words of all legends of a figure and of its axes."""
    legends = [*figure.legends, *(a.get_legend() for a in figure.axes)]
    return [text.get_text() for legend in legends if legend is not None for text in legend.texts]
