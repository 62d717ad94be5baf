"""Scatter of quantities due to tolerances: histograms, contributions, and pairs of quantities."""

import math
from typing import Any

import numpy as np

from ...text import DisplayUnit, display_unit
from ...uncertainty import METHOD_WORDS, ToleranceAnalysis
from .._parts import aside, in_words, legend_below, legend_line, page_title, room_for_ticks
from .._style import INK, MUTED, SERIES, Axes, Figure, drawn, page_figure, readable

_ROW = 52.0
_BINS = 40
#: Half axes of the ellipse that holds 95 % of a normal distribution in two dimensions, over its
#: standard deviations: the root of -2 ln(0.05).
_ELLIPSE = math.sqrt(-2 * math.log(0.05))
_SAMPLES = SERIES[5]
_ORDERS: dict[str, dict[str, Any]] = {
    "first_order": {"color": SERIES[0], "linestyle": (0, (5, 1.5))},
    "second_order": {"color": SERIES[3], "linestyle": "-"},
}


def _panels(count: int, row: float) -> tuple[Figure, list[Axes]]:
    columns = min(count, 2)
    rows = math.ceil(count / columns)
    figure = page_figure(row * rows + 14)
    grid: Any = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.flat[count:]:
        axes.set_visible(False)
    return figure, list(grid.flat[:count])


def _unit(analysis: ToleranceAnalysis, name: str) -> DisplayUnit:
    unit = analysis.units[analysis.quantities.index(name)]
    return display_unit(unit, abs(analysis[name].mean), name)


def _limits(analysis: ToleranceAnalysis, name: str) -> list[float]:
    limit = analysis.limits[analysis.quantities.index(name)]
    return [] if limit is None else [side for side in limit if math.isfinite(side)]


def _heading(name: str) -> str:
    words = readable(name)
    return f"{words[:1].upper()}{words[1:]}"


@drawn
def tolerance_histograms(analysis: ToleranceAnalysis) -> Figure:
    """Draw the distribution of each quantity: Monte Carlo as bars, propagation as normal curves.

    A curve is the normal distribution with the mean and the standard deviation of its method. It
    shows the share of mechanisms in each bar. Dotted lines are limits.

    **Arguments:**

    - `analysis`: result of `tolerance` by any methods.

    **Returns:** a matplotlib figure with a panel for each quantity.

    **Raises:** `ValueError` for an analysis that is not valid; `MissingExtraError` without
    matplotlib.
    """
    _check_valid(analysis)
    figure, panels = _panels(len(analysis.quantities), _ROW)
    for axes, name in zip(panels, analysis.quantities, strict=True):
        _histogram(axes, analysis, name)
    entries = [
        legend_line(METHOD_WORDS[one], **style)
        for one, style in _ORDERS.items()
        if one in analysis.methods
    ]
    if analysis.best.values:
        from matplotlib.patches import Patch

        entries.insert(0, Patch(facecolor=_SAMPLES, label="Monte Carlo"))
    if any(_limits(analysis, name) for name in analysis.quantities):
        entries.append(legend_line("limit", color=INK, linestyle=":"))
    legend_below(figure, entries)
    page_title(figure, "Distributions due to tolerances")
    return figure


def _check_valid(analysis: ToleranceAnalysis) -> None:
    if not analysis.valid:
        raise ValueError("the analysis is not valid, so there is nothing to draw: see its text")


def _histogram(axes: Axes, analysis: ToleranceAnalysis, name: str) -> None:
    shown, best = _unit(analysis, name), analysis[name]
    samples = analysis.best.values.get(name, np.zeros(0))
    good = samples[np.isfinite(samples)]
    reach = 4 * best.standard_deviation
    low, high = best.mean - reach, best.mean + reach
    if good.size:
        low, high = float(good.min()), float(good.max())
    if not high > low:
        # A quantity that no tolerance changes.
        low, high = best.mean - abs(best.mean) * 1e-3, best.mean + abs(best.mean) * 1e-3
    edges = np.linspace(low, high, _BINS + 1)
    width = edges[1] - edges[0]
    if good.size:
        shares = np.histogram(good, edges)[0] / len(samples)
        axes.bar(shown(edges[:-1]), 100 * shares, shown(width), align="edge", color=_SAMPLES)
    at = np.linspace(low, high, 201)
    for method, style in _ORDERS.items():
        if method not in analysis.methods:
            continue
        one = analysis.methods[method].estimates[name]
        if one.standard_deviation > 0:
            z = (at - one.mean) / one.standard_deviation
            density = np.exp(-0.5 * z**2) / (math.sqrt(2 * math.pi) * one.standard_deviation)
            axes.plot(shown(at), 100 * density * width, **style)
    for side in _limits(analysis, name):
        axes.axvline(shown(side), color=INK, linestyle=":", linewidth=1.0)
    axes.set_xlabel(in_words(readable(name), shown))
    axes.set_ylabel("mechanisms in %")
    axes.set_title(_heading(name))
    axes.set_ylim(bottom=0)
    room_for_ticks(axes)
    axes.grid(axis="y")


