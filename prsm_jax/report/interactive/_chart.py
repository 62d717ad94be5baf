"""A chart as data: curves in display units over a common axis, in one panel or several."""

import dataclasses
from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import numpy as np

from ...text import DisplayUnit, display_unit

Values: TypeAlias = np.ndarray | Sequence[float | int]
#: Significant digits of the numbers of a page; its errors are far below those of any result.
_DIGITS = 9


@dataclasses.dataclass(frozen=True)
class Axis:
    """An axis: what it shows, its unit as printed (empty for none), and whether it is logarithmic.

    `words` name the places of an axis without numbers.
    """

    name: str
    unit: str = ""
    log: bool = False
    words: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """Name and unit: "time in ms"."""
        return f"{self.name} in {self.unit}" if self.unit else self.name


@dataclasses.dataclass(frozen=True)
class Curve:
    """Numbers over numbers, in the units of the axes; NaN is a gap.

    - `panel`: which panel it is in, from 0.
    - `kind`: a line through the points, or a bar at each.
    """

    name: str
    x: Values
    y: Values
    panel: int = 0
    kind: Literal["line", "bar"] = "line"


@dataclasses.dataclass(frozen=True)
class Chart:
    """Curves over one axis, in panels one above the other."""

    x: Axis
    panels: tuple[Axis, ...]
    curves: tuple[Curve, ...]
    #: Bars of several curves stand on each other.
    stacked: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Everything as JSON types; a gap is `None`."""
        return {
            "x": dataclasses.asdict(self.x),
            "panels": [dataclasses.asdict(one) for one in self.panels],
            "curves": [
                {
                    "name": one.name,
                    "panel": one.panel,
                    "kind": one.kind,
                    "x": numbers(one.x),
                    "y": numbers(one.y),
                }
                for one in self.curves
            ],
        }


def numbers(values: Values) -> list[float | None]:
    """Numbers for JSON, to nine digits; what is not finite is `None`."""
    return [
        float(f"{float(one):.{_DIGITS}g}") if np.isfinite(one) else None
        for one in np.asarray(values, dtype=float)
    ]


def axis_of(name: str, values: Any, unit: str, *, log: bool = False) -> tuple[Axis, DisplayUnit]:
    """An axis for SI numbers, and the unit that converts them.

    **Arguments:**

    - `name`: what it shows.
    - `values`: all numbers that it is to show.
    - `unit`: their SI unit.
    - `log`: whether it is logarithmic.
    """
    finite = np.asarray(values, dtype=float).ravel()
    finite = finite[np.isfinite(finite)]
    shown = display_unit(unit, [float(np.abs(finite).max())] if finite.size else [1.0])
    return Axis(name, shown.label, log), shown
