"""A front: the objectives of its points against each other, and those of the present design."""

import itertools
import textwrap

import numpy as np

from ...optimisation import ParetoFront
from ...text import display_unit
from .._parts import in_words, legend_below
from .._style import INK, SERIES, Figure, drawn, page_figure, readable

#: Characters in a line of the legend.
_LINE = 70


def present_in_words(front: ParetoFront) -> str:
    """The present design and the limits that it breaks, for a legend."""
    breaks = front.start.breaks
    words = f"present design, {readable(breaks)}" if breaks else "present design"
    return textwrap.fill(words, _LINE)


@drawn
def front_chart(front: ParetoFront) -> Figure:
    """Draw the points of a front: one picture for two objectives, three projections for three.

    Points that did not converge are hollow. The present design is a square, where it is usable;
    the legend names the limits that it breaks.

    **Arguments:**

    - `front`: result of `pareto`.

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` for a front without points; `MissingExtraError` without matplotlib.
    """
    if not front.points:
        raise ValueError(f"the front has no points; there is nothing to draw: {front.message}")
    names = [one.quantity for one in front.objectives]
    senses = {one.quantity: one.sense for one in front.objectives}
    values = dict(zip(names, front.values.T, strict=True))
    pairs = list(itertools.combinations(names, 2))
    figure = page_figure(84.0 if len(pairs) == 1 else 72.0)
    panels = np.ravel(figure.subplots(1, len(pairs)))
    good = np.array([one.status == "optimal" for one in front.points])
    present = front.start.objectives if front.start.status != "fails" else {}
    for axes, (x, y) in zip(panels, pairs, strict=True):
        shown = {}
        for name in (x, y):
            numbers = [*map(float, values[name]), *([present[name]] if present else [])]
            shown[name] = display_unit(front.objective_units[name], numbers, name)
        along, up = shown[x](values[x]), shown[y](values[y])
        if len(names) == 2:
            axes.plot(along, up, color=SERIES[0], lw=0.8)
        dots = {"ls": "", "marker": "o", "ms": 4.0, "mec": SERIES[0], "mew": 0.9}
        axes.plot(along[good], up[good], mfc=SERIES[0], label="front", **dots)
        if not good.all():
            axes.plot(along[~good], up[~good], mfc="white", label="not converged", **dots)
        if present:
            axes.plot(
                [shown[x](present[x])],
                [shown[y](present[y])],
                ls="",
                marker="s",
                ms=5.0,
                mfc="white",
                mec=INK,
                label=present_in_words(front),
            )
        axes.set_xlabel(f"{in_words(readable(x), shown[x])} ({senses[x]})")
        axes.set_ylabel(f"{in_words(readable(y), shown[y])} ({senses[y]})")
        axes.grid(True)
        axes.margins(0.08)
    handles = panels[0].get_legend_handles_labels()[0]
    legend_below(figure, handles)
    return figure
