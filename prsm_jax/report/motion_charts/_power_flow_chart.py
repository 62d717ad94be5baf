"""Power from motor to load as bands with widths to scale, and powers stacked over time."""

from typing import Any

import numpy as np

from ...dynamics import Transient
from ...mechanism import Mechanism
from ...text import DisplayUnit, display_unit, in_unit, number
from .._parts import legend_below
from .._style import INK, MUTED, SMALL, Axes, Figure, drawn, page_figure, readable
from ._history_chart import shade, sticking_phases
from ._loss_chart import loss_style
from ._power_flow import BRISTLES, KINETIC, LOAD, MOTOR, PowerFlow, power_history

_COLOURS = {MOTOR: "#9bb8d3", LOAD: "#b8d8c8", KINETIC: "#e3cfa4", BRISTLES: "#d8c7e6"}
_WORDS = {
    (MOTOR, True): "motor",
    (MOTOR, False): "back to the motor",
    (LOAD, True): "load drives",
    (LOAD, False): "work on the load",
    (KINETIC, True): "from moving masses",
    (KINETIC, False): "into moving masses",
    (BRISTLES, True): "from bristles",
    (BRISTLES, False): "into bristles",
}
#: Hatch of sources in a history.
_SOURCE = "\\\\\\"
#: Height of the total flow, and least distance between two labels [mm].
_TALL, _LINE = 46.0, 8.4
#: Along the page [mm]: words, blocks and trunk from the left.
_LEFT, _BLOCK, _TRUNK, _RIGHT = 31.0, 3.0, (54.0, 106.0), 146.0


def _style(name: str, index: int) -> dict[str, Any]:
    if name in _COLOURS:
        return {"facecolor": _COLOURS[name], "hatch": "", "edgecolor": "white"}
    return loss_style(name, index)


def _label(name: str, source: bool) -> str:
    return _WORDS.get((name, source), readable(name))


def _spread(heights: list[float]) -> list[float]:
    """Tops of blocks from the upper edge down, with enough space for their labels [mm]."""
    tops, below = [], 0.0
    for height in heights:
        middle = max(below + height / 2, (tops[-1][1] + _LINE) if tops else 0.0)
        tops.append((middle - height / 2, middle))
        below = middle + height / 2 + 1.5
    return [top for top, _ in tops]


@drawn
def power_flow_chart(flow: PowerFlow, title: str = "Power flow") -> Figure:
    """Draw a flow from its sources on the left to its sinks on the right, with widths to scale.

    **Arguments:**

    - `flow`: from `steady_flow` or `energy_flow`.
    - `title`: heading.

    **Returns:** a matplotlib figure; W or kW, or J or kJ, and shares in %.

    **Raises:** `ValueError` if nothing flows; `MissingExtraError` without matplotlib.
    """
    total = flow.total
    if not total > 0:
        raise ValueError("nothing flows: the mechanism does not move, or moves without any force")
    unit = _unit(flow)
    per = _TALL / total
    left = list(flow.sources.items())
    right = sorted(flow.sinks.items(), key=lambda item: (item[0] not in (LOAD, MOTOR), -item[1]))
    tops = {side: _spread([v * per for _, v in ends]) for side, ends in (("l", left), ("r", right))}
    depth = {
        side: max(
            [top + v * per for top, (_, v) in zip(tops[side], ends, strict=True)], default=_TALL
        )
        for side, ends in (("l", left), ("r", right))
    }
    tall = max(_TALL, *depth.values())
    figure = page_figure(tall + 22, layout=None)
    page = figure.get_size_inches() * 25.4
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_label("power flow")
    axes.set_xlim(0, page[0])
    axes.set_ylim(-(tall + 8), 14)
    axes.text(3, 9, title, fontsize=9, fontweight="bold", va="center")
    trunk = (tall - _TALL) / 2
    axes.fill_between(_TRUNK, -trunk, -trunk - _TALL, color="#dfe6ee", lw=0)
    words = f"{in_unit(total, unit)}"
    axes.text(
        sum(_TRUNK) / 2, -trunk - _TALL / 2, words, ha="center", va="center", fontsize=SMALL + 1
    )
    _ends(axes, left, tops["l"], (tall - depth["l"]) / 2, trunk, per, unit, total, source=True)
    _ends(axes, right, tops["r"], (tall - depth["r"]) / 2, trunk, per, unit, total, source=False)
    return figure


def _unit(flow: PowerFlow) -> DisplayUnit:
    if flow.unit == "W":
        return display_unit("W", flow.total)
    if flow.total >= 1e4:
        return DisplayUnit("kJ", 1e-3)
    return DisplayUnit("J", 1.0) if flow.total >= 0.1 else DisplayUnit("mJ", 1e3)


