"""Where the quantities of a study conflict."""

import itertools
import textwrap
from typing import Any

import numpy as np

from ...studies import Conflict, DriverStudy
from .._parts import colour_bar, legend_below
from .._style import INK, SMALL, Figure, drawn, page_figure, readable
from ._planes import Plane, handles_of, planes_of

#: Number of characters of a title in a panel as wide as the page.
_CHARACTERS = 84
_LEVELS = np.linspace(-1.0, 1.0, 11)


@drawn
def conflict_maps(study: DriverStudy, limits: bool = False) -> Figure:
    """Draw the cosine of the angle between the elasticities of two quantities over the drivers.

    Below 0 (orange) the two conflict. Above 0 (violet) one change improves both. The line is at 0.

    **Arguments:**

    - `study`: result of `prsm_jax.study`.
    - `limits`: draw the objectives against the quantities of limits, over the first and the last
      of three drivers. If not: each pair of quantities over every two of the first three drivers.

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` for a study of one driver, or without a limit that could conflict;
    `MissingExtraError` without matplotlib.
    """
    planes = planes_of(study)
    if limits:
        plane = planes[len(planes) // 2]
        rows = [
            [(one, plane) for one in study.conflicts if one.limit and one.first == name]
            for name in study.problem.objectives
        ]
        if not rows[0]:
            raise ValueError("the study has no limit on a quantity that could conflict")
    else:
        rows = [[(one, plane) for plane in planes] for one in study.conflicts if not one.limit]
    figure = page_figure(16 + (58.0 if limits else 50.0) * len(rows))
    panels: Any = figure.subplots(len(rows), len(rows[0]), squeeze=False, sharey=limits)
    filled: Any = None
    for axes, (one, plane) in zip(np.ravel(panels), itertools.chain(*rows), strict=True):
        filled = _panel(axes, one, plane)
        words = f"{readable(one.first)} against {readable(one.second)}"
        title = textwrap.fill(words, _CHARACTERS // len(rows[0]))
        axes.set_title(title, fontsize=SMALL, fontweight="normal")
    colour_bar(figure, filled, list(np.ravel(panels)), "cosine: −1 conflict, +1 agreement")
    legend_below(figure, handles_of(np.ravel(panels)))
    return figure


def _panel(axes: Any, one: Conflict, plane: Plane) -> Any:
    xs, ys = plane.coordinates(plane.x)[0], plane.coordinates(plane.y)[0]
    cut = np.ma.masked_invalid(plane.cut(one.cosine))
    filled = axes.contourf(xs, ys, cut, levels=_LEVELS, cmap="PuOr")
    known = cut.compressed()
    if known.size and known.min() < 0 < known.max():
        axes.contour(xs, ys, cut, levels=[0.0], colors=INK, linewidths=0.9)
    plane.dress(axes)
    return filled
