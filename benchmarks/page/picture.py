"""The chart of one problem on the page, from its JSON: largest error against run time."""

from pathlib import Path
from typing import Any

from ..harness import save_picture
from .front import error_of, is_ours, is_single, on_front

_COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#7f7f7f",
    "#8c564b", "#9467bd",
)  # fmt: skip
_MARKERS = "osD^vPX<>*"
#: What agrees to the last bit has no place on a logarithmic axis.
_FLOOR = 1e-17
#: Letters of a name that half the width of a figure holds.
_FITS = 56


def _number(value: Any) -> str:
    if not isinstance(value, int | float):
        return str(value)
    if value and not 1e-2 < value < 1e5:
        return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")
    return f"{value:g}"


def label_of(rows: list[dict[str, Any]]) -> str:
    """Name of a method and the range of its settings."""
    first, last = rows[0]["setting"], rows[-1]["setting"]
    label = rows[0]["method"]
    if first is not None:
        label += f", {first['name']} {_number(first['value'])}"
        if last != first:
            label += f" … {_number(last['value'])}"
    return label + ("" if is_ours(rows[0]) else " (rival)")


def draw(problem: dict[str, Any], path: Path) -> Path | None:
    """Draw one problem; `None` where no row has an error.

    Full markers are ours, hollow ones with dashed lines rivals. A ring is a default, a grey stair
    the front of ours in a batch, a dotted one that of single calls. An error below 1e-17 stands
    there.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullFormatter

    rows = [row for row in problem["results"] if error_of(row) is not None]
    if not rows:
        return None
    names = list(dict.fromkeys(row["method"] for row in rows))
    figure = Figure(figsize=(8.0, 4.4 + 0.1 * len(names)), dpi=100, layout="constrained")
    axes = figure.subplots()
    handles = []
    for index, name in enumerate(names):
        own = [row for row in rows if row["method"] == name]
        colour = _COLOURS[index % len(_COLOURS)]
        (line,) = axes.plot(
            [row["best_s"] for row in own],
            [max(error_of(row) or 0.0, _FLOOR) for row in own],
            color=colour,
            marker=_MARKERS[(index + index // len(_COLOURS)) % len(_MARKERS)],
            markersize=7,
            markerfacecolor=colour if is_ours(own[0]) else "white",
            markeredgewidth=1.5,
            linestyle="-" if is_ours(own[0]) else "--",
            linewidth=1.2,
            label=label_of(own),
        )
        handles.append(line)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(0.1)
    for single, style in ((False, "-"), (True, ":")):
        front = [r for r in rows if is_ours(r) and is_single(r) == single and on_front(r, rows)]
        front.sort(key=lambda row: row["best_s"])
        if len(front) > 1:
            (line,) = axes.step(
                [row["best_s"] for row in front],
                [max(error_of(row) or 0.0, _FLOOR) for row in front],
                where="post",
                color="0.6",
                linestyle=style,
                linewidth=3,
                zorder=0.5,
                label="front of ours, " + ("one at a time" if single else "in a batch"),
            )
            handles.append(line)
    defaults = [row for row in rows if row.get("default")]
    if defaults:
        (ring,) = axes.plot(
            [row["best_s"] for row in defaults],
            [max(error_of(row) or 0.0, _FLOOR) for row in defaults],
            linestyle="none",
            marker="o",
            markersize=15,
            markerfacecolor="none",
            markeredgecolor="black",
            markeredgewidth=1.4,
            label="our default",
        )
        handles.append(ring)
    low, high = axes.get_ylim()
    if high < 50 * low:  # a single power of ten would leave the axis without labels
        axes.set_ylim(low / 10, high * 10)
    low, high = axes.get_xlim()
    if high < 50 * low:
        axes.set_xlim(low / 3, high * 3)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(numticks=9))
        axis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(f"run time per {problem['instance']} [s]")
    axes.set_ylabel("largest relative error [1]")
    figure.suptitle(problem["title"], fontsize=11)
    axes.grid(which="major", color="0.88", linewidth=0.8)
    axes.set_axisbelow(True)
    # Two columns of long names are wider than the figure.
    longest = max(len(handle.get_label()) for handle in handles)
    size = 8 if longest <= _FITS else 8 * _FITS / longest
    figure.legend(
        handles=handles, loc="outside lower center", ncols=2, fontsize=size, frameon=False
    )
    return save_picture(figure, path)
