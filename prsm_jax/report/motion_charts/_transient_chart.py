"""Efficiency, carrier ratio and drive torque over time."""

from typing import Any

import numpy as np

from ...dynamics import Transient, settling_time
from ...text import display_unit, in_unit
from .._parts import DASHES
from .._style import MUTED, SERIES, SMALL, Figure, drawn, page_figure


def time_to_settle(transient: Transient, band: float = 0.01) -> float | None:
    """Time after which every carrier ratio stays within a band around its last value [s].

    **Arguments:**

    - `transient`: the time histories.
    - `band`: half the width of the band, relative to the last value.

    **Returns:** the latest `settling_time` of all stages; `None` if it lies after the last sample
    but one, so that the settling time is unknown.
    """
    times, _ = settling_time(transient.time, transient.carrier_ratio, band)
    latest = float(np.max(np.asarray(times)))
    return latest if latest <= float(transient.time[-2]) else None


def settles(transient: Transient) -> bool:
    """Whether the screw turns at constant speed, so that carriers come to a steady state."""
    speed = np.asarray(transient.screw_speed)
    return bool(np.all(speed == speed[0]) and speed[0] != 0)


@drawn
def transient_chart(transient: Transient) -> Figure:
    """Draw the histories of efficiency, carrier ratio (each stage) and drive torque.

    **Arguments:**

    - `transient`: result of `simulate`.

    **Returns:** a matplotlib figure; time in ms or s, efficiency in %, torque in N·m.

    **Raises:** `MissingExtraError` without matplotlib.
    """
    figure = page_figure(120)
    upper, middle, lower = figure.subplots(3, 1, sharex=True)
    unit = display_unit("s", float(transient.time[-1]))
    time = unit(np.asarray(transient.time))
    stages = np.asarray(transient.carrier_ratio)

    upper.plot(time, 100 * np.asarray(transient.efficiency), color=SERIES[0])
    upper.set_ylabel("efficiency in %")
    for index, ratio in enumerate(stages):
        style = {"color": SERIES[index % len(SERIES)], "ls": DASHES[index % len(DASHES)]}
        middle.plot(time, ratio, label=f"stage {index + 1}", **style)
    middle.set_ylabel("carrier ratio ω/Ω")
    if len(stages) > 1:
        middle.legend(loc="lower right")
    lower.plot(time, np.asarray(transient.drive_torque), color=SERIES[3])
    lower.set_ylabel("drive torque in N·m")
    lower.set_xlabel(f"time in {unit.label}")
    settled = time_to_settle(transient)
    for axes in (upper, middle, lower):
        axes.grid(True)
        axes.margins(x=0, y=0.08)
        if settled is not None:
            axes.axvline(unit(settled), color=MUTED, lw=0.8, ls=(0, (4, 2)))
    upper.set_title("From rollers at rest to the steady state")
    if settled is not None:
        words = f"dashed: carriers within 1 % of their last speed after {in_unit(settled, unit, 3)}"
        place: dict[str, Any] = {"transform": upper.transAxes, "ha": "right", "va": "bottom"}
        upper.text(0.995, 1.03, words, fontsize=SMALL, color=MUTED, **place)
    figure.align_ylabels()
    return figure
