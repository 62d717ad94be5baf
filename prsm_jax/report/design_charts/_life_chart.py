"""Load spectrum, damage by phase, and rating life."""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ...fields import Scalar
from ...programs import one_program_where_possible
from ...strength import LoadSpectrum, TruncatedFatigue
from ...text import display_unit, in_unit, number
from .._parts import WHITE, aside, plain_ticks
from .._style import FREE, INK, MUTED, SERIES, SMALL, Axes, Figure, drawn, page_figure

#: Largest number of phases that are numbered.
_MOST_NAMED = 8
#: A bar narrower than this share is too narrow for its number, unless its damage is above a number
#: of per cent and the last number is more than some per cent of the revolutions away.
_NAMED_SHARE, _MATTERS, _APART = 0.03, 5.0, 4.0


@drawn
def life_chart(
    capacity: Scalar | float,
    spectrum: LoadSpectrum,
    static_capacity: Scalar | float | None = None,
    fatigue: TruncatedFatigue | None = None,
) -> Figure:
    """Draw a load spectrum, the damage of its phases, and the life against the load.

    Above, the phases in order of their load over their share of the revolutions, with the
    equivalent load; below each, its share of the damage. Beside them, the basic rating life
    with the point of the equivalent load, which is the constant load with the same life. Loads are
    magnitudes, on one flank. The life is $10^6 (C_a/F)^3$, and the equivalent load the cubic mean,
    as long as no contact ellipse extends beyond the end of a flank.

    **Arguments:**

    - `capacity`: dynamic capacity C_a [N].
    - `spectrum`: the loads, of a duty cycle or a transient (`load_spectrum`).
    - `static_capacity`: C_0a [N], where the life line ends.
    - `fatigue`: `strength.truncated_fatigue` of the stage, where flanks end: life and damage then
      depend on the part of the ellipses that remains on the flanks under each load.

    **Returns:** a matplotlib figure; loads in N or kN, lives in turns.

    **Raises:** `ValueError` for a spectrum without load; `MissingExtraError` without matplotlib.
    """
    loads = np.abs(np.asarray(spectrum.load, float))
    share = np.asarray(spectrum.weights, float)
    rated = float(capacity)
    if not loads.max() > 0:
        raise ValueError("the spectrum has no load, so its life is infinite; nothing can be drawn")

    def comparable(forces: np.ndarray) -> np.ndarray:
        return _comparable(fatigue, forces, rated)

    mean = _constant_load(comparable, np.sum(share * comparable(loads) ** 3) ** (1 / 3))
    order = np.argsort(-loads, kind="stable")
    figure = page_figure(88)
    halves: Any = figure.subfigures(1, 2, width_ratios=(1.15, 1))
    left, line = halves
    bars, damage = left.subplots(2, 1, sharex=True, height_ratios=(1.6, 1))
    unit = display_unit("N", loads)
    width, height = 100 * share[order], loads[order]
    start = np.cumsum(width) - width
    damage_share = share[order] * comparable(height) ** 3
    damage_share = 100 * damage_share / damage_share.sum()
    for axes, values in ((bars, unit(height)), (damage, damage_share)):
        axes.bar(
            start, values, width, align="edge", facecolor=FREE, edgecolor="white", linewidth=0.5
        )
        axes.grid(axis="y")
    if len(loads) <= _MOST_NAMED:
        _name_phases(damage, start + width / 2, damage_share, order, width)
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
    damage.set_ylim(0, 1.3 * damage_share.max())
    damage.set_xlim(0, 100)
    bars.set_ylabel(f"load in {unit.label}")
    damage.set_ylabel("damage in %")
    damage.set_xlabel("share of the revolutions in %")
    bars.set_title("Load spectrum")
    named = " (numbered)" if len(loads) <= _MOST_NAMED else ""
    damage.set_title(f"Damage by phase{named}")
    _life_line(
        line.subplots(),
        rated,
        mean,
        static_capacity,
        lambda forces: lives_under(forces, rated, fatigue),
    )
    return figure


#: Points of a grid, and how many times it is narrowed about a load.
_POINTS, _TIMES = 64, 4


