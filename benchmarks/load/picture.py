"""Run time and memory over size, and error over run time."""

from pathlib import Path
from typing import Any

import numpy as np

from ..harness import written_whole

_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#000000")
_MARKERS = "osD^vP"
#: Errors below are drawn here: a value that agrees to the last bit has no place on a log axis.
_FLOOR = 1e-17


def _label(task: dict[str, Any]) -> str:
    last, powers = task["sizes"][-1], task["exponents"]
    text = f"{task['title']}: {last['count']:,} {task['unit']}s"
    if powers["time"] is not None:
        text += f", time ∝ size^{powers['time']:.2f}"
    if powers["memory"] is not None:
        text += f", memory ∝ size^{powers['memory']:.2f}"
    return text


def draw(tasks: list[dict[str, Any]], path: Path) -> Path:
    """Three panels as a PNG; sizes are shares of the largest one of a task.

    **Arguments:**

    - `tasks`: what `load.json` has under that key.
    - `path`: where the picture goes; written whole or not at all.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.5, 4.9 + 0.24 * len(tasks)), dpi=110, layout="constrained")
    by_time, by_memory, by_error = figure.subplots(1, 3)
    lines = []
    for index, task in enumerate(tasks):
        rows = task["sizes"]
        style: Any = {"color": _COLOURS[index % 6], "marker": _MARKERS[index % 6], "lw": 1.3}
        share = np.array([row["count"] for row in rows]) / rows[-1]["count"]
        times = np.array([row["best_s"] for row in rows])
        lines += by_time.plot(share, times, label=_label(task), **style)
        memory = [np.nan if row["run_bytes"] is None else row["run_bytes"] / 1e6 for row in rows]
        if np.isfinite(memory).any():
            by_memory.plot(share, memory, **style)
        errors = np.array([np.nan if row["error"] is None else row["error"] for row in rows])
        if np.isfinite(errors).any():
            by_error.plot(times, np.maximum(errors, _FLOOR), **style)
    panels = [axes for axes in (by_time, by_memory, by_error) if axes.lines]
    for axes in panels:
        axes.set(xscale="log", yscale="log")
        axes.grid(which="major", color="0.85", linewidth=0.8)
        axes.set_axisbelow(True)
    for axes, name in ((by_time, "run time of the whole [s]"), (by_memory, "memory taken [MB]")):
        axes.set(xlabel="size over the largest size [1]", ylabel=name)
        low, high = axes.get_ylim()
        ends = np.array(axes.get_xlim())
        if axes not in panels:  # nothing was measured
            continue
        # Parallel to these is linear.
        for start in np.geomspace(low, high, 4)[1:]:
            axes.plot(ends, start * ends / ends[-1], color="0.6", ls=":", lw=0.9, zorder=0)
        axes.set(xlim=ends, ylim=(low, high))
    by_error.set(xlabel="run time of the whole [s]", ylabel="largest relative error [1]")
    figure.suptitle("Growth with size; dotted: linear", fontsize=12)
    figure.legend(handles=lines, loc="outside lower center", ncols=1, fontsize=9, frameon=False)
    with written_whole(path) as temporary:
        figure.savefig(temporary)
    return path
