"""Log–log charts of error against run time."""

import copy
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ._atomic import save_picture
from .case import Problem
from .measure import Measurement

#: Errors below are drawn here: a value that agrees to the last bit has no place on a log axis.
_FLOOR = 1e-17
#: An axis that spans less than this factor has labels at 2 and 5 as well.
_NARROW = 50.0

_COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#7f7f7f",
    "#8c564b", "#9467bd",
)  # fmt: skip
_MARKERS = "osD^vPX<>*"
#: Around what a user of the package gets without asking.
_RING: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 15,
    "markerfacecolor": "none",
    "markeredgecolor": "black",
    "markeredgewidth": 1.4,
}


def _setting(value) -> str:
    if not isinstance(value, float | int):
        return str(value)
    if value and not 1e-2 < value < 1e4:
        return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")
    return f"{value:g}"


def _label(rows: Sequence[Measurement]) -> str:
    first, last = rows[0], rows[-1]
    label = first.method + (" (rival)" if first.kind == "rival" else "")
    if first.setting is None:
        return label
    values = _setting(first.setting)
    if last is not first:
        values += " … " + _setting(last.setting)
    return f"{label}, {first.setting_name} {values}"


def _draw_method(axes, rows: Sequence[Measurement], quantity: str, index: int):
    drawn = [row for row in rows if row.errors[quantity].maximum is not None]
    times = np.array([row.best for row in drawn])
    largest = np.array([row.errors[quantity].maximum for row in drawn], dtype=float)
    median = np.array([row.errors[quantity].median for row in drawn], dtype=float)
    rival = rows[0].kind == "rival"
    colour, marker = _COLOURS[index % len(_COLOURS)], _MARKERS[index % len(_MARKERS)]
    axes.vlines(
        times, np.maximum(median, _FLOOR), np.maximum(largest, _FLOOR), colour, alpha=0.35, lw=1
    )
    (line,) = axes.plot(
        times,
        np.maximum(largest, _FLOOR),
        color=colour,
        marker=marker,
        markersize=7,
        markerfacecolor="white" if rival else colour,
        markeredgewidth=1.6,
        linestyle="--" if rival else "-",
        linewidth=1.3,
        label=_label(rows),
    )
    for time, row in zip(times, drawn, strict=True):
        if row.default:
            place = max(float(row.errors[quantity].maximum or 0.0), _FLOOR)
            axes.plot([time], [place], **_RING)
    return line


def _whose(measured: Sequence[Measurement]) -> str:
    """Which instances the errors are those of: the run times are those of all."""
    compared = {error.instances for row in measured for error in row.errors.values()}
    solved = {row.instances for row in measured}
    first, most = max(compared), max(solved)
    if first >= most:
        return f"of all {most}"
    return f"of the first {first} instances; a call solves up to {most}"


def draw(problem: Problem, measured: Sequence[Measurement], path: Path) -> Path:
    """Draw one problem as a PNG: a panel per quantity, a line per method through its settings.

    Markers stand at the largest error and the best time; a thin stroke leads to the median error.
    Hollow markers and dashed lines are rivals from outside.

    **Arguments:**

    - `problem`, `measured`: what `measure` took and gave.
    - `path`: where the picture goes; written whole or not at all.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator, NullFormatter

    quantities = list(measured[0].errors)
    methods = [method.name for method in problem.methods]
    legend_rows = -(-len(methods) // 2)
    width = max(8.0, 1.5 + 4.6 * len(quantities))
    figure = Figure(figsize=(width, 4.9 + 0.24 * legend_rows), dpi=110, layout="constrained")
    panels = figure.subplots(1, len(quantities), squeeze=False, sharey=True)[0]
    every_label = LogFormatterSciNotation(labelOnlyBase=False, minor_thresholds=(9.0, 9.0))
    lines = []
    for axes, quantity in zip(panels, quantities, strict=True):
        lines = [
            _draw_method(axes, [r for r in measured if r.method == name], quantity, index)
            for index, name in enumerate(methods)
        ]
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.margins(0.08)
        axes.set_title(quantity, fontsize=11)
        axes.set_xlabel(f"run time per {problem.instance} [s]")
        axes.grid(which="major", color="0.85", linewidth=0.8)
        axes.set_axisbelow(True)
        for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            axis.set_major_locator(LogLocator(numticks=9))
            axis.set_minor_formatter(NullFormatter())
            if high < _NARROW * low:
                # Powers of ten alone would leave one label, or none.
                axis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
                axis.set_minor_formatter(copy.copy(every_label))
                axis.set_tick_params(which="minor", labelsize=8)
    panels[0].set_ylabel(f"relative error, largest (stroke: to the median) [1]\n{_whose(measured)}")
    if any(row.default for row in measured):
        lines.append(panels[0].plot([], [], label="ring: our default", **_RING)[0])
    figure.suptitle(problem.title, fontsize=12)
    figure.legend(handles=lines, loc="outside lower center", ncols=2, fontsize=9, frameon=False)
    return save_picture(figure, path, bbox_inches="tight")
