"""Dynamic compliance of an axis: at nut and load, and at the motor."""

from typing import Any

import numpy as np

from ...mechanism import Side
from ...response import AxisCompliance
from ...vibration import SpatialModes
from .._parts import DASHES, legend_line, plain_ticks
from .._style import FAMILY_COLOURS, INK, SERIES, Figure, drawn, page_figure

#: Micrometres per kilonewton for a metre per newton.
_MICROMETRES_PER_KILONEWTON = 1e9


@drawn
def axis_compliance_chart(
    compliance: AxisCompliance,
    modes: SpatialModes | None = None,
    held: SpatialModes | None = None,
    *,
    turning: Side = "screw",
) -> Figure:
    """Draw the dynamic compliance at nut and load, and at the motor, over the frequency.

    Magnitudes of displacement per force at the same place, and of angle per torque at the motor,
    on logarithmic scales. Infinite values, at the poles of an undamped axis, leave gaps.

    **Arguments:**

    - `compliance`: from `prsm_jax.response.axis_compliance`.
    - `modes`: natural frequencies to mark, by family.
    - `held`: modes with the motor held; their frequencies are marked as anti-resonances.
    - `turning`: the body that turns; the other one moves along the axis.

    **Returns:** a matplotlib figure; frequencies in Hz, compliances in µm/kN and rad/(N·m).

    **Raises:** `MissingExtraError` without matplotlib.
    """
    sizes = {name: np.array(one) for name, one in compliance.magnitudes.items()}
    moving = "nut" if turning == "screw" else "screw"
    labels = {"nut": f"at the {moving}", "load": "at the load"}
    panels = [("nut", "load")] + ([("motor",)] if "motor" in sizes else [])
    figure = page_figure(22 + 52 * len(panels))
    every = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    hertz = np.asarray(compliance.frequency)
    for axes, names in zip(every, panels, strict=True):
        factor = 1.0 if names == ("motor",) else _MICROMETRES_PER_KILONEWTON
        for index, name in enumerate(names):
            if name in sizes:
                size = np.where(np.isfinite(sizes[name]), factor * sizes[name], np.nan)
                style: dict[str, Any] = {"color": SERIES[index], "ls": DASHES[index], "lw": 1.2}
                axes.loglog(hertz, size, label=labels.get(name), zorder=3, **style)
        axes.grid(which="major")
    every[0].set_ylabel("compliance in µm/kN")
    if len(sizes) > 1 and "load" in sizes:
        inside = every[0].legend(loc="lower left", frameon=True, framealpha=0.9)
        inside.get_frame().set_edgecolor("none")
        every[0].add_artist(inside)
    if len(panels) > 1:
        every[1].set_ylabel("compliance at the motor in rad/(N·m)")
    every[-1].set_xlabel("frequency in Hz")
    every[-1].set_xlim(hertz.min(), hertz.max())
    plain_ticks(every[-1].xaxis, subs=(1.0,))
    every[0].set_title("Dynamic compliance of the axis")
    handles = _mark(every, modes, held if len(panels) > 1 else None)
    if handles:
        every[0].legend(
            handles=handles,
            loc="lower right",
            bbox_to_anchor=(1, 1.0),
            ncols=len(handles),
            handlelength=1.8,
            columnspacing=1.2,
        )
    return figure


def _mark(every: Any, modes: SpatialModes | None, held: SpatialModes | None) -> list[Any]:
    """Resonances as lines across all panels, anti-resonances in the motor's; handles."""
    low, high = every[0].get_xlim()
    shown: dict[str, Any] = {}
    for value, family in _of_axis(modes):
        if low <= value <= high:
            style = {"color": FAMILY_COLOURS[family], "lw": 0.8, "alpha": 0.7}
            shown[family] = legend_line(family, **style)
            for axes in every:
                axes.axvline(value, zorder=1, **style)
    for value, _ in _of_axis(held):
        if low <= value <= high:
            style = {"color": INK, "lw": 0.8, "ls": (0, (1, 1.5))}
            shown["held"] = legend_line("motor held (anti-resonance)", **style)
            every[-1].axvline(value, zorder=1, **style)
    return list(shown.values())


def _of_axis(modes: SpatialModes | None) -> list[tuple[float, str]]:
    """Frequency and family of the modes that a force along the axis, or a torque, excites."""
    if modes is None:
        return []
    pairs = zip(modes.frequencies.tolist(), modes.families, strict=True)
    return [(value, family) for value, family in pairs if family in ("axial", "torsional")]