def _ends(
    axes: Axes,
    ends: list[tuple[str, float]],
    tops: list[float],
    shift: float,
    trunk: float,
    per: float,
    unit: DisplayUnit,
    total: float,
    *,
    source: bool,
) -> None:
    """Blocks at one end, with words beside them and bands to the trunk."""
    from matplotlib.patches import Rectangle

    inner = trunk
    for index, ((name, value), top) in enumerate(zip(ends, tops, strict=True)):
        height, style = value * per, _style(name, index)
        outer = top + shift
        x = _LEFT if source else _RIGHT
        near = x + _BLOCK if source else x
        edge = _TRUNK[0] if source else _TRUNK[1]
        _band(axes, (near, outer), (edge, inner), height, style)
        axes.add_patch(Rectangle((x, -outer - height), _BLOCK, height, lw=0, label=name, **style))
        words = f"{_label(name, source)}\n{in_unit(value, unit)}"
        words += f", {number(100 * value / total, 3)} %" if value != total else ""
        axes.text(
            x - 2 if source else x + _BLOCK + 2,
            -outer - height / 2,
            words,
            ha="right" if source else "left",
            va="center",
            fontsize=SMALL,
            color=INK,
            linespacing=1.15,
        )
        inner += height


def _band(
    axes: Axes,
    start: tuple[float, float],
    end: tuple[float, float],
    height: float,
    style: dict[str, Any],
) -> None:
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    (x0, y0), (x1, y1) = start, end
    middle = (x0 + x1) / 2
    points = [
        (x0, -y0),
        (middle, -y0),
        (middle, -y1),
        (x1, -y1),
        (x1, -y1 - height),
        (middle, -y1 - height),
        (middle, -y0 - height),
        (x0, -y0 - height),
        (x0, -y0),
    ]
    curve = [Path.CURVE4] * 3
    codes = [Path.MOVETO, *curve, Path.LINETO, *curve, Path.CLOSEPOLY]
    colour = style["facecolor"]
    axes.add_patch(
        PathPatch(Path(points, codes), facecolor=colour, edgecolor=colour, alpha=0.55, lw=0.5)
    )


@drawn
def power_history_chart(mechanism: Mechanism, run: Transient) -> Figure:
    """Draw stacked powers over time: sinks above zero, sources below zero and hatched.

    Both halves have the same height at every instant; that is the power balance.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `run`: result of `simulate`.

    **Returns:** a matplotlib figure; time in ms or s, power in W or kW.

    **Raises:** `MissingExtraError` without matplotlib.
    """
    powers = power_history(mechanism, run)
    ends = {
        MOTOR: powers.motor,
        LOAD: powers.load,
        KINETIC: powers.kinetic,
        BRISTLES: powers.bristles,
    }
    size = max(float(np.abs(p).max()) for p in (*ends.values(), *powers.losses.values()))
    # Rounding errors of the balance are not drawn.
    ends = {n: p for n, p in ends.items() if float(np.abs(p).max()) > 1e-6 * max(size, 1e-300)}
    unit, clock = display_unit("W", size), display_unit("s", float(powers.time[-1]))
    time = clock(powers.time)
    figure = page_figure(92)
    axes = figure.subplots()
    shade(axes, sticking_phases(run), clock)
    handles: dict[str, Any] = {}
    for sign in (1, -1):
        parts = {n: np.maximum(-sign * p, 0.0) for n, p in ends.items()}
        if sign > 0:
            parts = {**powers.losses, **parts}
        base = np.zeros_like(time)
        for index, (name, part) in enumerate(parts.items()):
            if not float(part.max()) > 1e-9 * size:
                continue
            top = base + sign * unit(part)
            style = _style(name, index)
            if sign < 0:
                # A source has another look than the sink of the same name.
                style |= {"hatch": _SOURCE, "edgecolor": "white"}
            drawn_area = axes.fill_between(
                time, base, top, lw=0.3, **style, label=_label(name, sign < 0)
            )
            handles[_label(name, sign < 0)] = drawn_area
            base = top
    axes.axhline(0, color=INK, lw=0.8)
    axes.set_xlim(0, time[-1])
    axes.set_xlabel(f"time in {clock.label}")
    axes.set_ylabel(f"power in {unit.label}")
    axes.set_title("Power: sinks (above zero) and sources (below, hatched)")
    axes.grid(True)
    legend_below(figure, list(handles.values()), 5, labelcolor=MUTED)
    return figure
