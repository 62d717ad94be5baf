"""Quantities of a study over every two drivers."""

from typing import Any

import numpy as np

from ...studies import DriverStudy
from ...text import display_unit
from .._parts import colour_bar, in_words, legend_below, map_of_one_value
from .._style import SMALL, Figure, drawn, page_figure, readable
from ._planes import handles_of, planes_of

_LEVELS = 10
#: Colours cover only the range of nine tenths of the designs if the whole range exceeds it by more
#: than this factor.
_FAR = 2.0


@drawn
def study_maps(study: DriverStudy) -> Figure:
    """Draw every quantity of a study over every two of its first three drivers.

    The other drivers have the value of the map nearest to the present one. Dots mark designs that
    break a limit or have an error; crosses mark those that fail, whose surroundings are white. The
    entry of the crosses says how many designs of the map fail. A colour scale with pointed ends
    leaves out the values of a few designs beyond them.

    **Arguments:**

    - `study`: result of `prsm_jax.study`.

    **Returns:** a matplotlib figure: a row for each quantity, a column for each pair of drivers.

    **Raises:** `ValueError` for a study of one driver, or if no design succeeded;
    `MissingExtraError` without matplotlib.
    """
    planes, names = planes_of(study), list(study.problem.senses)
    figure = page_figure(12 + 52.0 * len(names))
    panels = figure.subplots(len(names), len(planes), squeeze=False)
    for row, name in zip(panels, names, strict=True):
        values = study.map.values[name]
        known = values[np.isfinite(values)]
        if not known.size:
            raise ValueError(f"no design of the study has a {name!r}; every one failed")
        unit = display_unit(study.problem.units[name], map(float, known), name)
        cuts = [unit(plane.cut(values)) for plane in planes]
        shown = np.concatenate([cut[np.isfinite(cut)] for cut in cuts])
        filled: Any = None
        for axes, plane, cut in zip(row, planes, cuts, strict=True):
            xs, ys = plane.coordinates(plane.x)[0], plane.coordinates(plane.y)[0]
            filled = _fill(axes, xs, ys, np.ma.masked_invalid(cut), shown)
            plane.dress(axes)
            if name == names[0] and plane.others:
                axes.set_title(f"at {plane.others}", fontsize=SMALL, fontweight="normal")
        bar = colour_bar(figure, filled, list(row), "", shrink=1.0)
        bar.set_label(f"{in_words(readable(name), unit)}\n({study.problem.senses[name]})")
    legend_below(figure, handles_of(np.ravel(panels)))
    return figure


def _fill(axes: Any, xs: np.ndarray, ys: np.ndarray, cut: Any, shown: np.ndarray) -> Any:
    """Contours on one scale for all panels of a row."""
    if shown.size and shown.min() < shown.max():
        from matplotlib.ticker import MaxNLocator

        low, high = (float(v) for v in np.percentile(shown, (5, 95)))
        # A few extreme values would give all other designs nearly the same colour.
        extend = "both" if np.ptp(shown) > _FAR * (high - low) > 0 else "neither"
        ends = (low, high) if extend == "both" else (float(shown.min()), float(shown.max()))
        levels = MaxNLocator(_LEVELS).tick_values(*ends)
        filled = axes.contourf(xs, ys, cut, levels=levels, cmap="cividis", extend=extend)
        axes.contour(xs, ys, cut, levels=levels, colors="white", linewidths=0.4)
        return filled
    return map_of_one_value(axes, xs, ys, cut)
