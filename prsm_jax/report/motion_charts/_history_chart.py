"""All histories of a transient over time, with shaded phases in which the mechanism sticks."""

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np

from ...dynamics import Transient, known_efficiency, travel_per_radian
from ...mechanism import Mechanism
from ...text import DisplayUnit, display_unit, in_unit
from .._parts import DASHES, legend_below, page_title
from .._style import INK, MUTED, SERIES, SMALL, Axes, Figure, drawn, page_figure

_STICK = "#dfe3e8"
_ROW, _EXTRA = 33.0, 26.0
#: Share of an axis between curves and frame.
_APART = 0.02
#: Below this share of the largest speed, as while the motion reverses, no ratio of speeds is drawn.
_SLOW = 0.01
#: Said below the diagrams if ratios have gaps.
_GAPS = "gaps in ratios: near standstill, and in the efficiency where masses store or return energy"


def travel_of(mechanism: Mechanism, run: Transient) -> np.ndarray:
    """Travel of the last nut from its start [m]."""
    if run.position is not None:
        return np.asarray(run.position)
    return integrated(run, nut_speed(mechanism, run))


def nut_speed(mechanism: Mechanism, run: Transient) -> np.ndarray:
    """Axial speed of the last nut, positive for a positive speed [m/s]."""
    per_radian = float(travel_per_radian(mechanism.stages, len(mechanism.stages)))
    speed = np.asarray(run.screw_speed)
    if not mechanism.stages[-1].thread.family.lead_is_fixed:
        # A nut with grooves travels by the lead per turn of screw over carrier.
        speed = speed - np.asarray(run.carrier_speed)[-1]
    return per_radian * speed


def integrated(run: Transient, rate: Any) -> np.ndarray:
    """Integral of a history from the start, by the trapezoidal rule."""
    time, rate = np.asarray(run.time), np.asarray(rate)
    steps = np.diff(time) * (rate[1:] + rate[:-1]) / 2
    return np.concatenate([[0.0], np.cumsum(steps)])


def sticking_phases(run: Transient) -> list[tuple[float, float]]:
    """Start and end of every phase in which the mechanism sticks [s]."""
    if run.phases is None:
        return []
    start, end, mode = (np.asarray(a) for a in (run.phases.start, run.phases.end, run.phases.mode))
    sticking = (mode == 0) & (end > start)
    return [(float(a), float(b)) for a, b in zip(start[sticking], end[sticking], strict=True)]


@dataclasses.dataclass(frozen=True)
class History:
    """One diagram: curves of one quantity [SI], one for each stage or a single one.

    A curve is NaN where the quantity is not defined.
    """

    name: str
    curves: np.ndarray
    unit: DisplayUnit
    colour: int | None = None


def _largest(curves: np.ndarray) -> float:
    return float(np.nanmax(np.abs(curves), initial=0.0))


def _one(name: str, curve: Any, unit: str, colour: int) -> History:
    curve = np.asarray(curve)
    return History(name, curve[None], display_unit(unit, _largest(curve)), colour)


def _stages(name: str, curves: Any, unit: str) -> History:
    curves = np.asarray(curves)
    return History(name, curves, display_unit(unit, _largest(curves)))


def _while_moving(run: Transient, curves: Any) -> np.ndarray:
    """Curves that are NaN at rest and close to it, where a ratio of speeds has no meaning."""
    speed = np.abs(np.asarray(run.screw_speed))
    return np.where(speed > _SLOW * speed.max(), np.asarray(curves), np.nan)


def histories(mechanism: Mechanism, run: Transient) -> list[History]:
    """All histories of a transient; the first four are those of motion and demand."""
    family = mechanism.stages[0].thread.family
    travels = "last nut" if family.held == "nut" else "screw"
    teeth = "teeth of the screw" if family.gear_body == "screw" else "ring gear"
    return [
        _one(f"{family.turning} speed", run.screw_speed, "rad/s", 0),
        _one("drive torque", run.drive_torque, "N·m", 3),
        _one(f"travel of the {travels}", travel_of(mechanism, run), "m", 0),
        _one("load", run.load, "N", 3),
        _stages("carrier ratio ω/Ω", _while_moving(run, run.carrier_ratio), "1"),
        _stages("contact force on a roller", run.contact_force, "N"),
        History("efficiency", known_efficiency(run)[None], DisplayUnit("%", 100.0), 0),
        _stages(f"{teeth} on roller", run.ring_gear_force, "N"),
        _stages("spline friction", run.spline_friction, "N"),
        _stages("carrier on roller", run.carrier_force, "N"),
    ]


