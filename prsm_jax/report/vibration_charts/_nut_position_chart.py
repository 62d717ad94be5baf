"""Frequencies and static stiffness of an axis against the position of the nut."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Array, Float

from ...fields import Scalar
from ...mechanism import Side
from ...text import DisplayUnit, display_unit
from .._parts import DASHES, in_words
from .._style import MUTED, SERIES, SMALL, Axes, Figure, drawn, page_figure

_MILLIMETRES = DisplayUnit("mm", 1e3)
#: Quantities of the chart, with the words of the legend.
NUT_POSITION_QUANTITIES = {
    "first_axial_frequency": "first axial",
    "first_torsional_frequency": "first torsional",
    "antiresonance_frequency": "first, motor held",
    "held_motor_stiffness": "motor held",
    "servo_stiffness": "motor held by its controller",
}


@drawn
def nut_position_chart(
    distance: Float[Array | np.ndarray, " positions"],
    values: Mapping[str, Float[Array | np.ndarray, " positions"]],
    given: float | Scalar | None = None,
    *,
    turning: Side = "screw",
) -> Figure:
    """Draw natural frequencies, and static stiffness at the load, against the nut's position.

    Both have logarithmic scales, so that equal heights are equal ratios.

    **Arguments:**

    - `distance`: of the nut from the thrust bearing; of an inverted roller screw, from the end of
      the screw at the load [m].
    - `values`: quantities of the catalogue by name, one number for each distance: first axial and
      torsional frequency, anti-resonance, stiffness with the motor held and on its
      gain [Hz, N/m]. What is not there or not finite is left out.
    - `given`: distance in the file, drawn as a line [m].
    - `turning`: the body that turns; `"nut"` for an inverted roller screw.

    **Returns:** a matplotlib figure; distances in mm, frequencies in Hz, stiffnesses in N/µm.

    **Raises:** `ValueError` for other quantities, or if there are none; `MissingExtraError` without
    matplotlib.
    """
    unknown = sorted(set(values) - set(NUT_POSITION_QUANTITIES))
    if unknown or not values:
        raise ValueError(
            f"values has {', '.join(unknown) or 'no quantities'}; give some of "
            f"{', '.join(NUT_POSITION_QUANTITIES)}"
        )
    panels = {
        unit: [name for name in NUT_POSITION_QUANTITIES if name in values and _unit(name) == unit]
        for unit in ("Hz", "N/m")
    }
    panels = {unit: names for unit, names in panels.items() if names}
    figure = page_figure(20 + 55 * len(panels))
    every = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    along = _MILLIMETRES(np.asarray(distance))
    for axes, (unit, names) in zip(every, panels.items(), strict=True):
        shown = DisplayUnit("Hz", 1.0) if unit == "Hz" else display_unit(unit)
        for index, name in enumerate(names):
            curve = np.asarray(values[name], float)
            style: dict[str, Any] = {"color": SERIES[index], "ls": DASHES[index]}
            curve = np.where(np.isfinite(curve), shown(curve), np.nan)
            axes.semilogy(along, curve, label=NUT_POSITION_QUANTITIES[name], **style)
        words = "natural frequency" if unit == "Hz" else "static stiffness at the load"
        axes.set_ylabel(in_words(words, shown))
        _finish(axes)
        if given is not None:
            axes.axvline(_MILLIMETRES(float(given)), color=MUTED, lw=0.8, ls=(0, (2, 2)))
    every[0].set_title("Axis against the position of the nut")
    start = "thrust bearing" if turning == "screw" else "end of the screw at the load"
    every[-1].set_xlabel(f"distance of the nut from the {start} in mm")
    every[-1].set_xlim(along.min(), along.max())
    if given is not None:
        every[0].annotate(
            "as given",
            (_MILLIMETRES(float(given)), 1),
            (3, -3),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            va="top",
            fontsize=SMALL,
            color=MUTED,
        )
    return figure


def _unit(name: str) -> str:
    return "Hz" if name.endswith("frequency") else "N/m"


def _finish(axes: Axes) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter

    low, high = axes.get_ylim()
    # Half a decade at least: a curve that hardly changes is flat.
    if high < 3 * low:
        middle = (low * high) ** 0.5
        low, high = middle / 3**0.5, middle * 3**0.5
    axes.set_ylim(low / 1.15, high * 1.15)
    wide = high / low > 100
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 3.0, 5.0, 7.0)))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(which="major")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=2.6)
