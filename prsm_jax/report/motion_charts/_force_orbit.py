"""Paths of the forces on a roller over time, in the frame of its carrier."""

import math
from typing import Any

import numpy as np

from ...dynamics import BodyForces, Transient, body_forces
from ...mechanism import Mechanism
from ...text import display_unit, in_unit, number
from .._parts import legend_below
from .._style import INK, MUTED, SERIES, SMALL, Axes, Figure, drawn, page_figure

#: Force, words with the body that turns and the one that is held, ends of the roller, colour.
_NORMAL = (
    ("screw_normal_on_roller", "{turning}, normal", 1, 0),
    ("nut_on_roller", "{held}", 1, 2),
)
#: Sums of both ends of a roller, so that all forces of the picture add up to its inertia force.
_OTHERS = (
    ("screw_friction_on_roller", "{turning}, friction", 1, 3),
    ("ring_gear_on_roller", "{teeth}, both ends", 2, 4),
    ("pin_on_roller", "carrier pins, both ends", 2, 1),
)
_WAYS = ("radial", "tangential", "axial")
_ROW, _EXTRA = 68.0, 28.0
_READING = (
    "Arrow: the force at the end; curve: the way of its tip since the start; in brackets: the "
    "largest magnitude in the plane of the diagram."
)


@drawn
def force_orbit(mechanism: Mechanism, run: Transient, forces: BodyForces | None = None) -> Figure:
    """Draw the forces on one roller of every stage, in the frame of its carrier, over time.

    Each curve is the path of the tip of a force, from a hollow dot at the start to a full one at
    the end, true in direction. On the left are the normal forces of the threads in the plane
    through the axes of screw and roller, on the right all others in the transverse plane.

    **Arguments:**

    - `mechanism`, `run`: the mechanism and its transient.
    - `forces`: from `body_forces`, if computed already.

    **Returns:** a matplotlib figure; forces in N or kN.

    **Raises:** `MissingDataError` as `body_forces`; `MissingExtraError` without matplotlib.
    """
    if forces is None:
        forces = body_forces(mechanism, run)
    count = len(mechanism.stages)
    figure = page_figure(_ROW * count + _EXTRA)
    grid = figure.subplots(count, 2, squeeze=False)
    for stage, row in enumerate(grid):
        name = f", stage {stage + 1}" if count > 1 else ""
        family = mechanism.stages[stage].thread.family
        teeth = "ring gear" if family.gear_body == "nut" else "teeth of the screw"
        bodies = {"turning": family.turning, "held": family.held, "teeth": teeth}
        normal, others = (
            tuple((one[0], one[1].format(**bodies), *one[2:]) for one in rows)
            for rows in (_NORMAL, _OTHERS)
        )
        _orbits(row[0], forces, stage, normal, (0, 2))
        row[0].set_title(f"Threads, normal force{name}")
        _orbits(row[1], forces, stage, others, (0, 1))
        row[1].set_title(f"Friction, gear and carrier{name}")
    _legend(figure, float(run.time[0]), float(run.time[-1]))
    return figure


def _orbits(
    axes: Axes, forces: BodyForces, stage: int, chosen: tuple[Any, ...], plane: tuple[int, int]
) -> None:
    paths = [
        ends * np.asarray(getattr(forces, attribute))[stage][:, plane]
        for attribute, _, ends, _ in chosen
    ]
    largest = max(float(np.abs(path).max()) for path in paths)
    unit = display_unit("N", largest)
    axes.axhline(0, color=MUTED, lw=0.6)
    axes.axvline(0, color=MUTED, lw=0.6)
    for path, (_, words, _, colour) in zip(paths, chosen, strict=True):
        x, y = unit(path).T
        style: dict[str, Any] = {"color": SERIES[colour], "zorder": 3}
        size = unit(float(np.linalg.norm(path, axis=1).max()))
        words = f"{words} ({number(size, 3)} {unit.label})"
        axes.plot(x, y, lw=1.6, label=words, **style)
        axes.plot(x[0], y[0], "o", ms=5, mfc="white", mew=1.2, **style)
        axes.plot(x[-1], y[-1], "o", ms=5, **style)
        arrow = {"arrowstyle": "-|>", "mutation_scale": 7, "color": SERIES[colour], "lw": 0.7}
        if math.hypot(x[-1], y[-1]) > 0.05 * unit(largest):
            arrow |= {"shrinkA": 0, "shrinkB": 3, "alpha": 0.7}
            axes.annotate("", (x[-1], y[-1]), (0, 0), arrowprops=arrow)
    # Beside the panel's own curves: the same force has another magnitude in another plane.
    axes.legend(loc="best", fontsize=SMALL, handlelength=1.0, frameon=True, framealpha=0.85)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.15)
    axes.set_xlabel(f"{_WAYS[plane[0]]} force in {unit.label}")
    axes.set_ylabel(f"{_WAYS[plane[1]]} force in {unit.label}")
    axes.grid(True)


def _legend(figure: Figure, start: float, end: float) -> None:
    from matplotlib.lines import Line2D

    clock = display_unit("s", end)
    dot: dict[str, Any] = {"ls": "", "marker": "o", "ms": 5, "color": INK}
    handles = [
        Line2D([], [], mfc="white", mew=1.2, label=f"at {in_unit(start, clock, 3)}", **dot),
        Line2D([], [], label=f"at {in_unit(end, clock, 3)}", **dot),
    ]
    style: dict[str, Any] = {"fontsize": SMALL, "columnspacing": 1.0, "handlelength": 1.3}
    legend_below(figure, handles, title=_READING, title_fontsize=SMALL, **style)
