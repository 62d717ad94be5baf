"""Planes of two drivers through the map of a study."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...studies import DriverStudy
from ...text import DisplayUnit, display_unit, in_unit
from .._parts import in_words
from .._style import ACTIVE, INK, Axes, readable


@dataclass(frozen=True)
class Plane:
    """Two drivers of a study; all others have the value of the map nearest to the present one."""

    study: DriverStudy
    x: str
    y: str

    def cut(self, values: np.ndarray) -> np.ndarray:
        """Values over the map in this plane, rows along y."""
        place: list[Any] = []
        for one in self.study.problem.drivers:
            along = self.study.map.coordinates[one.name]
            nearest = int(np.abs(along - one.present).argmin())
            place.append(slice(None) if one.name in (self.x, self.y) else nearest)
        names = [one.name for one in self.study.problem.drivers]
        plane = values[tuple(place)]
        return plane.T if names.index(self.x) < names.index(self.y) else plane

    def coordinates(self, name: str) -> tuple[np.ndarray, DisplayUnit]:
        """Values of a driver in its display unit."""
        along = self.study.map.coordinates[name]
        unit = display_unit(self._driver(name).unit, map(float, along))
        return unit(along), unit

    def _driver(self, name: str):
        return next(one for one in self.study.problem.drivers if one.name == name)

    @property
    def others(self) -> str:
        """Values of the other drivers in words."""
        words = []
        for one in self.study.problem.drivers:
            if one.name not in (self.x, self.y):
                along = self.study.map.coordinates[one.name]
                value = float(along[np.abs(along - one.present).argmin()])
                words.append(
                    f"{readable(one.name)} {in_unit(value, self.coordinates(one.name)[1])}"
                )
        return ", ".join(words)

    def dress(self, axes: Axes) -> None:
        """Label the axes, mark designs that fail or are not allowed, the front, the present design.

        Points of the front have other values of the other drivers.
        """
        (xs, x_unit), (ys, y_unit) = self.coordinates(self.x), self.coordinates(self.y)
        axes.set_xlabel(in_words(readable(self.x), x_unit))
        axes.set_ylabel(in_words(readable(self.y), y_unit))
        grid = self.study.map
        failed = np.argwhere(~self.cut(grid.usable))
        if failed.size:
            number = f"{int(np.sum(~grid.usable))} of {grid.usable.size} designs of the map"
            axes.plot(
                xs[failed[:, 1]], ys[failed[:, 0]], ls="", marker="x", ms=3.5, color=INK,
                clip_on=False, label=f"failed: {number}",
            )  # fmt: skip
        refused = np.argwhere(~self.cut(grid.allowed) & self.cut(grid.usable))
        # Without a point, an unclipped marker lies at the corner of the figure for the layout.
        if refused.size:
            axes.plot(
                xs[refused[:, 1]], ys[refused[:, 0]], ls="", marker=".", ms=2.5, color=INK,
                clip_on=False, label="breaks a limit, or error of prsm check",
            )  # fmt: skip
        front = self.study.front.points
        if front:
            axes.plot(
                *(
                    unit(np.array([one.variables[name] for one in front]))
                    for name, unit in ((self.x, x_unit), (self.y, y_unit))
                ),
                color=ACTIVE, lw=0.8, marker="o", ms=2.5, clip_on=False, label="front, projected",
            )  # fmt: skip
        present = [
            unit(self._driver(name).present) for name, unit in ((self.x, x_unit), (self.y, y_unit))
        ]
        inside = xs[0] <= present[0] <= xs[-1] and ys[0] <= present[1] <= ys[-1]
        if inside:
            axes.plot(
                [present[0]], [present[1]], ls="", marker="s", ms=5.0, mfc="white", mec=INK,
                label="present design",
            )  # fmt: skip


def planes_of(study: DriverStudy) -> tuple[Plane, ...]:
    """Planes of every two of the first three drivers.

    **Raises:** `ValueError` for a study of one driver.
    """
    names = [one.name for one in study.problem.drivers][:3]
    if len(names) < 2:
        raise ValueError(
            f"the study has one driver ({names[0]}); a map needs two, and report.sweep_figure "
            "draws the sweep in its store"
        )
    return tuple(Plane(study, x, y) for x, y in itertools.combinations(names, 2))


def handles_of(panels: Any) -> list[Any]:
    """Entries of a legend, each once, of several panels."""
    by_label: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            by_label.setdefault(label, handle)
    return list(by_label.values())
