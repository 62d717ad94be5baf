"""Axial–torsional mode shapes in a longitudinal section of the axis, and where their energy is."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ...mechanism import Axis, Mechanism, Motor, Side, nut_outer_radius
from ...text import number, show
from ...vibration import SpatialMode, SpatialModes, strain_in_words
from .._parts import CHAIN, MODE_ENERGY, dense_legend, legend_line, per_mode
from .._style import (
    BODY_COLOURS,
    FAMILY_COLOURS,
    INK,
    MUTED,
    PAGE_WIDTH,
    SMALL,
    TITLE,
    Axes,
    Figure,
    drawn,
    page_figure,
    place_axes,
)

#: Largest displacement drawn, as a share of the drawing's length.
_LARGEST = 0.06
#: Widths and heights on the page [mm].
_LEFT, _SECTION, _GAP, _BARS = 3.0, 110.0, 32.0, 33.0
_HEADING, _OVER, _PANEL, _FOOT = 8.0, 6.5, 25.0, 19.0
#: Springs beside each mode, and the smallest share of one; the arrow's length that has a head [mm].
_SPRINGS_SHOWN, _LEAST, _HEAD = 5, 0.005, 2.5
_COLOURS = {**BODY_COLOURS, "motor": "#d7d3e6", "load": "#e3d8cf", "tube": "#e9ecef"}


@dataclass(frozen=True)
class _Part:
    """A part of the drawing: a rectangle above the centre line [mm]."""

    body: str
    ends: tuple[float, float]
    radii: tuple[float, float]
    #: Bodies whose axial displacement moves the left and the right end.
    moved: tuple[str, str]
    #: Body whose rotation is drawn at this part, and where.
    turned: str | None = None
    at: float = 0.0


@drawn
def axis_mode_shapes(
    mechanism: Mechanism, modes: SpatialModes, *, count: int = 5, energy: float = MODE_ENERGY
) -> Figure:
    """Draw the lowest axial–torsional modes in a longitudinal section, and their strain energies.

    Bodies are drawn at rest (outlines) and displaced along the axis (filled). Rotations are arrows
    across the axis: the travel θ L/2π that the turn of a screw would give the nut, at the scale of
    the displacements, so that rigid threads show arrows as long as the relative displacement of
    screw and nut. Bars give the share of the strain energy in each spring: raising its stiffness by
    1 % raises the frequency by half of this share.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `modes`: its modes, from `spatial_modal(mechanism, shapes=True)`.
    - `count`: number of modes, from the lowest elastic one.
    - `energy`: energy of the mode to which the printed magnification refers [J].

    **Returns:** a matplotlib figure, A4 wide; lengths along the axis in mm, shares in %.

    **Raises:** `ValueError` if the shapes were not computed, or for a count below 1 or an energy
    that is not positive; `MissingExtraError` without matplotlib.
    """
    if count < 1 or not 0 < energy < math.inf:
        raise ValueError(f"count is {count} and energy {energy:g} J; both must be positive")
    chosen = modes.elastic_modes()[:count]
    parts = _parts_of(mechanism, modes)
    height = _HEADING + len(chosen) * (_OVER + _PANEL) + _FOOT
    figure = page_figure(height, layout=None)
    figure.text(
        _LEFT / PAGE_WIDTH,
        1 - 4 / height,
        "Axial–torsional modes of the axis",
        fontsize=TITLE,
        fontweight="bold",
        va="center",
    )
    figure.text(
        (_LEFT + _SECTION + _GAP) / PAGE_WIDTH,
        1 - 4 / height,
        "strain energy in %",
        fontsize=SMALL,
        va="center",
    )
    turning = mechanism.stages[0].thread.family.turning
    for index, mode in enumerate(chosen):
        top = height - _HEADING - index * (_OVER + _PANEL) - _OVER
        section = place_axes(figure, _LEFT, top - _PANEL, _SECTION, _PANEL)
        _draw(section, parts, mode, mechanism, energy, last=index == len(chosen) - 1)
        across = place_axes(figure, _LEFT + _SECTION + _GAP, top - _PANEL + 2, _BARS, _PANEL - 3)
        _bars(across, strain_in_words(mode.strain, turning))
    _legend(figure, height, parts, energy, turning)
    return figure


def _length(value: Any, otherwise: float) -> float:
    return otherwise if value is None else 1e3 * float(value)


def _parts_of(mechanism: Mechanism, modes: SpatialModes) -> list[_Part]:
    stage, axis = mechanism.stages[0], mechanism.axis
    thread = stage.thread
    screw, nut = 1e3 * float(thread.screw_radius), 1e3 * float(thread.nut_radius)
    length = _length(stage.screw.length, 20 * screw)
    nut_length = _length(stage.nut.length, 4 * nut)
    shaft = None if axis is None else axis.shaft
    middle = _length(None if shaft is None else shaft.nut_distance, length / 2)
    near = "screw" if shaft is None else "screw_end"
    given = stage.nut.wall_thickness is not None
    outer = 1e3 * float(nut_outer_radius(stage)) if given else 1.4 * nut
    roller = _length(stage.roller.length, 0.8 * nut_length)
    half = nut_length / 2
    ends = middle - half, middle + half
    between = screw, screw + 2e3 * float(thread.roller_radius)
    far = None if shaft is None else shaft.far_bearing
    free = "screw" if far is None else "screw_far_end"
    last = length if far is None else 1e3 * float(far.distance)
    parts = [
        _Part("screw", (0.0, middle), (0.0, screw), (near, "screw"), near, 0.1 * middle),
        _Part("screw", (middle, last), (0.0, screw), ("screw", free), "screw", middle),
        _Part("roller", (middle - roller / 2, middle + roller / 2), between, ("roller", "roller")),
        _Part("nut", ends, (nut, outer), ("nut", "nut"), "nut", ends[0] + 0.85 * nut_length),
    ]
    if shaft is None:
        whole = _Part("screw", (0.0, length), (0.0, screw), ("screw", "screw"), "screw", middle)
        parts = [whole, *parts[2:]]
    if last < length:
        parts.append(_Part("screw", (last, length), (0.0, screw), (free, free)))
    if axis is None:
        return parts
    around = _motor_and_load if thread.family.turning == "screw" else _inverted_motor_and_load
    held = near if thread.family.held == "screw" else "nut"
    load = "load" if any(one.body == "load" for one in modes.coordinates) else held
    return [*parts, *around(axis, length, ends, (screw, nut, outer), near, load)]


_Radii: TypeAlias = tuple[float, float, float]


def _motor_and_load(
    axis: Axis, length: float, ends: tuple[float, float], radii: _Radii, near: str, load: str
) -> Iterator[_Part]:
    """The motor beside the screw, and the load behind the nut.

    `radii` are those of screw and nut and the outer one of the nut, `ends` those of the nut [mm],
    `near` is the part at the left end of the screw, and `load` what moves with the load.
    """
    _, nut, outer = radii
    if axis.motor is not None:
        size = 0.0, max(1.3 * nut, 0.8 * outer)
        # The stator stands still; what turns is drawn as an arrow.
        turned = "motor" if _has_shaft(axis.motor) else near
        box = -0.24 * length, -0.08 * length
        yield _Part("motor", box, size, ("", ""), turned, -0.16 * length)
    if axis.load is not None:
        start = max(length, ends[1]) + 0.06 * length
        wall = outer - 0.25 * (outer - nut)
        yield _Part("tube", (ends[1], start), (wall, outer), ("nut", load))
        yield _Part("load", (start, start + 0.13 * length), (0.0, 1.25 * outer), (load, load))


def _inverted_motor_and_load(
    axis: Axis, length: float, ends: tuple[float, float], radii: _Radii, near: str, load: str
) -> Iterator[_Part]:
    """The hollow motor around the nut, and the load at the left end of the screw."""
    screw, _, outer = radii
    if axis.motor is not None:
        turned = "motor" if _has_shaft(axis.motor) else "nut"
        wide = ends[1] - ends[0]
        box = ends[0] + 0.1 * wide, ends[1]
        size = 1.05 * outer, 1.35 * outer
        yield _Part("motor", box, size, ("", ""), turned, ends[0] + 0.3 * wide)
    if axis.load is not None:
        start = -0.06 * length
        yield _Part("tube", (start, 0.0), (0.0, 0.6 * screw), (load, near))
        yield _Part("load", (start - 0.13 * length, start), (0.0, 1.25 * outer), (load, load))


def _has_shaft(motor: Motor) -> bool:
    """Whether the rotor turns on springs of its own."""
    return motor.coupling_stiffness is not None or motor.shaft_stiffness is not None


def _draw(
    axes: Axes,
    parts: list[_Part],
    mode: SpatialMode,
    mechanism: Mechanism,
    energy: float,
    last: bool,
) -> None:
    from matplotlib.patches import Polygon

    left, right = min(p.ends[0] for p in parts), max(p.ends[1] for p in parts)
    span = right - left
    highest = max(p.radii[1] for p in parts)
    axes.set_xlim(left - 0.07 * span, right + 0.07 * span)
    axes.set_ylim(-0.75 * highest, 1.3 * highest)
    millimetres = 1e3 * per_mode(energy, mode.frequency)
    moved = {name: millimetres * value for name, value in mode.along.items()}
    turned = {name: millimetres * value for name, value in _travels(mechanism, mode.around).items()}
    turns = {p.turned for p in parts if p.turned is not None}
    largest = max(
        *(abs(moved.get(name, 0.0)) for p in parts for name in p.moved),
        *(abs(turned.get(name, 0.0)) for name in turns),
    )
    factor = _two_digits(_LARGEST * span / largest)
    for part in parts:
        inner, outer = part.radii
        a, b = part.ends
        rest = [(a, inner), (b, inner), (b, outer), (a, outer)]
        shift = [factor * moved.get(name, 0.0) for name in part.moved]
        now = [(a + shift[0], inner), (b + shift[1], inner), (b + shift[1], outer)]
        now.append((a + shift[0], outer))
        style: dict[str, Any] = {"closed": True, "lw": 0.6}
        axes.add_patch(
            Polygon(now, facecolor=_COLOURS[part.body], edgecolor=INK, label=part.body, **style)
        )
        axes.add_patch(
            Polygon(
                rest, facecolor="none", edgecolor=MUTED, ls=(0, (2, 1.5)), label="rest", **style
            )
        )
    axes.plot(axes.get_xlim(), (0, 0), color=MUTED, lw=0.5, ls=CHAIN)
    nut_end = next(part.ends[1] for part in parts if part.body == "nut")
    for place in _bearings(mechanism, nut_end):
        _bearing(axes, place, highest)
    # Equal lengths on paper along and across the axis.
    wide, tall = np.ptp(axes.get_xlim()) / _SECTION, np.ptp(axes.get_ylim()) / _PANEL
    for part in parts:
        if part.turned is not None:
            size = factor * turned.get(part.turned, 0.0) * tall / wide
            axes.plot(
                (part.at, part.at),
                (0, size),
                color=FAMILY_COLOURS["torsional"],
                lw=1.8,
                marker="" if abs(size) < _HEAD * tall else "^" if size > 0 else "v",
                markevery=[1],
                ms=4,
                label=f"turn of {part.turned}",
                zorder=5,
            )
    axes.set_yticks([])
    for side in ("left", "right", "top", "bottom"):
        axes.spines[side].set_visible(False)
    axes.tick_params(axis="x", length=2 if last else 0, labelbottom=last)
    if last:
        axes.set_xlabel("along the axis in mm", fontsize=SMALL)
    words = f"{mode.number}  {mode.family}  {show(mode.frequency, 'Hz')}"
    over: dict[str, Any] = {"transform": axes.transAxes, "va": "bottom"}
    axes.text(0, 1.02, words, color=FAMILY_COLOURS[mode.family], fontweight="bold", **over)
    axes.text(1, 1.02, f"displacements ×{number(factor, 2)}", ha="right", fontsize=SMALL, **over)


def _travels(mechanism: Mechanism, around: dict[str, float]) -> dict[str, float]:
    """Travel of the nut for the turn of each body, as if it were the screw's [m]."""
    thread = mechanism.stages[0].thread
    reduced = float(thread.lead) / (2 * math.pi)
    screw, nut = float(thread.screw_radius), float(thread.nut_radius)
    motor = screw if thread.family.turning == "screw" else nut
    radii = {"nut": nut, "carrier": float(thread.centre_distance), "motor": motor}
    return {name: -reduced * u / radii.get(name, screw) for name, u in around.items()}


