"""Efficiency, carrier ratio and drive torque over time."""

from typing import Any

import numpy as np

from ...dynamics import Transient, settling_time
from ...text import display_unit, in_unit
from .._parts import DASHES
from .._style import MUTED, SERIES, SMALL, Figure, drawn, page_figure

#: A settling time before this sample is not resolved: between the first samples, carriers do not
#: approach their last values exponentially, which the interpolation assumes.
_RESOLVED = 5


def _settling_time(transient: Transient, band: float) -> float:
    """The latest `settling_time` of all stages [s]."""
    times, _ = settling_time(transient.time, transient.carrier_ratio, band)
    return float(np.max(np.asarray(times)))


def time_to_settle(transient: Transient, band: float = 0.01) -> float | None:
    """Time after which every carrier ratio stays within a band around its last value [s].

    **Arguments:**

    - `transient`: the time histories.
    - `band`: half the width of the band, relative to the last value.

    **Returns:** the latest `settling_time` of all stages; `None` if it lies after the last sample
    but one, or after the first sample and before the sixth, so that the settling time is unknown.
    """
    latest, time = _settling_time(transient, band), np.asarray(transient.time)
    known = latest <= time[0] or latest >= time[min(_RESOLVED, len(time) - 1)]
    return latest if known and latest <= float(time[-2]) else None


def settling_words(transient: Transient, band: float = 0.01) -> str:
    """The settling time in words, with a bound where `time_to_settle` is unknown.

    **Arguments:**

    - `transient`, `band`: as in `time_to_settle`.

    **Returns:** such as "0.133 ms", "less than 2.50 ms (1 sample)" where the samples are too coarse
    to tell, or "longer than the simulation".
    """
    unit = display_unit("s", float(transient.time[-1]))
    settled = time_to_settle(transient, band)
    if settled is not None:
        return in_unit(settled, unit, 3)
    latest, time = _settling_time(transient, band), np.asarray(transient.time)
    # NaN is neither.
    if not latest <= time[-2]:
        return "longer than the simulation"
    count = int(np.searchsorted(time, latest))
    bound = in_unit(time[count], display_unit("s", float(time[count])), 3)
    return f"less than {bound} ({count} sample{'s' * (count > 1)})"


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
    words = settling_words(transient)
    if settled is not None:
        words = f"dashed: carriers within 1 % of their last speed after {words}"
    elif words.startswith("less"):
        words = f"carriers within 1 % of their last speed after {words}"
    else:
        words = ""
    place: dict[str, Any] = {"transform": upper.transAxes, "ha": "right", "va": "bottom"}
    upper.text(0.995, 1.03, words, fontsize=SMALL, color=MUTED, **place)
    figure.align_ylabels()
    return figure
