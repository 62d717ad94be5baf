"""The designs of a front across all their variables and objectives."""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...optimisation import FrontPoint, ParetoFront
from ...text import DisplayUnit, display_unit
from .._parts import colour_bar, in_words, legend_below, legend_line
from .._style import INK, MUTED, Figure, drawn, page_figure, readable
from ._front_chart import present_in_words

#: Room for the words below all axes, in letters, and the most and fewest letters in a line.
_ROOM, _LETTERS, _FEWEST = 84, 16, 9
_MARGIN = 0.04


@drawn
def parallel_chart(front: ParetoFront) -> Figure:
    """Draw each design of a front as a line across axes of its variables and objectives.

    Each axis has its own scale, over the designs that are drawn. Lines are coloured by the first
    objective. Designs that did not converge are dotted. The present design is dashed, where it is
    usable; the legend names the limits that it breaks.

    **Arguments:**

    - `front`: result of `pareto`.

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` for a front without points; `MissingExtraError` without matplotlib.
    """
    if not front.points:
        raise ValueError(f"the front has no points; there is nothing to draw: {front.message}")
    present = front.start if front.start.status != "fails" else None
    designs = [*front.points, *([] if present is None else [present])]
    senses = {one.quantity: one.sense for one in front.objectives}
    columns = [
        *(("variables", name, unit) for name, unit in front.variable_units.items()),
        *(("objectives", name, unit) for name, unit in front.objective_units.items()),
    ]
    values = np.array(
        [[getattr(one, group)[name] for group, name, _ in columns] for one in designs]
    )
    units = [
        display_unit(unit, column, name if group == "objectives" else "")
        for (group, name, unit), column in zip(columns, values.T, strict=True)
    ]
    shown = np.stack([one(column) for one, column in zip(units, values.T, strict=True)], axis=1)
    figure = page_figure(95)
    axes = figure.add_subplot()
    low, high = _scales(axes, shown)
    letters = max(_FEWEST, min(_LETTERS, _ROOM // (len(columns) - 1)))
    labels = [
        _label(name, unit, senses.get(name, "") if group == "objectives" else "", letters)
        for (group, name, _), unit in zip(columns, units, strict=True)
    ]
    axes.set_xticks(range(len(columns)), labels)
    first = len(front.variable_units)
    _lines(figure, axes, front.points, (shown - low) / (high - low), shown[:, first])
    bar = figure.axes[-1]
    bar.set_ylabel(in_words(readable(columns[first][1]), units[first]))
    entries = []
    if not all(one.status == "optimal" for one in front.points):
        entries.append(legend_line("not converged", color=MUTED, linestyle=":"))
    if present is not None:
        height = (shown[-1] - low) / (high - low)
        style: dict[str, Any] = {"color": INK, "linestyle": "--", "linewidth": 1.4}
        axes.plot(range(len(columns)), height, zorder=4, **style)
        entries.append(legend_line(present_in_words(front), **style))
    axes.set_title(f"{len(front.points)} designs of the front")
    legend_below(figure, entries)
    return figure


def _label(name: str, unit: DisplayUnit, sense: str, letters: int) -> str:
    # Parts of a path are words as well.
    words = readable(name).replace(".", " ")
    lines = textwrap.wrap(words, letters, break_long_words=False)
    if unit.label:
        # The unit stays beside its preposition.
        tail = f"in {unit.label}"
        fits = len(lines[-1]) + 1 + len(tail) <= letters
        lines[-1:] = [f"{lines[-1]} {tail}"] if fits else [lines[-1], tail]
    return "\n".join([*lines, *([f"({sense})"] if sense else [])])


def _scales(axes: Any, shown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """An axis for each column, with its own ticks; the values at their lower and upper ends."""
    low, high = shown.min(axis=0), shown.max(axis=0)
    # A number that all designs share lies in the middle.
    span = np.where(high > low, high - low, np.maximum(0.02 * np.abs(high), 1e-12))
    low, high = (
        np.where(high > low, low, low - span / 2) - _MARGIN * span,
        np.where(high > low, high, high + span / 2) + _MARGIN * span,
    )
    count = shown.shape[1]
    axes.set_xlim(-0.02 * count, count - 1 + 0.02 * count)
    axes.set_ylim(0, 1)
    axes.set_yticks([])
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)
    axes.tick_params(axis="x", length=0, pad=4)
    for column in range(count):
        own = axes.twinx()
        own.tick_params(axis="x", labelbottom=False)
        own.set_ylim(low[column], high[column])
        own.spines["right"].set_visible(True)
        own.spines["right"].set_position(("data", column))
        own.spines["left"].set_visible(False)
        own.spines["bottom"].set_visible(False)
        own.locator_params(axis="y", nbins=6)
        for tick in own.get_yticklabels():
            tick.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.6})
    return low, high


def _lines(
    figure: Figure, axes: Any, points: Sequence[FrontPoint], heights: np.ndarray, first: np.ndarray
) -> None:
    """Lines in the colour of the first objective, and its colour bar."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    scale = first[: len(points)]
    colours = ScalarMappable(Normalize(scale.min(), scale.max()), colormaps["cividis"])
    for one, height, value in zip(points, heights, scale, strict=False):
        dashes = "-" if one.status == "optimal" else ":"
        axes.plot(range(len(height)), height, color=colours.to_rgba(value), lw=1.2, ls=dashes)
    colour_bar(figure, colours, axes, "", pad=0.06)