@drawn
def contribution_bars(analysis: ToleranceAnalysis) -> Figure:
    """Draw each tolerance's share of the variance of each quantity, the largest first.

    **Arguments:**

    - `analysis`: result of `tolerance`.

    **Returns:** a matplotlib figure with a panel for each quantity.

    **Raises:** `ValueError` for an analysis that is not valid; `MissingExtraError` without
    matplotlib.
    """
    _check_valid(analysis)
    figure, panels = _panels(len(analysis.quantities), 5.0 * len(analysis.tolerances) + 20)
    for axes, name in zip(panels, analysis.quantities, strict=True):
        ranked = analysis.ranked(name)
        for place, (_, share) in enumerate(ranked):
            percent = 100 * share if math.isfinite(share) else 0.0
            axes.barh(place, percent, height=0.7, color=SERIES[0])
            words = f"{percent:.1f}" if math.isfinite(share) else "not known"
            aside(axes, words, (percent, place), (2.5, 0), va="center")
        axes.set_yticks(range(len(ranked)), [readable(one) for one, _ in ranked])
        axes.tick_params(axis="y", length=0)
        axes.set_ylim(len(ranked) - 0.4, -0.6)
        axes.set_xlim(0, 115)
        axes.set_xticks(range(0, 101, 25))
        axes.grid(axis="x")
        axes.set_xlabel("share of the variance in %")
        axes.set_title(_heading(name))
    page_title(figure, f"Contributions of the tolerances ({METHOD_WORDS[analysis.method]})")
    return figure


@drawn
def tolerance_scatter(analysis: ToleranceAnalysis, x: str, y: str) -> Figure:
    """Draw two quantities of each Monte Carlo design, with the propagated 95 % ellipse.

    The ellipse holds 95 % of the normal distribution that first derivatives give. Dotted lines are
    limits.

    **Arguments:**

    - `analysis`: result of `tolerance` with `method="all"`.
    - `x`, `y`: two of its quantities.

    **Returns:** a matplotlib figure.

    **Raises:** `KeyError` for a quantity that is not in the analysis; `ValueError` without samples
    or without first derivatives, or for an analysis that is not valid; `MissingExtraError` without
    matplotlib.
    """
    _check_valid(analysis)
    first = analysis.methods.get("first_order")
    samples = analysis.best.values
    if first is None or not samples:
        raise ValueError('the scatter needs both; compute the analysis with method="all"')
    # Names that are not there are refused.
    (across, up) = (analysis[name] and _unit(analysis, name) for name in (x, y))
    figure = page_figure(100, 120)
    axes = figure.add_subplot()
    axes.plot(across(samples[x]), up(samples[y]), ".", color=_SAMPLES, markersize=2, alpha=0.6)
    slopes = np.stack([first.slopes[x], first.slopes[y]])
    turn = np.linspace(0, 2 * np.pi, 181)
    # Half axes along the directions in which the two do not correlate.
    sizes, directions = np.linalg.eigh(slopes @ slopes.T)
    half = _ELLIPSE * np.sqrt(np.maximum(sizes, 0.0))[:, None]
    circle = directions @ (half * np.stack([np.cos(turn), np.sin(turn)]))
    middle = [first.estimates[name].mean for name in (x, y)]
    axes.plot(across(middle[0] + circle[0]), up(middle[1] + circle[1]), **_ORDERS["first_order"])
    for side in _limits(analysis, x):
        axes.axvline(across(side), color=INK, linestyle=":", linewidth=1.0)
    for side in _limits(analysis, y):
        axes.axhline(up(side), color=INK, linestyle=":", linewidth=1.0)
    axes.set_xlabel(in_words(readable(x), across))
    axes.set_ylabel(in_words(readable(y), up))
    axes.set_title(f"{_heading(x)} and {readable(y)}")
    room_for_ticks(axes)
    axes.grid(True, color=MUTED, alpha=0.2)
    entries = [
        legend_line("design (Monte Carlo)", color=_SAMPLES, marker=".", linestyle=""),
        legend_line("95 % ellipse (first order)", **_ORDERS["first_order"]),
    ]
    if _limits(analysis, x) or _limits(analysis, y):
        entries.append(legend_line("limit", color=INK, linestyle=":"))
    legend_below(figure, entries)
    return figure
