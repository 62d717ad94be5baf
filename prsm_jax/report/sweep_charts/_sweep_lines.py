"""A quantity over one axis of a sweep, and over each axis of a list of designs."""

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from .._parts import in_words, page_title
from .._style import SERIES, Figure, page_figure, readable
from ._boundaries import (
    OUTSIDE,
    WITHIN,
    crossings,
    draw_levels,
    draw_on_axis,
    limit_entries,
)
from ._common import (
    label_of,
    mark,
    mark_best,
    marks_of,
    sweep_legend,
    title_of,
    unit_of,
)
from ._limits import Best, QuantityLimit, best_design, outside_of


def sweep_lines(
    part: Any,
    quantity: str,
    axis: str,
    limits: Sequence[QuantityLimit],
    sense: Literal["maximise", "minimise"],
    note: str = "",
) -> Figure:
    """A line for each component of a quantity over one axis."""
    data = part[quantity]
    unit, x_unit = unit_of(data, quantity), unit_of(part[axis])
    x, y = x_unit(np.asarray(part[axis].values, float)), unit(np.asarray(data.values, float))
    figure = page_figure(90 + 4 * len(limits), 150)
    axes = figure.add_subplot()
    words = list(data["component"].values)
    # A design between two that failed has no neighbour to draw a line to.
    marker: dict[str, Any] = {"marker": "o", "ms": 3} if len(x) <= 30 else {}
    for index, word in enumerate(words):
        style: dict[str, Any] = {"label": str(word)} if len(words) > 1 else {}
        axes.plot(x, y[:, index], color=SERIES[index % len(SERIES)], lw=1.4, **marker, **style)
    axes.margins(y=0.1)
    mark(axes, x, y, *marks_of(part))
    entries = []
    if limits:
        draw_on_axis(axes, x, limits, quantity)
        levels = draw_levels(axes, limits, quantity, unit, np.asarray(data.values, float))
        lines = [
            level
            or (one.quantity != quantity and bool(crossings(x, np.asarray(one.excess.values))))
            for one, level in zip(limits, levels, strict=True)
        ]
        entries = limit_entries(limits, lines)
        if len(words) == 1:
            best = _best(part, quantity, limits, sense)
            place = best.place[0]
            mark_best(axes, x[place], y[place, 0], best, unit, entries)
    axes.set_xlabel(label_of(axis, x_unit))
    axes.set_ylabel(in_words(readable(quantity), unit))
    axes.set_title(title_of(quantity))
    sweep_legend(figure, entries, note, most=2 if limits else 4)
    return figure


def _best(part: Any, quantity: str, limits: Sequence[QuantityLimit], sense: Any) -> Best:
    data = part[quantity].isel(component=0)
    outside = outside_of(limits, data).values
    values = np.asarray(data.values, float)
    return best_design(values, marks_of(part)[1], outside, sense)


def sweep_points(
    part: Any,
    quantity: str,
    limits: Sequence[QuantityLimit],
    sense: Literal["maximise", "minimise"],
    note: str = "",
) -> Figure:
    """Points of a quantity against each axis of a list of designs."""
    data = part[quantity]
    unit = unit_of(data, quantity)
    values = np.asarray(data.values, float)
    y = unit(values)
    (design,) = part["code"].dims
    names = [str(name) for name, c in part.coords.items() if c.dims == (design,)]
    columns = 2 if len(names) == 4 else min(3, len(names))
    rows = -(-len(names) // columns)
    # Words of limits need the width.
    width = max(30 + 55 * columns, 120 if limits else 0)
    figure = page_figure(20 + 60 * rows + 4 * len(limits), width)
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True)
    words = list(data["component"].values)
    failed, errors = marks_of(part)
    outside = np.zeros(len(y), bool)
    levels: list[bool] = []
    entries: list[Any] = []
    best = None
    if limits:
        outside = outside_of(limits, data.isel(component=0)).values
        for axes in panels.ravel():
            levels = draw_levels(axes, limits, quantity, unit, values)
        entries = limit_entries(limits, levels, hatched=False)
        best = _best(part, quantity, limits, sense) if len(words) == 1 else None
    size = 3 if len(y) < 500 else 1.5
    for place, axes in enumerate(panels.ravel()):
        if place >= len(names):
            axes.remove()
            continue
        x_unit = unit_of(part[names[place]])
        x = x_unit(np.asarray(part[names[place]].values, float))
        for index, word in enumerate(words):
            style: dict[str, Any] = {"label": str(word)} if len(words) > 1 else {}
            style |= {"ls": "", "marker": "o", "ms": size, "color": SERIES[index % len(SERIES)]}
            inside = style | {"mew": 0}
            if len(words) == 1 and outside.any() and not outside.all():
                inside["label"] = WITHIN
            axes.plot(x[~outside], y[~outside, index], **inside)
            if outside.any():
                hollow = style | {"mfc": "white", "mew": 0.6, "label": OUTSIDE}
                axes.plot(x[outside], y[outside, index], **hollow)
        mark(axes, x, y, failed, errors)
        if best is not None:
            at = best.place[0]
            mark_best(axes, x[at], y[at, 0], best, unit, entries)
        axes.set_xlabel(label_of(names[place], x_unit))
        if place % columns == 0:
            axes.set_ylabel(in_words(readable(quantity), unit))
    page_title(figure, title_of(quantity))
    sweep_legend(figure, entries, note, most=2 if limits else 4)
    return figure