def is_constant(history: History) -> bool:
    """Whether all curves keep one value."""
    known = [curve[np.isfinite(curve)] for curve in history.curves]
    spread = max([float(np.ptp(curve)) for curve in known if len(curve)], default=0.0)
    return spread <= 1e-9 * _largest(history.curves)


@drawn
def history_chart(mechanism: Mechanism, run: Transient) -> Figure:
    """Draw speed, travel, torque, load, efficiency, carriers and forces over time.

    Phases in which the mechanism sticks are shaded. Constant histories are not drawn; the heading
    gives the values of a constant speed, torque, travel or load.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `run`: result of `simulate`, with a prescribed speed or a prescribed torque.

    **Returns:** a matplotlib figure; time in ms or s, speed in rpm, travel in mm or µm, torque in
    N·m, forces in N or kN, efficiency in %.

    **Raises:** `MissingExtraError` without matplotlib.
    """
    every = histories(mechanism, run)
    shown = [one for one in every if not is_constant(one)]
    fixed = [one for one in every[:4] if is_constant(one)]
    rows = (len(shown) + 1) // 2
    figure = page_figure(_ROW * rows + _EXTRA)
    grid = figure.add_gridspec(rows, 2)
    # The last of an odd number of diagrams has the whole width.
    places = [grid[i // 2, i % 2] for i in range(len(shown))]
    if len(shown) % 2:
        places[-1] = grid[-1, :]
    clock = display_unit("s", float(run.time[-1]))
    time = clock(np.asarray(run.time))
    phases = sticking_phases(run)
    lowest = set(range(len(shown))[-2:]) | ({len(shown) - 3} if len(shown) % 2 else set())
    for place, (at, history) in enumerate(zip(places, shown, strict=True)):
        axes = figure.add_subplot(at, sharex=figure.axes[0] if figure.axes else None)
        _draw(axes, history, time)
        shade(axes, phases, clock)
        # Apart from the frame, on which a curve would not be seen.
        axes.set_xlim(-_APART * time[-1], (1 + _APART) * time[-1])
        axes.tick_params(axis="x", labelbottom=place in lowest)
        if place in lowest:
            axes.set_xlabel(f"time in {clock.label}")
    gaps = any(np.isnan(one.curves).any() for one in shown)
    _head(figure, fixed)
    _legend(figure, np.asarray(run.carrier_ratio).shape[0], bool(phases), _GAPS if gaps else "")
    figure.align_ylabels()
    return figure


def _draw(axes: Axes, history: History, time: np.ndarray) -> None:
    unit = history.unit
    several = len(history.curves) > 1
    for stage, curve in enumerate(history.curves):
        if several and not np.any(curve):
            continue
        colour = SERIES[(0, 3, 2, 4)[stage % 4]] if history.colour is None else INK
        dashes = DASHES[stage % len(DASHES)] if several else "-"
        axes.plot(time, unit(curve), color=colour, ls=dashes, lw=1.2)
    axes.set_title(history.name)
    axes.set_ylabel(f"in {unit.label}" if unit.label else "")
    axes.grid(True)
    known = history.curves[np.isfinite(history.curves)]
    if known.size and known.min() >= 0:
        axes.set_ylim(-_APART * 2 * unit(known.max()), (1 + 4 * _APART) * unit(known.max()))
    else:
        axes.margins(y=0.08)


def shade(axes: Axes, phases: Iterable[tuple[float, float]], clock: DisplayUnit) -> None:
    """Shade the phases in which the mechanism sticks."""
    for start, end in phases:
        axes.axvspan(clock(start), clock(end), color=_STICK, lw=0, zorder=0)


def _head(figure: Figure, fixed: list[History]) -> None:
    words = [f"{one.name} {in_unit(one.curves[0, 0], one.unit)}" for one in fixed]
    heading = "Time histories" + (f": {', '.join(words)}" if words else "")
    page_title(figure, heading)


def _legend(figure: Figure, stages: int, sticks: bool, note: str) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = []
    if stages > 1:
        for stage in range(stages):
            style = {"color": SERIES[(0, 3, 2, 4)[stage % 4]], "ls": DASHES[stage % len(DASHES)]}
            handles.append(Line2D([], [], lw=1.2, label=f"stage {stage + 1}", **style))
    if sticks:
        handles.append(Patch(facecolor=_STICK, edgecolor=MUTED, lw=0.4, label="sticks"))
    if handles:
        legend_below(figure, handles, len(handles), title=note, title_fontsize=SMALL)
    elif note:
        figure.supxlabel(note, fontsize=SMALL)
