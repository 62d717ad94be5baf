"""All histories of a transient over time, with shaded phases in which the mechanism sticks."""

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np

from ...dynamics import Transient, travel_per_turn
from ...mechanism import Mechanism
from ...text import DisplayUnit, display_unit, in_unit
from .._parts import DASHES, legend_below, page_title
from .._style import INK, MUTED, SERIES, Axes, Figure, drawn, page_figure

_STICK = "#dfe3e8"
_ROW, _EXTRA = 33.0, 26.0
#: Below this share of the largest power an efficiency is meaningless.
_IDLE = 1e-3


def travel_of(mechanism: Mechanism, run: Transient) -> np.ndarray:
    """Travel of the last nut from its start [m]."""
    if run.position is not None:
        return np.asarray(run.position)
    per_radian = float(travel_per_turn(mechanism.stages, len(mechanism.stages)))
    return per_radian * integrated(run, run.screw_speed)


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
class _History:
    """One diagram: curves of one quantity [SI], one for each stage or a single one."""

    name: str
    curves: np.ndarray
    unit: DisplayUnit
    colour: int | None = None
    limits: tuple[float, float] | None = None


def _largest(curves: np.ndarray) -> float:
    return float(np.nanmax(np.abs(curves), initial=0.0))


def _one(name: str, curve: Any, unit: str, colour: int) -> _History:
    curve = np.asarray(curve)
    return _History(name, curve[None], display_unit(unit, _largest(curve)), colour)


def _stages(name: str, curves: Any, unit: str) -> _History:
    curves = np.asarray(curves)
    return _History(name, curves, display_unit(unit, _largest(curves)))


def _while_moving(run: Transient, curves: Any) -> np.ndarray:
    """Curves that are NaN where the mechanism sticks or is at rest."""
    return np.where(np.asarray(run.screw_speed) == 0, np.nan, np.asarray(curves))


def _efficiency(mechanism: Mechanism, run: Transient) -> _History:
    travel = float(travel_per_turn(mechanism.stages, len(mechanism.stages)))
    speed = np.asarray(run.screw_speed)
    power = np.maximum(
        np.abs(np.asarray(run.drive_torque) * speed), np.abs(np.asarray(run.load) * speed * travel)
    )
    share = np.where(power > _IDLE * max(power.max(), 1e-300), np.asarray(run.efficiency), np.nan)
    unit = DisplayUnit("%", 100.0)
    # While masses are accelerated or return energy, the ratio of powers leaves these limits.
    return _History("efficiency", share[None], unit, 0, (-5.0, 105.0))


def _histories(mechanism: Mechanism, run: Transient) -> list[_History]:
    return [
        _one("screw speed", run.screw_speed, "rad/s", 0),
        _one("drive torque", run.drive_torque, "N·m", 3),
        _one("travel of the last nut", travel_of(mechanism, run), "m", 0),
        _one("load", run.load, "N", 3),
        _stages("carrier ratio ω/Ω", _while_moving(run, run.carrier_ratio), "1"),
        _stages("contact force on a roller", run.contact_force, "N"),
        _efficiency(mechanism, run),
        _stages("ring gear on roller", run.ring_gear_force, "N"),
        _stages("spline friction", run.spline_friction, "N"),
        _stages("carrier on roller", run.carrier_force, "N"),
    ]


def _is_constant(history: _History) -> bool:
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
    every = _histories(mechanism, run)
    shown = [one for one in every if not _is_constant(one)]
    fixed = [one for one in every[:4] if _is_constant(one)]
    rows = (len(shown) + 1) // 2
    figure = page_figure(_ROW * rows + _EXTRA)
    grid = figure.subplots(rows, 2, sharex=True, squeeze=False)
    clock = display_unit("s", float(run.time[-1]))
    time = clock(np.asarray(run.time))
    phases = sticking_phases(run)
    for axes, history in zip(grid.ravel(), shown, strict=False):
        _draw(axes, history, time)
        shade(axes, phases, clock)
        axes.set_xlim(0, time[-1])
    for axes in grid.ravel()[len(shown) :]:
        axes.set_visible(False)
    # The lowest diagram of each column has the time, also above an empty place.
    for axes in (grid[-1, 0], grid[-1 if len(shown) % 2 == 0 else -2, 1]):
        axes.set_xlabel(f"time in {clock.label}")
        axes.tick_params(axis="x", labelbottom=True)
    _head(figure, fixed)
    _legend(figure, np.asarray(run.carrier_ratio).shape[0], bool(phases))
    figure.align_ylabels()
    return figure


def _draw(axes: Axes, history: _History, time: np.ndarray) -> None:
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
    if history.limits is not None:
        axes.set_ylim(*history.limits)
    elif np.nanmin(history.curves) >= 0:
        axes.set_ylim(bottom=0)


def shade(axes: Axes, phases: Iterable[tuple[float, float]], clock: DisplayUnit) -> None:
    """Shade the phases in which the mechanism sticks."""
    for start, end in phases:
        axes.axvspan(clock(start), clock(end), color=_STICK, lw=0, zorder=0)


def _head(figure: Figure, fixed: list[_History]) -> None:
    words = [f"{one.name} {in_unit(one.curves[0, 0], one.unit)}" for one in fixed]
    heading = "Time histories" + (f": {', '.join(words)}" if words else "")
    page_title(figure, heading)


def _legend(figure: Figure, stages: int, sticks: bool) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = []
    if stages > 1:
        for stage in range(stages):
            style = {"color": SERIES[(0, 3, 2, 4)[stage % 4]], "ls": DASHES[stage % len(DASHES)]}
            handles.append(Line2D([], [], lw=1.2, label=f"stage {stage + 1}", **style))
    if sticks:
        handles.append(Patch(facecolor=_STICK, edgecolor=MUTED, lw=0.4, label="sticks"))
    legend_below(figure, handles, len(handles))
