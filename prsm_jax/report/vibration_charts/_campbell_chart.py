"""Campbell diagram: natural frequencies and excitation orders against the screw speed."""

import textwrap
from typing import Any

import numpy as np

from ...response import Campbell, Crossing
from .._parts import WHITE, plain_ticks
from .._style import FAMILY_COLOURS, MUTED, SMALL, Figure, drawn, page_figure, place_axes, readable

_WIDTH, _HEIGHT = 180.0, 150.0
# Axes, and the room on the right for the names of the orders [mm].
_LEFT, _BOTTOM, _RIGHT, _TOP = 17.0, 11.0, 42.0, 9.0
#: Height of a line of small text [mm].
_LINE = 3.2
#: Largest number of crossings that are numbered and listed.
_LISTED = 24
_COLUMNS = 2
#: Possible positions of the number of a crossing: distance from the dot [points], direction.
_REACHES = (4.0, 9.0, 14.0, 20.0, 27.0)
_TURNS = tuple(np.radians([90, 270, 135, 45, 225, 315, 180, 0, 110, 70, 250, 290]))
#: Number of lines whose names fit beside the chart.
_NAMED = 36
_OPERATING = "#e6edf4"
#: Line styles of the harmonics, in turn.
_DASHES = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 2, 1, 2)))


def _spread(desired: list[float], step: float, lowest: float, highest: float) -> list[float]:
    """Positions close to the desired ones, ascending, at least a step apart and in the range."""
    positions: list[float] = []
    for value in desired:
        positions.append(max(value, positions[-1] + step if positions else lowest))
    limit = highest
    for index in range(len(positions) - 1, -1, -1):
        positions[index] = min(positions[index], limit)
        limit = positions[index] - step
    return positions


def _in_words(crossing: Crossing) -> str:
    times = f"{crossing.harmonic}× " if crossing.harmonic > 1 else ""
    speed, hertz = (
        f"{v:,.0f}".replace(",", "\u202f") for v in (crossing.speed_rpm, crossing.frequency)
    )
    return f"{speed} rpm: {times}{readable(crossing.order)}, {crossing.family} {hertz} Hz"


