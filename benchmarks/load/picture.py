"""Run time and memory over size."""

from pathlib import Path
from typing import Any

import numpy as np

from ..harness import save_picture
from .growth import finished

_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
_MARKERS = "osD^vPX"


def _label(task: dict[str, Any]) -> str:
    last, powers = finished(task["sizes"])[-1], task["exponents"]
    text = f"{task['title']}: up to {last['size']:,} {task['unit']}s"
    if powers["time"] is not None:
        text += f"; time as size to the {powers['time']:.2f}"
    if powers["memory"] is not None:
        text += f", memory to the {powers['memory']:.2f}"
    return text


def _slope(axes: Any) -> None:
    """Dotted lines that are linear."""
    low, high = axes.get_ylim()
    ends = np.array(axes.get_xlim())
    decades = np.arange(np.floor(np.log10(low * ends[0] / ends[1])), np.ceil(np.log10(high)) + 3)
    for start in 10.0**decades:
        axes.plot(ends, start * ends / ends[-1], color="0.75", ls=":", lw=0.9, zorder=0)
    axes.set(xlim=ends, ylim=(low, high))


def draw(tasks: list[dict[str, Any]], path: Path) -> Path:
    """Two panels as a PNG; sizes are shares of the largest one of a task that came to an end.

    **Arguments:**

    - `tasks`: what `load.json` has under that key.
    - `path`: where the picture goes; written whole or not at all.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.8 + 0.24 * len(tasks)), dpi=110, layout="constrained")
    by_time, by_memory = figure.subplots(1, 2)
    lines = []
    for index, task in enumerate(tasks):
        rows = finished(task["sizes"])
        if not rows:
            continue
        style: Any = {"color": _COLOURS[index % 7], "marker": _MARKERS[index % 7], "lw": 1.3}
        share = np.array([row["size"] for row in rows]) / rows[-1]["size"]
        times = [row["processor_s"] for row in rows]
        lines += by_time.plot(share, times, label=_label(task), **style)
        by_memory.plot(share, [row["run_bytes"] / 1e6 for row in rows], **style)
    for axes, name in ((by_time, "processor time [s]"), (by_memory, "memory [MB]")):
        axes.set(xscale="log", yscale="log", ylabel=name, xlabel="size over the largest size [1]")
        axes.grid(which="major", color="0.9", linewidth=0.8)
        axes.set_axisbelow(True)
        _slope(axes)
    figure.suptitle("Growth with size; dotted lines are linear", fontsize=12)
    figure.legend(handles=lines, loc="outside lower center", ncols=1, fontsize=9, frameon=False)
    return save_picture(figure, path)
