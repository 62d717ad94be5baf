"""Load per thread on both sides and both flanks: bars for one class of rollers, a map for many."""

import numpy as np

from ..load_sharing import LoadDistribution, SideLoads
from ._style import FAINT, INK, MUTED, SERIES, SMALL, Axes, Figure, drawn, page_figure
from ._units import display_unit, in_unit, number

_SIDES = (("screw", "screw side"), ("nut", "nut side"))
_FORWARD, _REVERSE = SERIES[0], SERIES[1]


@drawn
def thread_load_chart(found: LoadDistribution) -> Figure:
    """Draw how threads share the load, screw side above, nut side below.

    With equal rollers one stands for all, as bars; the flanks that a positive load presses point
    up, the opposite flanks down. Unequal rollers are a map of rollers over threads beside it.

    **Arguments:**

    - `found`: a load distribution, with concrete numbers.

    **Returns:** a matplotlib figure; loads in N, threads counted from the end of the nut where the
    screw's force enters.

    **Raises:** `MissingExtraError` without matplotlib.
    """
    return _bars(found) if len(found.rollers) == 1 else _maps(found)


def _title(found: LoadDistribution) -> str:
    load = in_unit(found.load, display_unit("N", float(found.load)), 3)
    return f"Load per thread under {load}"


def _bars(found: LoadDistribution) -> Figure:
    figure = page_figure(110)
    rows = figure.subplots(2, 1, sharex=True)
    for axes, (name, words) in zip(rows, _SIDES, strict=True):
        side: SideLoads = getattr(found, name)
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
        axes.set_title(f"{_title(found)}: {words}, largest over mean {factor}")
        axes.set_ylabel("axial load in N")
        axes.yaxis.set_major_formatter(lambda value, _: f"{abs(value):g}")
        axes.grid(axis="y")
    rows[1].set_xticks(_ticks(len(np.asarray(found.screw.forward)[0])))
    rows[1].set_xlabel("thread, from the end where the screw's force enters")
    rows[1].set_xlim(0.3, np.asarray(found.screw.forward).shape[1] + 0.7)
    handles, labels = rows[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def _mean_line(axes: Axes, side: SideLoads, count: int) -> None:
    mean = abs(float(np.asarray(side.roller_load)[0])) / count
    if mean > 0:
        sign = np.sign(float(np.asarray(side.roller_load)[0]))
        label = "shared equally by all threads"
        axes.axhline(sign * mean, color=MUTED, lw=1.0, ls=(0, (4, 2)), label=label)


def _ticks(count: int) -> np.ndarray:
    step = next(s for s in (1, 2, 5, 10, 20, 50, 100, 1000) if count / s <= 25)
    ticks = np.arange(0, count + 1, step)
    return np.unique(np.where(ticks == 0, 1, ticks))


def _maps(found: LoadDistribution) -> Figure:
    from matplotlib.colors import LinearSegmentedColormap

    numbers, _ = found.by_roller(found.screw.forward)
    # Net loads: a roller that is pressed on its opposite flanks is below zero.
    loads = {}
    for name, _ in _SIDES:
        side: SideLoads = getattr(found, name)
        net = side.forward if side.reverse is None else side.forward - side.reverse
        loads[name] = np.asarray(found.by_roller(net)[1])
    largest = max(np.abs(values).max() for values in loads.values()) or 1.0
    signed = min(values.min() for values in loads.values()) < -1e-9 * largest
    colours = ["#ffffff", "#cfe3f1", _FORWARD, "#00263d"]
    if signed:
        colours = ["#5c2500", "#d55e00", "#ffffff", _FORWARD, "#00263d"]
    scale = LinearSegmentedColormap.from_list("load", colours)
    figure = page_figure(2 * (4.5 * len(numbers) + 20) + 12)
    grid = figure.subplots(2, 2, width_ratios=(5, 1), sharey="row", sharex="col")
    image = None
    for (axes, beside), (name, words) in zip(grid, _SIDES, strict=True):
        values = loads[name]
        image = axes.imshow(
            values,
            aspect="auto",
            cmap=scale,
            vmin=-largest if signed else 0.0,
            vmax=largest,
            extent=(0.5, values.shape[1] + 0.5, len(numbers) - 0.5, -0.5),
            interpolation="nearest",
        )
        factor = number(float(getattr(found, name).thread_sharing_factor), 3)
        axes.set_title(f"{_title(found)}: {words}, largest over mean {factor}")
        axes.set_yticks(range(len(numbers)), [str(n) for n in numbers])
        axes.set_ylabel("roller")
        axes.set_xticks(_ticks(values.shape[1]))
        axes.tick_params(length=0)
        sums = values.sum(axis=1)
        beside.barh(range(len(numbers)), sums, height=0.7, color=_FORWARD)
        beside.axvline(sums.mean(), color=MUTED, lw=1.0, ls=(0, (4, 2)))
        beside.grid(axis="x", color=FAINT)
        beside.tick_params(axis="y", length=0)
        beside.set_title("sum")
    grid[1, 0].set_xlabel("thread, from the end where the screw's force enters")
    grid[1, 1].set_xlabel("load of a roller in N")
    assert image is not None
    bar = figure.colorbar(image, ax=grid[:, 1].tolist(), aspect=40, pad=0.08)
    bar.set_label("axial load of a thread in N")
    bar.outline.set_linewidth(0.4)
    bar.ax.tick_params(labelsize=SMALL)
    return figure
