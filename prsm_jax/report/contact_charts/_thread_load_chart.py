"""Load per thread on both sides and both flanks: bars for one class of rollers, a map for many."""

from typing import Any

import numpy as np

from ...fields import renamed_arguments
from ...load_sharing import LoadDistribution, SideLoads
from ...text import display_unit, in_unit, number
from .._style import FAINT, INK, MUTED, SERIES, SMALL, TITLE, Axes, Figure, drawn, page_figure

_SIDES = (("screw", "screw side"), ("nut", "nut side"))
_FORWARD, _REVERSE = SERIES[0], SERIES[1]


@renamed_arguments(found="distribution")
@drawn
def thread_load_chart(distribution: LoadDistribution) -> Figure:
    """Draw how threads share the load, screw side above, nut side below.

    Equal rollers are drawn as bars of one roller: loads of the forward flanks, which a positive
    load presses, point up, those of the opposite flanks down. Unequal rollers are drawn as maps of
    rollers over threads, one for each modelled flank, all with the same colour scale, with the sum
    of each roller beside them.

    **Arguments:**

    - `distribution`: a load distribution, with concrete numbers.

    **Returns:** a matplotlib figure; loads in N, threads counted from the end of the nut where the
    screw's force enters.

    **Raises:** `MissingExtraError` without matplotlib.
    """
    return _bars(distribution) if len(distribution.rollers) == 1 else _maps(distribution)


def _title(distribution: LoadDistribution) -> str:
    load = in_unit(distribution.load, display_unit("N", float(distribution.load)), 3)
    return f"Load per thread under {load}"


