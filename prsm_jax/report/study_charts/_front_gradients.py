"""The front of a study with the gradient at each point."""

import itertools

import numpy as np

from ...studies import DriverStudy
from ...text import display_unit
from .._parts import aside, in_words, legend_below
from .._style import INK, MUTED, SERIES, Figure, drawn, page_figure, readable

#: Length of the longest arrow, in widths of a panel.
_LONGEST = 0.16
#: Steps of the drivers that arrows may stand for [%].
_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)


@drawn
def front_gradient_chart(study: DriverStudy) -> Figure:
    """Draw the front of a study, with an arrow for each driver at each point.

    An arrow is the change of both objectives that the gradient predicts if this driver alone
    increases by a small percentage. The percentage is the same for all arrows; the legend names it.

    **Arguments:**

    - `study`: result of `prsm_jax.study`.

    **Returns:** a matplotlib figure: one panel for two objectives, three for three.

    **Raises:** `ValueError` for a front without points; `MissingExtraError` without matplotlib.
    """
    front = study.front
    if not front.points:
        raise ValueError(f"the front has no points; there is nothing to draw: {front.message}")
    pairs = list(itertools.combinations(study.problem.objectives, 2))
    figure = page_figure(105.0 if len(pairs) == 1 else 80.0)
    panels = np.ravel(figure.subplots(1, len(pairs)))
    step = _step(study)
    for axes, (x, y) in zip(panels, pairs, strict=True):
        shown = {
            name: display_unit(
                study.problem.units[name], map(float, study.designs.values[name]), name
            )
            for name in (x, y)
        }
        values = {name: shown[name](study.designs.values[name]) for name in (x, y)}
        if len(pairs) == 1:
            axes.plot(values[x][1:], values[y][1:], color=MUTED, lw=0.8)
        for place, driver in enumerate(study.problem.drivers):
            moves = [
                values[name][1:] * study.designs.elasticities[name][1:, place] * step / 100
                for name in (x, y)
            ]
            axes.quiver(
                values[x][1:], values[y][1:], *moves, angles="xy", scale_units="xy", scale=1,
                width=0.003, color=SERIES[place + 1],
                label=f"{step:g} % more {readable(driver.name)}",
            )  # fmt: skip
            ends = np.stack([values[x][1:] + moves[0], values[y][1:] + moves[1]], axis=1)
            axes.update_datalim(ends)
        axes.plot(
            values[x][1:], values[y][1:], ls="", marker="o", ms=4.5, color=SERIES[0], label="front"
        )
        if study.designs.usable[0]:
            axes.plot(
                [values[x][0]], [values[y][0]], ls="", marker="s", ms=5.0, mfc="white", mec=INK,
                label="present design",
            )  # fmt: skip
        _number(axes, values[x][1:], values[y][1:])
        axes.margins(0.06)
        axes.autoscale_view()
        for name, label in ((x, axes.set_xlabel), (y, axes.set_ylabel)):
            label(f"{in_words(readable(name), shown[name])} ({study.problem.senses[name]})")
        axes.grid(True)
    legend_below(figure, panels[0].get_legend_handles_labels()[0], most=5)
    return figure


def _number(axes, xs: np.ndarray, ys: np.ndarray) -> None:
    """Numbers of points that are not too near to the last one with a number."""
    spans = [float(np.ptp(one)) or 1.0 for one in (xs, ys)]
    last = None
    for index, (x, y) in enumerate(zip(xs, ys, strict=True), start=1):
        if last is None or np.hypot((x - last[0]) / spans[0], (y - last[1]) / spans[1]) > 0.06:
            aside(axes, str(index), (x, y), (-4, -8))
            last = x, y


def _step(study: DriverStudy) -> float:
    """The step for which the longest arrow has about its largest permitted length [%]."""
    longest = 0.0
    for name in study.problem.objectives:
        values = study.designs.values[name][1:]
        width = float(np.ptp(study.designs.values[name])) or float(np.abs(values).max()) or 1.0
        moves = values[:, None] * study.designs.elasticities[name][1:] / 100 / width
        longest = max(longest, float(np.nanmax(np.abs(moves), initial=0.0)))
    fitting = [step for step in _STEPS if step * longest <= _LONGEST]
    return fitting[-1] if fitting else _STEPS[0]
