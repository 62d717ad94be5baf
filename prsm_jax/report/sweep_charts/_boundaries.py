"""Limits in pictures: lines where a quantity is at its limit, with ticks on the side outside."""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from .._parts import legend_line
from .._style import SERIES, Axes
from ._limits import QuantityLimit

#: Colours, distinct from those of a map, and dashes of the first, second, … limit.
_COLOURS = (SERIES[3], SERIES[4], SERIES[5], SERIES[2], SERIES[1])
_DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)))
#: Ticks on the left of a line, where matplotlib has the larger values of a contour.
_LEFT, _RIGHT = 60, -60
#: Smallest number of values along each axis of a map. Lines of limits are straight between them.
_FINE = 200
_HATCH = "////"
#: A range that is outside of a limit, and its entry in the legend.
_HATCHED: dict[str, Any] = {
    "facecolor": "#b8bfc6",
    "edgecolor": "white",
    "hatch": _HATCH,
    "linewidth": 0.0,
}
OUTSIDE = "outside of a limit"
#: Points of a picture in which others are outside.
WITHIN = "within all limits"


def style_of(index: int) -> dict[str, Any]:
    """Colour and dashes of the n-th limit."""
    turn = index // len(_COLOURS)
    return {
        "color": _COLOURS[index % len(_COLOURS)],
        "linestyle": _DASHES[turn % len(_DASHES)],
        "linewidth": 1.4,
    }


def _edges(limit: QuantityLimit, angle: int) -> list[Any]:
    """A white edge, so that a line is visible on every colour, and ticks if one side is outside."""
    from matplotlib.patheffects import Normal, TickedStroke, withStroke

    edge = [withStroke(linewidth=2.6, foreground="white"), Normal()]
    return [*edge, TickedStroke(spacing=6, angle=angle, length=1.0)] if limit.excludes else edge


def _two_sides(excess: np.ndarray) -> bool:
    """Whether designs lie on both sides of a limit."""
    known = excess[np.isfinite(excess)]
    return bool((known > 0).any() and (known <= 0).any())


def draw_on_map(
    axes: Axes,
    x: np.ndarray,
    y: np.ndarray,
    limits: Sequence[QuantityLimit],
) -> None:
    """Lines of all limits on a map, and hatching where a design is outside of one or more.

    Between the designs the quantities are interpolated linearly along each axis.

    **Arguments:**

    - `axes`: the map.
    - `x`, `y`: values along its axes, ascending.
    - `limits`: the limits over the map, y × x.
    """
    import matplotlib

    fine_x, fine_y = _finer(x), _finer(y)
    worst = np.full((len(fine_y), len(fine_x)), -np.inf)
    for index, limit in enumerate(limits):
        fine = _between(x, y, np.asarray(limit.excess.values, float), fine_x, fine_y)
        if limit.excludes:
            # Scaled, so that quantities of any units can be compared with 0 together.
            worst = np.maximum(worst, fine / max(np.nanmax(np.abs(fine), initial=0.0), 1e-300))
        if _two_sides(fine):
            style: Any = {f"{key}s": [value] for key, value in style_of(index).items()}
            masked = np.ma.masked_invalid(fine)
            lines = axes.contour(fine_x, fine_y, masked, levels=[0.0], zorder=3, **style)
            lines.set_path_effects(_edges(limit, _LEFT))
    if (worst > 0).any():
        area = np.ma.masked_where(~np.isfinite(worst), worst)
        with matplotlib.rc_context({"hatch.color": "white"}):
            axes.contourf(
                *(fine_x, fine_y, area),
                levels=[0.0, np.inf],
                colors="none",
                hatches=[_HATCH],
                zorder=2,
            )