@drawn
def campbell_chart(
    campbell: Campbell, max_speed: float, operating: tuple[float, float] | None = None
) -> Figure:
    """Draw natural frequencies and excitation orders against the screw speed, crossings marked.

    Both axes are logarithmic, because orders differ by a factor of a hundred: order lines are then
    parallel. Natural frequencies are horizontal lines in the colour of their family; fundamentals
    are solid, harmonics dashed; orders without a crossing are left out. A full dot is a crossing
    that the order excites with the phases of the rollers, a ring one that these phases cancel. The
    first full dots by speed are numbered and listed under the chart.

    **Arguments:**

    - `campbell`: from `prsm_jax.campbell`.
    - `max_speed`: the end of the speed axis [rad/s].
    - `operating`: lowest and highest speed of operation, which are shaded [rad/s]; two equal
      numbers are a line.

    **Returns:** a matplotlib figure; speed in rpm, frequency in Hz.

    **Raises:** `ValueError` for a speed that is not positive, or too low for any crossing;
    `MissingExtraError` without matplotlib.
    """
    if not max_speed > 0:
        raise ValueError(f"max_speed is {max_speed}; the speed axis needs a positive end")
    crossings = campbell.crossings(max_speed)
    if not crossings:
        raise ValueError(
            f"no order meets a natural frequency up to {max_speed * 30 / np.pi:.6g} rpm; give a "
            "higher max_speed or more harmonics"
        )
    excited = [one for one in crossings if one.excited]
    listed = excited[:_LISTED]
    rows = -(-len(listed) // _COLUMNS) + (1 if len(excited) > len(listed) else 0)
    below = (rows + 1.5) * _LINE if listed else 0.0
    figure = page_figure(_HEIGHT + below, _WIDTH, layout=None)
    axes = place_axes(
        figure,
        _LEFT,
        _BOTTOM + below,
        _WIDTH - _LEFT - _RIGHT,
        _HEIGHT - _BOTTOM - _TOP,
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    rpm = max_speed * 30 / np.pi
    axes.set_xlim(crossings[0].speed_rpm / 1.5, rpm)
    rates = {order.name: float(order.order) / 60 for order in campbell.orders}
    met = {(one.order, one.harmonic) for one in crossings}
    lines = sorted((harmonic * rates[name] * rpm, name, harmonic) for name, harmonic in met)
    lowest = min(one.frequency for one in crossings)
    axes.set_ylim(lowest / 1.6, 1.15 * max(lines[-1][0], max(c.frequency for c in crossings)))
    if operating is not None:
        _shade(axes, operating)
    _draw_orders(axes, lines, {(one.order, one.harmonic) for one in excited}, rpm)
    labels = _draw_frequencies(axes, campbell)
    for one in crossings:
        colour = FAMILY_COLOURS[one.family]
        axes.plot(
            one.speed_rpm,
            one.frequency,
            "o",
            ms=4.4 if one.excited else 2.6,
            mec=colour,
            mfc=colour if one.excited else "white",
            mew=0.8,
            zorder=4 if one.excited else 3,
        )
    _place_numbers(axes, [(one.speed_rpm, one.frequency) for one in listed], labels)
    axes.set_xlabel("screw speed in rpm")
    axes.set_ylabel("frequency in Hz")
    for axis in (axes.xaxis, axes.yaxis):
        plain_ticks(axis, "{:,.0f}")
    axes.set_title("Campbell diagram")
    _legend(axes, campbell, operating is not None)
    if listed:
        _list(figure, listed, len(excited) - len(listed), below)
    return figure


def _shade(axes, operating: tuple[float, float]) -> None:
    """Shade the speeds of operation, as far as they lie on the axis."""
    low, high = (speed * 30 / np.pi for speed in operating)
    left, right = axes.get_xlim()
    low, high = max(low, left), min(high, right)
    if low > high:
        return
    # The edge shows a range that is narrower than a line.
    axes.axvspan(low, high, facecolor=_OPERATING, edgecolor=_OPERATING, lw=1.5, zorder=0)


def _draw_orders(axes, lines, excited: set[Any], rpm: float) -> None:
    """Order lines, with their names where they leave the axes on the right."""
    low, high = np.log(axes.get_ylim())
    first = axes.get_xlim()[0]
    for end, _, harmonic in lines:
        dashes = _DASHES[(harmonic - 1) % len(_DASHES)]
        reach = (first, rpm)
        axes.plot(reach, (end * first / rpm, end), color=MUTED, lw=0.6, ls=dashes, zorder=1)
    if len(lines) > _NAMED:
        lines = [line for line in lines if (line[1], line[2]) in excited][:_NAMED]
    ends = [(np.log(end) - low) / (high - low) for end, _, _ in lines]
    step = _LINE / (_HEIGHT - _BOTTOM - _TOP)
    for (_, name, harmonic), at, place in zip(
        lines, ends, _spread(ends, step, 0.0, 1.0), strict=True
    ):
        axes.plot(
            (1.0, 1.03),
            (at, place),
            color=MUTED,
            lw=0.4,
            transform=axes.transAxes,
            clip_on=False,
        )
        words = readable(name) if harmonic == 1 else f"{harmonic}× {readable(name)}"
        axes.text(1.035, place, words, transform=axes.transAxes, va="center", fontsize=SMALL)


def _draw_frequencies(axes, campbell: Campbell) -> list[Any]:
    """Horizontal lines with their frequencies at the left; returns the boxes of these [pixels]."""
    from matplotlib.transforms import Bbox

    modes = campbell.modes
    bottom, top = axes.get_ylim()
    low, high = np.log((bottom, top))
    shown = {
        float(value): (family, times)
        for value, family, times in zip(
            np.asarray(modes.frequencies), modes.families, modes.multiplicities, strict=True
        )
        if bottom < value < top
    }
    values = sorted(shown)
    scale = axes.figure.dpi / 72
    step = 8.2 * scale / axes.bbox.height
    desired = [(np.log(value) - low) / (high - low) + 0.55 * step for value in values]
    boxes = []
    for value, place in zip(values, _spread(desired, step, 0.0, 1.0), strict=True):
        family, times = shown[value]
        axes.axhline(value, color=FAMILY_COLOURS[family], lw=1.2, zorder=2)
        words = f"{value:,.0f} Hz".replace(",", "\u202f") + (f" ×{times}" if times > 1 else "")
        axes.text(
            0.008,
            place,
            words,
            transform=axes.transAxes,
            va="center",
            fontsize=SMALL,
            zorder=2.5,
            bbox={**WHITE, "pad": 0.6, "alpha": 0.85},
        )
        width = (4.7 * len(words) + 3) * scale
        x, y = axes.transAxes.transform((0.008, place))
        boxes.append(Bbox.from_extents(x, y - 4.2 * scale, x + width, y + 4.2 * scale))
    return boxes


def _place_numbers(axes, points: list[tuple[float, float]], words: list[Any]) -> None:
    """Numbers beside their dots, where they cover as few words, numbers and dots as possible."""
    from matplotlib.transforms import Bbox

    figure = axes.figure
    scale = figure.dpi / 72
    dots = [axes.transData.transform(point) for point in points]
    half = 2.6 * scale
    taken = words + [Bbox.from_extents(x - half, y - half, x + half, y + half) for x, y in dots]
    for number, (x, y) in enumerate(dots, start=1):
        width, height = (4.7 * len(str(number)) + 1) * scale, 8.0 * scale
        best = None
        for reach in _REACHES:
            for turn in _TURNS:
                aside = (reach * scale + width / 2) * np.cos(turn)
                up = (reach * scale + height / 2) * np.sin(turn)
                box = Bbox.from_bounds(x + aside - width / 2, y + up - height / 2, width, height)
                covered = sum(_common(box, other) for other in [*taken, *_outside(axes, box)])
                if best is None or covered < best[0]:
                    best = (covered, box, aside / scale, up / scale, reach)
            if best is not None and best[0] == 0:
                break
        assert best is not None
        _, box, aside, up, reach = best
        taken.append(box)
        far = reach > _REACHES[0]
        pointer = {"arrowstyle": "-", "color": MUTED, "lw": 0.4, "shrinkA": 0, "shrinkB": 2}
        axes.annotate(
            str(number),
            points[number - 1],
            (aside, up),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=SMALL,
            arrowprops=pointer if far else None,
            zorder=5,
        )


def _common(first, second) -> float:
    """Area that two boxes share."""
    wide = min(first.x1, second.x1) - max(first.x0, second.x0)
    high = min(first.y1, second.y1) - max(first.y0, second.y0)
    return max(wide, 0.0) * max(high, 0.0)


def _outside(axes, box) -> list[Any]:
    """The box itself if it leaves the axes, which counts as covering something."""
    frame = axes.bbox
    inside = frame.x0 < box.x0 and box.x1 < frame.x1 and frame.y0 < box.y0 and box.y1 < frame.y1
    return [] if inside else [box]


def _legend(axes, campbell: Campbell, shaded: bool) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    bottom, top = axes.get_ylim()
    values = np.asarray(campbell.modes.frequencies)
    shown = {f for f, v in zip(campbell.modes.families, values, strict=True) if bottom < v < top}
    handles: list[Any] = [
        Line2D([], [], color=colour, lw=1.4, label=family)
        for family, colour in FAMILY_COLOURS.items()
        if family in shown and family != "rigid"
    ]
    handles += [
        Line2D([], [], ls="", marker="o", ms=4.2, mec=MUTED, mfc=MUTED, label="excited"),
        Line2D([], [], ls="", marker="o", ms=2.8, mec=MUTED, mfc="white", label="cancelled"),
    ]
    if shaded:
        handles.append(Patch(facecolor=_OPERATING, label="in operation"))
    axes.legend(
        handles=handles,
        loc="lower right",
        bbox_to_anchor=(1.33, 1.0),
        ncols=len(handles),
        handlelength=1.4,
        columnspacing=1.0,
    )


def _list(figure, listed, more: int, below: float) -> None:
    """The numbered crossings in columns under the chart."""
    height = figure.get_size_inches()[1] * 25.4
    rows = -(-len(listed) // _COLUMNS)
    for index, one in enumerate(listed):
        column, row = divmod(index, rows)
        figure.text(
            (_LEFT + column * (_WIDTH - _LEFT) / _COLUMNS) / _WIDTH,
            (below - (row + 1) * _LINE) / height,
            f"{index + 1}  {_in_words(one)}",
            fontsize=SMALL,
            va="center",
        )
    if more:
        figure.text(
            _LEFT / _WIDTH,
            (below - (rows + 1) * _LINE) / height,
            textwrap.shorten(f"and {more} more at higher speeds", 60),
            fontsize=SMALL,
            va="center",
            color=MUTED,
        )