def _two_digits(value: float) -> float:
    power = math.floor(math.log10(value)) - 1
    return float(f"{round(value / 10**power) * 10.0**power:.6g}")


def _bearings(mechanism: Mechanism, nut_end: float) -> list[float]:
    """Places of the bearings that hold the body that turns along the axis [mm]."""
    stage, axis = mechanism.stages[0], mechanism.axis
    shaft = None if axis is None else axis.shaft
    turning = stage.thread.family.turning
    support = getattr(stage, turning).support
    places: list[float] = []
    if support is not None and support.axial_stiffness is not None:
        places.append(0.0 if turning == "screw" else nut_end)
    if shaft is not None and shaft.far_bearing is not None:
        places.append(1e3 * float(shaft.far_bearing.distance))
    return places


def _bearing(axes: Axes, place: float, size: float) -> None:
    """A thrust bearing, on the housing below the centre line."""
    base = -0.45 * size
    line: dict[str, Any] = {"color": MUTED, "lw": 0.8}
    low, high = axes.get_xlim()
    half = 0.012 * (high - low)
    axes.plot((place, place - half, place + half, place), (0, base, base, 0), **line)
    axes.plot((place - 2 * half, place + 2 * half), (base, base), **line)


def _bars(axes: Axes, shares: dict[str, float]) -> None:
    shown = [pair for pair in shares.items() if pair[1] >= _LEAST][:_SPRINGS_SHOWN]
    for row, (_, share) in enumerate(shown):
        axes.barh(row, 100 * share, height=0.62, color="#9db8cf", edgecolor="none")
        axes.text(100 * share + 2, row, f"{100 * share:.1f} %", va="center", fontsize=SMALL)
    axes.set_yticks(range(len(shown)), [words for words, _ in shown])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(_SPRINGS_SHOWN - 0.4, -0.6)
    axes.set_xlim(0, 135)
    axes.set_xticks([])
    axes.spines["bottom"].set_visible(False)


def _legend(
    figure: Figure, height: float, parts: list[_Part], energy: float, turning: Side
) -> None:
    from matplotlib.patches import Patch

    names = dict.fromkeys(part.body for part in parts)
    tube = "thrust tube" if turning == "screw" else "joint at the load"
    labels = {"tube": tube, "motor": "motor (stator)"}
    handles: list[Any] = [
        Patch(
            facecolor=_COLOURS[name],
            edgecolor=MUTED,
            linewidth=0.5,
            label=labels.get(name, name),
        )
        for name in names
    ]
    handles.append(legend_line("at rest", color=MUTED, lw=0.8, ls=(0, (2, 1.5))))
    torsional = FAMILY_COLOURS["torsional"]
    handles.append(legend_line("turn, as travel θL/2π", color=torsional, lw=1.8, marker="^", ms=4))
    dense_legend(figure, handles, (0.5, 4.6 / height))
    words = (
        "Displacements are magnified as printed, relative to those at a mode energy of "
        f"{1e3 * energy:g} mJ. Radii are not to scale."
    )
    figure.text(0.5, 2.2 / height, words, fontsize=SMALL, color=MUTED, ha="center", va="center")
