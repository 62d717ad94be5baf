"""Load spectrum and rating life: what loads the threads, what uses them up, how long they last."""

from typing import Any

import numpy as np

from .._display_units import display_unit, in_unit, number
from ..mechanism import Scalar
from ..strength import LoadSpectrum, equivalent_load
from ._style import FREE, INK, MUTED, SERIES, SMALL, Axes, Figure, drawn, page_figure

#: Up to so many phases are told apart by number.
_MOST_NAMED = 8
#: A bar narrower than this share is too narrow for its number.
_NAMED_SHARE = 0.03


@drawn
def life_chart(
    capacity: Scalar | float,
    spectrum: LoadSpectrum,
    static_capacity: Scalar | float | None = None,
) -> Figure:
    """Draw a load spectrum, the damage of its phases, and the life against the load.

    Above, the phases in order of their load over their share of the turning, with the equivalent
    load, and below each the share of the damage that it does. Beside them the basic rating life
    $10^6 (C_a/F)^3$ with the point of the equivalent load. Magnitudes count, on one flank.

    **Arguments:**

    - `capacity`: dynamic capacity C_a [N].
    - `spectrum`: the loads, of a duty cycle or a transient (`load_spectrum`).
    - `static_capacity`: C_0a [N], where the line of the life ends.

    **Returns:** a matplotlib figure; loads in N or kN, lives in turns of the screw.

    **Raises:** `ValueError` for a spectrum without load; `MissingExtraError` without matplotlib.
    """
    loads = np.abs(np.asarray(spectrum.load, float))
    share = np.asarray(spectrum.weights, float)
    mean, rated = float(equivalent_load(spectrum)), float(capacity)
    if not mean > 0:
        raise ValueError("the spectrum has no load, so its life has no end; nothing can be drawn")
    order = np.argsort(-loads, kind="stable")
    figure = page_figure(88)
    halves: Any = figure.subfigures(1, 2, width_ratios=(1.15, 1))
    left, line = halves
    bars, damage = left.subplots(2, 1, sharex=True, height_ratios=(1.6, 1))
    unit = display_unit("N", loads)
    width, height = 100 * share[order], loads[order]
    start = np.cumsum(width) - width
    harm = share[order] * height**3
    harm = 100 * harm / harm.sum()
    for axes, values in ((bars, unit(height)), (damage, harm)):
        axes.bar(
            start, values, width, align="edge", facecolor=FREE, edgecolor="white", linewidth=0.5
        )
        axes.grid(axis="y")
    if len(loads) <= _MOST_NAMED:
        _name_phases(damage, start + width / 2, harm, order, width)
    bars.axhline(unit(mean), color=INK, linestyle="--", linewidth=1.0)
    bars.text(
        100,
        unit(mean),
        f"equivalent {in_unit(mean, unit)}",
        ha="right",
        va="bottom",
        fontsize=SMALL,
    )
    bars.set_ylim(0, 1.18 * unit(height.max()))
    damage.set_ylim(0, 1.3 * harm.max())
    damage.set_xlim(0, 100)
    bars.set_ylabel(f"load in {unit.label}")
    damage.set_ylabel("damage in %")
    damage.set_xlabel("share of the turning in %")
    bars.set_title("Load spectrum")
    named = " (numbered)" if len(loads) <= _MOST_NAMED else ""
    damage.set_title(f"Damage by phase{named}")
    _life_line(line.subplots(), rated, mean, static_capacity)
    return figure


def _name_phases(axes: Axes, centres, heights, order, widths) -> None:
    for centre, height, index, width in zip(centres, heights, order, widths, strict=True):
        if width > 100 * _NAMED_SHARE:
            words = f"{index + 1}"
            axes.text(centre, height, words, ha="center", va="bottom", fontsize=SMALL)


def _life_line(axes: Axes, capacity: float, mean: float, static_capacity) -> None:
    unit = display_unit("N", [capacity])
    lowest = min(mean, capacity / 10) / 2
    highest = capacity if static_capacity is None else max(capacity, float(static_capacity))
    forces = np.geomspace(lowest, highest, 50)
    axes.loglog(unit(forces), 1e6 * (capacity / forces) ** 3, color=SERIES[0])
    life = 1e6 * (capacity / mean) ** 3
    axes.plot([unit(mean)] * 2, [1e5, life], color=MUTED, linewidth=0.8, linestyle=":")
    axes.plot(unit(mean), life, "o", color=SERIES[3], markersize=5)
    axes.annotate(
        f"{number(life, 3)} turns\nat {in_unit(mean, unit, 3)}",
        (unit(mean), life),
        (8, 4),
        textcoords="offset points",
        fontsize=SMALL,
    )
    axes.plot(unit(capacity), 1e6, "s", color=SERIES[0], markersize=4)
    axes.annotate(
        f"dynamic capacity\n{in_unit(capacity, unit, 3)}",
        (unit(capacity), 1e6),
        (-6, -3),
        textcoords="offset points",
        ha="right",
        va="top",
        fontsize=SMALL,
    )
    if static_capacity is not None:
        axes.axvline(unit(float(static_capacity)), color=INK, linestyle="--", linewidth=0.8)
        axes.annotate(
            f"static capacity\n{in_unit(static_capacity, unit, 3)}",
            (unit(float(static_capacity)), 1.0),
            (-4, -2),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            ha="right",
            va="top",
            fontsize=SMALL,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0},
        )
    axes.set_ylim(bottom=1e5)
    axes.grid(which="major")
    axes.set_xlabel(f"load in {unit.label}")
    axes.set_ylabel("basic rating life in turns")
    axes.set_title("Life against load")
    _plain_decades(axes)


def _plain_decades(axes: Axes) -> None:
    """Whole numbers on an axis of few decades, none between them."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