@one_program_where_possible
def _comparable_load(fatigue: TruncatedFatigue, forces: Array, capacity: Array) -> Array:
    return fatigue.comparable_load(forces, capacity)


def _comparable(
    fatigue: TruncatedFatigue | None, forces: np.ndarray, capacity: float
) -> np.ndarray:
    """Loads whose lives follow the cube law."""
    if fatigue is None:
        return forces
    # Padded to one of few lengths, so that one compiled program serves nearly all.
    padded = np.pad(forces, (0, -len(forces) % _POINTS), mode="edge")
    result = _comparable_load(fatigue, jnp.asarray(padded), jnp.asarray(capacity))
    return np.asarray(result)[: len(forces)]


def lives_under(
    forces: np.ndarray, capacity: float, fatigue: TruncatedFatigue | None = None
) -> np.ndarray:
    """Basic rating life under constant loads, in turns of the body that turns.

    **Arguments:**

    - `forces`: the loads [N].
    - `capacity`: dynamic capacity [N].
    - `fatigue`: as for `life_chart`.
    """
    return 1e6 * (capacity / _comparable(fatigue, forces, capacity)) ** 3


def _constant_load(comparable: Callable[[np.ndarray], np.ndarray], target: float) -> float:
    """The load at which `comparable`, an increasing function, has the value of the mean."""
    low, high = target, target
    while comparable(np.asarray([low]))[0] > target:
        low /= 2
    while comparable(np.asarray([high]))[0] < target:
        high *= 2
    for _ in range(_TIMES):
        forces = np.linspace(low, high, _POINTS)
        place = np.clip(np.searchsorted(comparable(forces), target), 1, _POINTS - 1)
        low, high = forces[place - 1], forces[place]
    ends = np.asarray([low, high])
    return float(np.interp(target, comparable(ends), ends))


def _name_phases(axes: Axes, centres, heights, order, widths) -> None:
    last = -np.inf
    for centre, height, index, width in zip(centres, heights, order, widths, strict=True):
        # A narrow bar has a number if it matters and the number does not touch the last one.
        matters = height > _MATTERS and centre - last > _APART
        if width > 100 * _NAMED_SHARE or matters:
            last = centre
            words = f"{index + 1}"
            axes.text(centre, height, words, ha="center", va="bottom", fontsize=SMALL)


def _life_line(
    axes: Axes,
    capacity: float,
    mean: float,
    static_capacity,
    life_under: Callable[[np.ndarray], np.ndarray],
) -> None:
    unit = display_unit("N", [capacity])
    lowest = min(mean, capacity / 10) / 2
    highest = capacity if static_capacity is None else max(capacity, float(static_capacity))
    forces = np.geomspace(lowest, highest, 50)
    axes.loglog(unit(forces), life_under(forces), color=SERIES[0])
    life = float(life_under(np.asarray([mean]))[0])
    axes.plot([unit(mean)] * 2, [1e5, life], color=MUTED, linewidth=0.8, linestyle=":")
    axes.plot(unit(mean), life, "o", color=SERIES[3], markersize=5)
    words = f"{number(life, 3)} turns\nat {in_unit(mean, unit, 3)}"
    aside(axes, words, (unit(mean), life), (8, 4))
    axes.plot(unit(capacity), 1e6, "s", color=SERIES[0], markersize=4)
    words = f"dynamic capacity\n{in_unit(capacity, unit, 3)}"
    aside(axes, words, (unit(capacity), 1e6), (-6, -3), va="top")
    if static_capacity is not None:
        axes.axvline(unit(float(static_capacity)), color=INK, linestyle="--", linewidth=0.8)
        words = f"static capacity\n{in_unit(static_capacity, unit, 3)}"
        place, style = (unit(float(static_capacity)), 1.0), {"bbox": {**WHITE, "pad": 1.0}}
        style |= {"xycoords": ("data", "axes fraction"), "va": "top"}
        aside(axes, words, place, (-4, -2), **style)
    axes.set_ylim(bottom=1e5)
    axes.grid(which="major")
    axes.set_xlabel(f"load in {unit.label}")
    axes.set_ylabel("basic rating life in turns")
    axes.set_title("Life against load")
    plain_ticks(axes.xaxis)
