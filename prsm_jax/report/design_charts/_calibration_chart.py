"""Measured against computed values of a calibration, and their residuals."""

from typing import Any

import numpy as np

from ...calibration import Calibration, Residuals
from ...text import DisplayUnit, display_unit
from .._style import INK, MUTED, SERIES, Axes, Figure, drawn, page_figure, readable

_ROW = 62.0


@drawn
def calibration_chart(calibration: Calibration) -> Figure:
    """Draw each measured quantity against the computed one, and the residuals beside it.

    On the dashed line both are equal. The dotted lines are two root mean squares from 0: of normal
    residuals about 95 % lie between them. A residual that follows the computed value shows an
    effect that the model lacks.

    **Arguments:**

    - `calibration`: result of `calibrate`.

    **Returns:** a matplotlib figure, with a row for each quantity.

    **Raises:** `ValueError` after a failed fit; `MissingExtraError` without matplotlib.
    """
    if not calibration.residuals:
        raise ValueError(f"the fit failed, so there is nothing to draw: {calibration.message}")
    count = len(calibration.residuals)
    figure = page_figure(_ROW * count + 6)
    grid: Any = figure.subplots(count, 2, squeeze=False)
    for (left, right), one in zip(grid, calibration.residuals, strict=True):
        shown = display_unit(one.unit, np.abs(one.measured), one.quantity)
        _values(left, one, shown)
        _residuals(right, one, shown)
    return figure


def _label(words: str, unit: DisplayUnit) -> str:
    return f"{words} in {unit.label}" if unit.label else words


def _values(axes: Axes, one: Residuals, shown: DisplayUnit) -> None:
    measured, computed = shown(one.measured), shown(one.computed)
    ends = [min(measured.min(), computed.min()), max(measured.max(), computed.max())]
    axes.plot(ends, ends, color=MUTED, linestyle="--", linewidth=0.8)
    axes.plot(computed, measured, "o", color=SERIES[0], markersize=3.5)
    name = readable(one.quantity)
    axes.set_xlabel(_label(f"computed {name}", shown))
    axes.set_ylabel(_label(f"measured {name}", shown))
    axes.set_title(name.capitalize())
    axes.grid(True)


def _residuals(axes: Axes, one: Residuals, shown: DisplayUnit) -> None:
    computed = shown(one.computed)
    small = display_unit(one.unit, np.abs(one.residuals), one.quantity)
    axes.axhline(0, color=INK, linewidth=0.6)
    for sign in (-2, 2):
        axes.axhline(sign * small(one.rms), color=MUTED, linestyle=":", linewidth=0.8)
    axes.plot(computed, small(one.residuals), "o", color=SERIES[3], markersize=3.5)
    axes.set_xlabel(_label(f"computed {readable(one.quantity)}", shown))
    axes.set_ylabel(_label("measured minus computed", small))
    axes.set_title("Residuals (dotted: ± 2 r.m.s.)")
    axes.grid(True)