def _finer(values: np.ndarray) -> np.ndarray:
    """The values and others between them."""
    parts = -(-_FINE // len(values))
    steps = np.arange((len(values) - 1) * parts + 1) / parts
    return np.interp(steps, np.arange(len(values)), values)


def _between(
    x: np.ndarray, y: np.ndarray, plane: np.ndarray, fine_x: np.ndarray, fine_y: np.ndarray
) -> np.ndarray:
    rows = np.stack([np.interp(fine_x, x, row) for row in plane])
    return np.stack([np.interp(fine_y, y, column) for column in rows.T], axis=1)


def crossings(x: np.ndarray, excess: np.ndarray) -> list[tuple[float, bool]]:
    """Where a quantity is at its limit along an axis, and whether designs above it are outside."""
    places: list[tuple[float, bool]] = []
    for left, right in itertools.pairwise(range(len(x))):
        first, second = excess[left], excess[right]
        if np.isfinite(first) and np.isfinite(second) and (first > 0) != (second > 0):
            share = first / (first - second)
            places.append((float(x[left] + share * (x[right] - x[left])), bool(second > 0)))
    return places


def outside_ranges(x: np.ndarray, excesses: Sequence[np.ndarray]) -> list[tuple[float, float]]:
    """Ranges of an axis whose designs are outside of one limit or more."""
    at = {float(value) for value in x}
    at |= {place for excess in excesses for place, _ in crossings(x, excess)}
    ranges: list[tuple[float, float]] = []
    for low, high in itertools.pairwise(sorted(at)):
        # NaN, next to a design that failed, is not outside.
        if not any(np.interp(0.5 * (low + high), x, excess) > 0 for excess in excesses):
            continue
        if ranges and ranges[-1][1] == low:
            ranges[-1] = (ranges[-1][0], high)
        else:
            ranges.append((low, high))
    return ranges


def draw_on_axis(axes: Axes, x: np.ndarray, limits: Sequence[QuantityLimit], quantity: str) -> None:
    """Lines where other quantities are at their limits along an axis; ranges outside hatched.

    **Arguments:**

    - `axes`: the picture.
    - `x`: values along its axis, ascending.
    - `limits`: the limits.
    - `quantity`: the quantity over the axis; its own limits are levels.
    """
    excesses = [np.asarray(one.excess.values, float) for one in limits]
    for index, (limit, excess) in enumerate(zip(limits, excesses, strict=True)):
        if limit.quantity == quantity:
            continue
        for place, above in crossings(x, excess):
            line = axes.axvline(place, zorder=1.5, **style_of(index))
            line.set_path_effects(_edges(limit, _RIGHT if above else _LEFT))
    excluding = [e for one, e in zip(limits, excesses, strict=True) if one.excludes]
    for low, high in outside_ranges(x, excluding):
        axes.axvspan(low, high, zorder=0.5, **_HATCHED)


def draw_levels(
    axes: Axes, limits: Sequence[QuantityLimit], quantity: str, unit: Any, values: np.ndarray
) -> list[bool]:
    """Levels at the limits of the drawn quantity, except for limits that are too far away.

    **Arguments:**

    - `axes`: the picture.
    - `limits`: the limits.
    - `quantity`: what is drawn.
    - `unit`: the display unit of its axis.
    - `values`: its values [SI].

    **Returns:** of each limit, whether it has a level.
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    span = high - low or abs(high)
    shown_of_each: list[bool] = []
    for index, limit in enumerate(limits):
        shown = limit.quantity == quantity and low - span <= limit.limit <= high + span
        shown_of_each.append(shown)
        if shown:
            line = axes.axhline(unit(limit.limit), zorder=1.5, **style_of(index))
            line.set_path_effects(_edges(limit, _LEFT if limit.sign == "≤" else _RIGHT))
    return shown_of_each


def limit_entries(
    limits: Sequence[QuantityLimit], lines: Sequence[bool] | None = None, hatched: bool = True
) -> list[Any]:
    """Entries of a legend: each limit with its line, and what the hatching means.

    **Arguments:**

    - `limits`: the limits, over the designs that are drawn.
    - `lines`: whether each has a line; default where designs lie on both sides.
    - `hatched`: whether the range outside is hatched.
    """
    from matplotlib.patches import Patch

    entries: list[Any] = []
    outside = False
    for index, limit in enumerate(limits):
        excess = np.asarray(limit.excess.values, float)
        known = excess[np.isfinite(excess)]
        outside |= limit.excludes and bool((known > 0).any())
        has_line = _two_sides(excess) if lines is None else lines[index]
        words = limit.words
        if not known.size:
            words += " (no design has a value)"
        elif not limit.excludes and not _two_sides(excess):
            words += " (not in the picture)"
        elif not _two_sides(excess):
            words += " (all outside)" if (known > 0).all() else " (all within)"
        style = style_of(index) if has_line else {"linestyle": ""}
        entries.append(legend_line(words, **style))
    if outside and hatched:
        entries.append(Patch(label=OUTSIDE, **_HATCHED))
    return entries
