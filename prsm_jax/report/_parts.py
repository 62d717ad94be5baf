"""Parts that several pictures have: colour bars, legends, headings, words beside points, ticks."""

import math
from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np

from .._errors import UnknownNameError
from ..quantities import quantity_of
from ..text import DisplayUnit, digits_for
from ._style import BODY_COLOURS, INK, MUTED, SMALL, TITLE, Axes, Figure, readable

#: A place or a size in a picture.
Number: TypeAlias = float | int
#: Dashes of the first, second, … of several curves.
DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (6, 1.5, 1.5, 1.5)))
#: Dashes of an axis of symmetry.
CHAIN = (0, (9, 2, 1.5, 2))
#: Energy of a mode for which amplitudes are given [J].
MODE_ENERGY = 1e-3
#: Digits of a tick with which as many ticks as usual have room.
_SHORT = 4
#: Behind words that stand on lines.
WHITE = {"facecolor": "white", "edgecolor": "none"}


def in_words(name: str, unit: DisplayUnit) -> str:
    """A name with its unit, if it has one: "pressure in MPa"."""
    return f"{name} in {unit.label}" if unit.label else name


def page_title(figure: Figure, words: str) -> None:
    """A heading over all panels of a picture."""
    figure.suptitle(words, fontsize=TITLE, fontweight="bold", x=0.01, ha="left")


def colour_bar(figure: Figure, image: Any, axes: Any, words: str, **style: Any) -> Any:
    """A colour bar on the right of one or several panels."""
    style = {"location": "right", "shrink": 0.9, "pad": 0.02} | style
    bar = figure.colorbar(image, ax=axes, **style)
    bar.set_label(words, fontsize=SMALL)
    bar.outline.set_linewidth(0.4)
    return bar


def map_of_one_value(axes: Axes, xs: np.ndarray, ys: np.ndarray, values: Any) -> Any:
    """Colour of a quantity that is the same in all designs, which contours cannot show.

    Each design colours a cell around it. Those at an edge are cut at the ends of the computed
    ranges, so that the panel has the axes of panels with contours beside it.
    """
    known = np.ma.compressed(values)
    # A colour bar would widen the range of its own panel alone, which changes the colour there.
    value = float(known[0]) if known.size else 0.0
    width = 0.1 * abs(value) or 0.1
    style = {"cmap": "cividis", "vmin": value - width, "vmax": value + width}
    image = axes.pcolormesh(xs, ys, values, shading="nearest", **style)
    axes.set_xlim(xs.min(), xs.max())
    axes.set_ylim(ys.min(), ys.max())
    return image


def legend_below(figure: Figure, handles: Sequence[Any], most: int = 7, **style: Any) -> None:
    """A legend under the picture, with up to `most` columns; none without handles."""
    if handles:
        place = {"loc": "outside lower center", "ncols": min(len(handles), most)}
        figure.legend(handles=list(handles), **place, **style)


def legend_line(words: str, **style: Any) -> Any:
    """An entry of a legend for a line or a marker of a style."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=words, **style)


def dense_legend(figure: Figure, handles: Sequence[Any], place: tuple[Number, Number]) -> None:
    """A legend in one dense line, its lower edge at a place in the figure, from 0 to 1."""
    figure.legend(
        handles=list(handles),
        loc="lower center",
        bbox_to_anchor=place,
        ncols=len(handles),
        fontsize=SMALL,
        handlelength=1.3,
        columnspacing=1.2,
        borderaxespad=0,
        borderpad=0,
    )


def body_patches(bodies: Iterable[str]) -> list[Any]:
    """Entries of a legend for bodies in their colours."""
    from matplotlib.patches import Patch

    style = {"edgecolor": MUTED, "linewidth": 0.5}
    return [Patch(facecolor=BODY_COLOURS[b], label=readable(b), **style) for b in bodies]


def aside(
    axes: Axes, words: str, point: tuple[Any, Any], shift: tuple[Number, Number], **style: Any
) -> None:
    """Small words beside a point; `shift` from it in points, to the left if it is negative."""
    align = {"ha": "right"} if shift[0] < 0 else {}
    style = {"fontsize": SMALL} | align | style
    axes.annotate(words, point, shift, textcoords="offset points", **style)


def room_for_ticks(axes: Axes) -> None:
    """Fewer ticks on a horizontal axis whose numbers need many digits: they would overlap."""
    low, high = axes.get_xlim()
    if digits_for(max(abs(low), abs(high)), high - low) > _SHORT:
        axes.locator_params(axis="x", nbins=3)


def plain_ticks(axis: Any, form: str = "{:g}", subs: tuple[Number, ...] = (1.0, 2.0, 5.0)) -> None:
    """Plain numbers at the major ticks of a logarithmic axis, none at the minor ones."""
    from matplotlib.ticker import LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_major_formatter(lambda value, _: form.format(value).replace(",", " "))
    axis.set_minor_formatter(NullFormatter())


def draw_pressure(
    axes: Axes,
    pressure: Any,
    extent: tuple[Number, Number, Number, Number],
    highest: Number,
    ellipse: tuple[Number, Number],
    *,
    smooth: bool,
    dashes: str,
) -> Any:
    """Pressures of a contact [MPa] in colour, its Hertz ellipse and its axes; the image.

    **Arguments:**

    - `pressure`: over the tangent plane, rows along y; nothing is drawn where it is 0.
    - `extent`: of the picture, in the unit of the axes.
    - `highest`: where the scale of colours ends [MPa].
    - `ellipse`: its semi-axes.
    - `smooth`: whether colours between points are interpolated.
    - `dashes`: line style of the ellipse.
    """
    import numpy as np
    from matplotlib.patches import Ellipse

    image = axes.imshow(
        np.ma.masked_where(pressure <= 0, pressure),
        extent=extent,
        origin="lower",
        cmap="cividis",
        vmin=0,
        vmax=highest,
        interpolation="bilinear" if smooth else "nearest",
        aspect="equal",
    )
    size = 2 * ellipse[0], 2 * ellipse[1]
    style: Any = {"facecolor": "none", "edgecolor": INK, "linestyle": dashes}
    axes.add_patch(Ellipse((0, 0), *size, lw=0.8 if smooth else 0.9, **style))
    axes.axhline(0, color=INK, lw=0.3, ls=CHAIN)
    axes.axvline(0, color=INK, lw=0.3, ls=CHAIN)
    return image


def per_mode(energy: float, frequency: float) -> float:
    """Factor of a shape with the modal mass 1 at which a mode has this energy, √(2E)/(2πf) [√kg·m].

    **Arguments:**

    - `energy`: [J].
    - `frequency`: of the mode [Hz].
    """
    return math.sqrt(2 * energy) / (2 * math.pi * frequency)


def component_words(label: str) -> str:
    """A component of a quantity as words: `rating_life[2]` → "rating life, stage 2"."""
    name, _, index = label.partition("[")
    try:
        dimensions = quantity_of(label).dimensions
    except UnknownNameError:
        dimensions = ()
    numbers = index.rstrip("]").split(",") if index else []
    if len(numbers) != len(dimensions):
        return readable(label)
    places = [f"{readable(one)} {number}" for one, number in zip(dimensions, numbers, strict=True)]
    return ", ".join([readable(name), *places])
