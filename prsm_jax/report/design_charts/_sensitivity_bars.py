"""Elasticities as bars: per cent of each quantity for one per cent of each parameter."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...text import fixed
from .._parts import aside, component_words, legend_below, page_title
from .._style import INK, MUTED, Figure, drawn, page_figure, readable, series_style


@drawn
def sensitivity_bars(
    quantities: Sequence[str], parameters: Sequence[str], elasticity: ArrayLike
) -> Figure:
    """Draw elasticities as horizontal bars, grouped by quantity.

    **Arguments:**

    - `quantities`, `parameters`: names of the rows and columns.
    - `elasticity`: relative change of each quantity over the relative change of each parameter,
      quantity × parameter. One that is not finite is written as "not defined".

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` if the shape does not fit the names; `MissingExtraError` without
    matplotlib.
    """
    values = np.asarray(elasticity, dtype=float)
    if values.shape != (len(quantities), len(parameters)) or values.size == 0:
        raise ValueError(
            f"elasticity has the shape {values.shape}; {len(quantities)} quantities and "
            f"{len(parameters)} parameters need {(len(quantities), len(parameters))}, not empty"
        )
    # About as high as its words: a page of a report holds a dozen quantities.
    bar = 2.6
    group = bar * len(parameters) + 1.6
    rows = math.ceil(len(parameters) / 4)
    figure = page_figure(group * len(quantities) + 20 + 5 * rows)
    axes = figure.add_subplot()
    finite = values[np.isfinite(values)]
    reach = max(float(np.abs(finite).max()) if finite.size else 0.0, 1e-3)
    for row, values_of in enumerate(values):
        if row:
            axes.axhline(row - 0.5, color=MUTED, lw=0.3)
        for column, value in enumerate(values_of):
            y = row + (column - (len(parameters) - 1) / 2) * bar / group
            shown = value if math.isfinite(value) else 0.0
            axes.barh(y, shown, height=0.9 * bar / group, linewidth=0.3, **series_style(column))
            shift = -2.5 if shown < 0 else 2.5
            aside(axes, _signed(value), (shown, y), (shift, 0), va="center")
    axes.axvline(0, color=INK, lw=0.6)
    low = min(0.0, float(finite.min()) if finite.size else 0.0)
    high = max(0.0, float(finite.max()) if finite.size else 0.0)
    room = 0.12 * (max(high - low, reach))
    axes.set_xlim(low - room, high + room)
    axes.set_yticks(range(len(quantities)), [component_words(name) for name in quantities])
    axes.set_ylim(len(quantities) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="x")
    axes.set_xlabel("elasticity in % of the quantity per % of the parameter")
    page_title(figure, "Elasticities")
    _legend(figure, parameters)
    return figure


def _signed(value: float) -> str:
    if not math.isfinite(value):
        return "not defined"
    if value == 0:
        return "0"
    if abs(value) < 5e-4:
        return "≈ 0"
    return fixed(value, 3, "+")


def _legend(figure: Figure, parameters: Sequence[str]) -> None:
    from matplotlib.patches import Patch

    handles = [
        Patch(**series_style(index), label=readable(name)) for index, name in enumerate(parameters)
    ]
    legend_below(figure, handles, 4)
