"""A quantity with each number at the ends of its tolerance zone, the widest bar first."""

from typing import Any

import numpy as np

from ...mechanism import Tolerance
from ...text import DisplayUnit, digits_for, display_unit, in_unit, number
from ...uncertainty import ToleranceAnalysis, ZoneEnds
from .._parts import WHITE, aside, in_words, legend_below, legend_line, page_title, room_for_ticks
from .._style import INK, SERIES, SMALL, Axes, Figure, drawn, page_figure, readable

_COLOURS = {"lower": SERIES[5], "upper": SERIES[1]}
_HEIGHT = 0.7
#: Digits of a value at least.
_DIGITS = 5
#: Values of shorter bars, over the range of all, have the digits of bars of this length.
_SHORTEST = 1e-3
#: Behind values that stand on the line of a limit.
_BEHIND = WHITE | {"pad": 0.5}
_FROM = {
    "monte_carlo": "every end analysed",
    "second_order": "from first and second derivatives at the middle of the zones",
    "first_order": "from first derivatives at the middle of the zones",
}


@drawn
def tornado_chart(analysis: ToleranceAnalysis, quantity: str) -> Figure:
    """Draw a quantity with each number at the ends of its tolerance zone, the widest bar first.

    All other numbers are nominal, and the bars begin at the nominal value. If the analysis has a
    Monte Carlo part, every end is analysed; else the expansion of first or second order about the
    middle of the zones gives the values. The picture says which. Where both ends change the
    quantity in the same direction, the bars have half the height. Dotted lines are limits; a limit
    is left out if its distance from the bars exceeds their total length.

    **Arguments:**

    - `analysis`: result of `tolerance`.
    - `quantity`: one of its quantities.

    **Returns:** a matplotlib figure.

    **Raises:** `KeyError` for a quantity that is not in the analysis; `ValueError` for an analysis
    that is not valid, or whose nominal design fails; `MissingExtraError` without matplotlib.
    """
    if not analysis.valid:
        raise ValueError("the analysis is not valid, so there is nothing to draw: see its text")
    mean = analysis[quantity].mean
    ends = analysis.best.ends.get(quantity)
    if ends is None or not np.isfinite(ends.nominal):
        raise ValueError(f"{quantity} has no nominal value, so there is nothing to draw")
    index = analysis.quantities.index(quantity)
    shown = display_unit(analysis.units[index], abs(mean), quantity)
    order = _ranked(ends)
    figure = page_figure(8.5 * len(order) + 38, 150)
    axes = figure.add_subplot()
    for place, which in enumerate(order):
        _bars(axes, place, ends, which, shown)
    axes.set_yticks(
        range(len(order)),
        [_zone(analysis.tolerances[i], analysis.tolerance_units[i]) for i in order],
    )
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(len(order) - 0.4, -0.6)
    axes.margins(x=0.16)
    axes.grid(axis="x")
    entries = _entries(shown, ends)
    axes.axvline(shown(ends.nominal), color=INK, linestyle="--", linewidth=1.0)
    room_for_ticks(axes)
    limit = _near_limits(ends, analysis.limits[index])
    for side in limit:
        axes.axvline(shown(side), color=INK, linestyle=":", linewidth=1.2)
    if limit:
        span = _span(ends)
        words = " and ".join(in_unit(side, shown, digits_for(side, span)) for side in limit)
        entries.append(legend_line(f"limit: {words}", color=INK, linestyle=":"))
    axes.set_xlabel(in_words(readable(quantity), shown))
    axes.set_title(
        f"One number at an end of its zone, others nominal\n({_FROM[analysis.method]})",
        fontsize=SMALL,
        fontweight="normal",
    )
    words = readable(quantity)
    page_title(figure, f"{words[:1].upper()}{words[1:]} at the ends of the tolerances")
    legend_below(figure, entries, most=2)
    return figure


def _ranked(ends: ZoneEnds) -> list[int]:
    """Tolerances by the range between both ends and the nominal value, the widest first."""
    values = np.stack([ends.lower, ends.upper, np.full_like(ends.lower, ends.nominal)])
    spans = np.nanmax(values, axis=0) - np.nanmin(values, axis=0)
    return [int(i) for i in np.argsort(-spans, kind="stable")]


def _bars(axes: Axes, place: int, ends: ZoneEnds, which: int, shown: DisplayUnit) -> None:
    """Bars from the nominal value to both ends, and the values beside them."""
    values = {"lower": ends.lower[which], "upper": ends.upper[which]}
    changes = {side: value - ends.nominal for side, value in values.items()}
    together = changes["lower"] * changes["upper"] > 0
    height = _HEIGHT / 2 if together else _HEIGHT
    start = shown(ends.nominal)
    for side, value in values.items():
        middle = float(place)
        if together:
            middle += (-0.25 if side == "lower" else 0.25) * _HEIGHT
        if not np.isfinite(value):
            away = -3 if side == "lower" else 3
            aside(axes, f"fails at its {side} end", (start, middle), (away, 0), va="center")
            continue
        style: dict[str, Any] = {"height": height, "color": _COLOURS[side]}
        axes.barh(middle, shown(value) - start, left=start, **style)
        # If both ends change nothing, one number is sufficient.
        if changes[side] == 0 and (side == "upper" or changes["upper"] != 0):
            continue
        away = -3 if changes[side] < 0 else 3
        span = _span(ends)
        width = max(abs(changes[side]), _SHORTEST * span) if changes[side] else span
        words = number(shown(value), digits_for(value, width, _DIGITS))
        aside(axes, words, (shown(value), middle), (away, 0), va="center", bbox=_BEHIND)


def _zone(tolerance: Tolerance, unit: str) -> str:
    """The name of a tolerance, and its zone below: "lead", "±20.00 µm"."""
    lower, upper = tolerance.lower, tolerance.upper
    shown = display_unit(unit, [lower, upper], tolerance.name)
    if lower == -upper:
        zone = f"±{in_unit(upper, shown)}"
    else:
        zone = f"{number(shown(lower))} to {in_unit(upper, shown)}"
    return f"{readable(tolerance.name)}\n{zone}"


def _range(ends: ZoneEnds) -> tuple[float, float]:
    """The lowest and the highest value."""
    every = np.array([ends.nominal, *ends.lower, *ends.upper])
    return float(np.nanmin(every)), float(np.nanmax(every))


def _span(ends: ZoneEnds) -> float:
    low, high = _range(ends)
    return high - low


def _near_limits(ends: ZoneEnds, limit: tuple[float, float] | None) -> list[float]:
    low, high = _range(ends)
    span = high - low
    return [side for side in limit or () if low - span <= side <= high + span]


def _entries(shown: DisplayUnit, ends: ZoneEnds) -> list[Any]:
    from matplotlib.patches import Patch

    digits = digits_for(ends.nominal, _span(ends), _DIGITS)
    return [
        *(Patch(facecolor=c, label=f"{side} end of the zone") for side, c in _COLOURS.items()),
        legend_line(f"nominal: {in_unit(ends.nominal, shown, digits)}", color=INK, linestyle="--"),
    ]
