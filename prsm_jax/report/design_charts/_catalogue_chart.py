"""Computed numbers of a catalogue's sizes against the printed ones."""

from typing import Any

import numpy as np
from jaxtyping import Bool

from ...text import DisplayUnit
from ...validation import PREDICTED, CatalogueComparison
from .._parts import in_words, legend_below, legend_line, page_title, plain_ticks
from .._style import FAINT, INK, MUTED, SERIES, Axes, Figure, drawn, page_figure

#: Columns in the order of the panels, and their titles.
_PANELS = {
    "static_capacity_kn": "Static capacity",
    "dynamic_capacity_kn": "Dynamic capacity",
    "nut_mass_kg": "Mass of nut and rollers",
    "nut_inertia_kg_mm2": "Inertia of the nut",
    "rollers_inertia_at_screw_kg_mm2": "Inertia of rollers at screw",
    "shaft_inertia_kg_mm2_per_m": "Inertia of the screw",
}
#: Decades of an axis from which on only powers of ten, and powers of a hundred, have numbers.
_MANY, _TOO_MANY = 2.9, 3.5
_STYLES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("diameters that the rules are fitted to", {"color": SERIES[0], "fillstyle": "none"}),
    ("diameters that are predicted", {"color": SERIES[3], "fillstyle": "full"}),
)
_MARKER: dict[str, Any] = {"marker": "o", "ls": "", "ms": 3.2, "mew": 0.7}


@drawn
def catalogue_chart(comparison: CatalogueComparison) -> Figure:
    """Draw computed against printed numbers of all sizes, on logarithmic axes.

    Grey bands are 20 % around equality for capacities and 10 % for masses and inertias. Columns
    without printed numbers are left out.

    **Arguments:**

    - `comparison`: from `prsm_jax.validation.compare_catalogue`.

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` if no column of the chart is printed; `MissingExtraError` without
    matplotlib.
    """
    columns = [name for name in _PANELS if comparison.summary(name) is not None]
    if not columns:
        raise ValueError("no capacity, mass or inertia is printed, so there is nothing to draw")
    across = min(3, len(columns))
    rows = -(-len(columns) // across)
    page = page_figure(62.0 * rows + 18.0, 60.0 * across)
    grid = page.subplots(rows, across, squeeze=False).ravel()
    for axes, name in zip(grid, columns, strict=False):
        _panel(axes, comparison, name)
    for axes in grid[len(columns) :]:
        axes.set_visible(False)
    predicted = comparison.predicted_half
    handles = [
        legend_line(words, **_MARKER, **style)
        for half, (words, style) in zip((~predicted, predicted), _STYLES, strict=True)
        if half.any()
    ]
    legend_below(page, handles, labelcolor=MUTED)
    page_title(page, "Sizes of a catalogue: computed against printed")
    return page


def _panel(axes: Axes, comparison: CatalogueComparison, name: str) -> None:
    from matplotlib.ticker import LogLocator

    column = PREDICTED[name]
    unit = DisplayUnit(column.unit, 1.0)
    axes.set_title(_PANELS[name])
    axes.set_box_aspect(1)
    axes.set_xlabel(in_words("printed", unit))
    axes.set_ylabel(in_words("computed", unit))
    axes.set_xscale("log")
    axes.set_yscale("log")
    printed, computed = comparison.printed[name], comparison.computed[name]
    there: Bool[np.ndarray, " sizes"] = np.isfinite(printed)
    both = np.concatenate([printed[there], computed[there]])
    ends = np.array([0.8 * both.min(), 1.25 * both.max()])
    axes.fill_between(ends, ends * (1 - column.goal), ends * (1 + column.goal), color=FAINT, lw=0)
    axes.plot(ends, ends, color=INK, lw=0.6)
    for half, (_, style) in zip(
        (~comparison.predicted_half, comparison.predicted_half), _STYLES, strict=True
    ):
        if (there & half).any():
            axes.plot(printed[there & half], computed[there & half], **_MARKER, **style)
    axes.set_xlim(*ends)
    axes.set_ylim(*ends)
    decades = np.log10(ends[1] / ends[0])
    for axis in (axes.xaxis, axes.yaxis):
        plain_ticks(axis, "{:,g}", (1.0, 3.0) if decades < _MANY else (1.0,))
        if decades > _TOO_MANY:
            axis.set_major_locator(LogLocator(base=100.0))
    axes.grid(True)
