"""The yield: against a common factor of all tolerances, and against their cost."""

from typing import Any

import numpy as np

from ...uncertainty import METHOD_WORDS, CostCurve, YieldCurve
from .._parts import aside
from .._style import INK, SERIES, Figure, drawn, page_figure

_STYLES: dict[str, dict[str, Any]] = {
    "first_order": {"color": SERIES[0], "linestyle": (0, (5, 1.5))},
    "second_order": {"color": SERIES[3], "linestyle": "-"},
}


@drawn
def yield_chart(curve: YieldCurve) -> Figure:
    """Draw the yield against the width of all tolerances, by each method.

    Bars at the points of Monte Carlo are two standard errors long to each side.

    **Arguments:**

    - `curve`: result of `yield_curve`.

    **Returns:** a matplotlib figure.

    **Raises:** `MissingExtraError` without matplotlib.
    """
    figure = page_figure(85, 120)
    axes = figure.add_subplot()
    for method, shares in curve.yields.items():
        words = METHOD_WORDS[method]
        if method in _STYLES:
            axes.plot(curve.factors, 100 * shares, label=words, **_STYLES[method])
        else:
            axes.errorbar(
                curve.factors,
                100 * shares,
                200 * curve.errors[method],
                fmt="o",
                color=INK,
                markersize=3.5,
                linewidth=1.0,
                label=words,
            )
    axes.axvline(1.0, color=INK, linestyle=":", linewidth=0.8)
    axes.set_xlabel("width of all tolerances relative to the given ones")
    axes.set_ylabel("within all limits in %")
    axes.set_ylim(0, 104)
    axes.set_title("Yield")
    axes.grid(True)
    axes.legend(loc="best")
    return figure


@drawn
def cost_chart(curve: CostCurve) -> Figure:
    """Draw the least cost of the tolerances against the yield, and the given tolerances.

    **Arguments:**

    - `curve`: result of `cost_curve`.

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` if no yield is reached; `MissingExtraError` without matplotlib.
    """
    good = np.isfinite(curve.costs)
    if not good.any():
        raise ValueError("no tolerances reach one of the yields, so there is nothing to draw")
    figure = page_figure(85, 120)
    axes = figure.add_subplot()
    axes.plot(100 * curve.yields[good], curve.costs[good], "o-", color=SERIES[0], markersize=3)
    given = 100 * max(curve.given_yield, 0.0), curve.given_cost
    axes.plot(*given, "s", color=SERIES[3], markersize=5)
    aside(axes, "given tolerances", given, (5, 4))
    axes.set_xlabel("within all limits in % (first order)")
    axes.set_ylabel("cost of all tolerances")
    axes.set_ylim(bottom=0)
    axes.set_title("Tolerances of least cost")
    axes.grid(True)
    return figure