def _bars(distribution: LoadDistribution) -> Figure:
    figure = page_figure(110)
    rows = figure.subplots(2, 1, sharex=True)
    for axes, (name, words) in zip(rows, _SIDES, strict=True):
        side: SideLoads = getattr(distribution, name)
        forward = np.asarray(side.forward)[0]
        threads = np.arange(1, len(forward) + 1)
        axes.bar(threads, forward, width=0.7, color=_FORWARD, label="forward flanks")
        if side.reverse is not None:
            reverse = np.asarray(side.reverse)[0]
            style = {"facecolor": _REVERSE, "hatch": "////", "edgecolor": "white"}
            axes.bar(threads, -reverse, width=0.7, label="opposite flanks", **style)
            axes.axhline(0, color=INK, lw=0.6)
        _mean_line(axes, side, len(forward))
        factor = number(float(side.thread_sharing_factor), 3)
        axes.set_title(f"{_title(distribution)}: {words}, largest over mean {factor}")
        axes.set_ylabel("axial load in N")
        axes.yaxis.set_major_formatter(lambda value, _: f"{abs(value):g}")
        axes.grid(axis="y")
    rows[1].set_xticks(_ticks(len(np.asarray(distribution.screw.forward)[0])))
    rows[1].set_xlabel("thread, from the end where the screw's force enters")
    rows[1].set_xlim(0.3, np.asarray(distribution.screw.forward).shape[1] + 0.7)
    handles, labels = rows[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def _mean_line(axes: Axes, side: SideLoads, count: int) -> None:
    mean = abs(float(np.asarray(side.roller_load)[0])) / count
    if mean > 0:
        sign = np.sign(float(np.asarray(side.roller_load)[0]))
        label = "shared equally by all threads"
        axes.axhline(sign * mean, color=MUTED, lw=1.0, ls=(0, (4, 2)), label=label)


def _ticks(count: int, most: int = 25) -> np.ndarray:
    step = next(s for s in (1, 2, 5, 10, 20, 50, 100, 1000) if count / s <= most)
    ticks = np.arange(0, count + 1, step)
    return np.unique(np.where(ticks == 0, 1, ticks))


def _flanks_of(distribution: LoadDistribution, name: str) -> list[tuple[str, np.ndarray]]:
    """Loads on each modelled flank of one side, a row per roller."""
    side: SideLoads = getattr(distribution, name)
    pairs = [("forward flanks", side.forward), ("opposite flanks", side.reverse)]
    return [
        (words, np.asarray(distribution.by_roller(values)[1]))
        for words, values in pairs
        if values is not None
    ]


def _maps(distribution: LoadDistribution) -> Figure:
    from matplotlib.colors import LinearSegmentedColormap

    numbers, _ = distribution.by_roller(distribution.screw.forward)
    sides = [(name, words, _flanks_of(distribution, name)) for name, words in _SIDES]
    # One map for each flank: their difference would hide the forces that wedge a roller.
    largest = max(values.max() for *_, flanks in sides for _, values in flanks) or 1.0
    scale = LinearSegmentedColormap.from_list("load", ["#ffffff", "#cfe3f1", _FORWARD, "#00263d"])
    columns = len(sides[0][2])
    figure = page_figure(2 * (4.5 * len(numbers) + 20) + 24)
    grid = figure.subplots(
        2, columns + 1, width_ratios=[5 / columns] * columns + [1.3], sharey="row", sharex="col"
    )
    image = None
    for row, (_, words, flanks) in zip(grid, sides, strict=True):
        for axes, (flank, values) in zip(row, flanks, strict=False):
            image = axes.imshow(
                values,
                aspect="auto",
                cmap=scale,
                vmin=0.0,
                vmax=largest,
                extent=(0.5, values.shape[1] + 0.5, len(numbers) - 0.5, -0.5),
                interpolation="nearest",
            )
            axes.set_title(f"{words}, {flank}")
            axes.set_xticks(_ticks(values.shape[1], 25 if columns == 1 else 8))
            axes.tick_params(length=0)
            axes.spines[["top", "right"]].set_visible(True)
        row[0].set_ylabel("roller")
        row[0].set_yticks(range(len(numbers)), [str(n) for n in numbers])
        _sums(row[-1], [values.sum(axis=1) for _, values in flanks])
    between = " " if columns == 1 else "\n"
    for axes in grid[1, :-1]:
        axes.set_xlabel(f"thread, from the end where{between}the screw's force enters")
    grid[1, -1].set_xlabel("load of a roller in N")
    factors = [
        f"{words} {number(float(getattr(distribution, name).thread_sharing_factor), 3)}"
        for name, words in _SIDES
    ]
    title = f"{_title(distribution)}; largest over mean: {', '.join(factors)}"
    figure.suptitle(title, x=0.01, ha="left", fontsize=TITLE, fontweight="bold")
    handles, labels = grid[0, -1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    assert image is not None
    bar = figure.colorbar(image, ax=grid[:, -1].tolist(), aspect=40, pad=0.08)
    bar.set_label("axial load of a thread in N")
    bar.outline.set_linewidth(0.4)
    bar.ax.tick_params(labelsize=SMALL)
    return figure


def _sums(axes: Axes, sums: list[np.ndarray]) -> None:
    """Total load of each roller: forward flanks to the right, opposite ones to the left."""
    places = range(len(sums[0]))
    axes.barh(places, sums[0], height=0.7, color=_FORWARD, label="forward flanks")
    net = sums[0]
    if len(sums) > 1:
        hatched: Any = {"facecolor": _REVERSE, "hatch": "////", "edgecolor": "white"}
        axes.barh(places, -sums[1], height=0.7, label="opposite flanks", **hatched)
        axes.axvline(0, color=INK, lw=0.6)
        net = sums[0] - sums[1]
        mark: Any = {"marker": "D", "ms": 4, "mfc": INK, "mec": "white", "mew": 0.6, "zorder": 3}
        axes.plot(net, places, ls="", label="difference of both", **mark)
    style: Any = {"color": MUTED, "lw": 1.0, "ls": (0, (4, 2)), "zorder": 2}
    axes.axvline(net.mean(), label="shared equally by rollers", **style)
    axes.xaxis.set_major_formatter(lambda value, _: f"{abs(value):g}")
    axes.grid(axis="x", color=FAINT)
    axes.tick_params(axis="y", length=0)
    axes.set_title("sum")
