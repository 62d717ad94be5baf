"""Quantities and their gradients at designs: over a grid of the drivers, or in a list."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..mechanism import Constraint, Mechanism
from ..optimisation import LIMIT_ROOM, limit_scale
from ..quantities import find_quantity
from ..sweeps import block_size, count_codes, sweep
from ._problem import StudyProblem, check_single

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class DriverMap:
    """Quantities and elasticities at designs.

    The designs are a grid with one axis for each driver, or a list with one axis. Designs that fail
    are NaN.

    - `coordinates`: values of each driver [SI]: along its axis of a grid, or of each design.
    - `values`: by quantity, over the designs.
    - `elasticities`: by quantity, over the designs and then the drivers: per cent of the quantity
      per per cent of the driver. NaN for a quantity that is 0.
    - `usable`: false where a design fails.
    - `error`: true where `check` finds an error.
    - `violations`: largest violation of each limit, relative to the larger of a lower and an upper
      one (for 0: to 1 mm, or 1 of another SI unit), by quantity; NaN where a design fails.
    - `reasons`: why designs fail, with the number of each, the most frequent first.
    """

    coordinates: dict[str, np.ndarray]
    values: dict[str, np.ndarray]
    elasticities: dict[str, np.ndarray]
    usable: np.ndarray
    error: np.ndarray
    violations: dict[str, np.ndarray]
    reasons: dict[str, int] = field(default_factory=dict)

    @property
    def allowed(self) -> np.ndarray:
        """Where a design satisfies all limits, as `limit_readings` judges, and has no error."""
        return self.within(LIMIT_ROOM)

    def within(self, tolerance: float) -> np.ndarray:
        """Where a design satisfies all limits up to a relative tolerance, and has no error."""
        allowed = self.usable & ~self.error
        for violation in self.violations.values():
            allowed = allowed & (np.nan_to_num(violation, nan=np.inf) <= tolerance)
        return allowed

    def design(self, index: tuple[int, ...]) -> dict[str, float]:
        """The drivers of a design [SI], by its place."""
        places = index if self.usable.ndim > 1 else index * len(self.coordinates)
        pairs = zip(self.coordinates.items(), places, strict=True)
        return {name: float(values[place]) for (name, values), place in pairs}


def map_over_drivers(
    mechanism: Mechanism,
    problem: StudyProblem,
    points: int,
    store: str | os.PathLike[str] | None,
    progress: Callable[[int, int], None] | bool,
) -> tuple[DriverMap, "xarray.Dataset"]:
    """The map over a grid with as many values of every driver, and its data set.

    **Arguments:**

    - `mechanism`, `problem`: mechanism and problem of the study.
    - `points`: number of values of every driver.
    - `store`: directory of a zarr store, which a later call continues; `None`: in memory.
    - `progress`: of `sweep`.
    """
    axes = {one.name: np.linspace(one.lower, one.upper, points) for one in problem.drivers}
    data = sweep(
        mechanism,
        axes,
        problem.computed,
        gradients=list(axes),
        hold_axes=True,
        store=store,
        progress=progress,
    )
    return _read(problem, data), data


def at_designs(
    mechanism: Mechanism,
    problem: StudyProblem,
    designs: Sequence[Mapping[str, float]],
    quantities: Sequence[str],
    grid: int | None = None,
) -> DriverMap:
    """The map at a list of designs.

    **Arguments:**

    - `mechanism`, `problem`: mechanism and problem of the study.
    - `designs`: drivers [SI], by name.
    - `quantities`: those that the mechanism has data for.
    - `grid`: number of designs of a map of the same mechanism and quantities; the list then uses
      the program of this map. Without it errors of `check` are not looked for, so that less is
      compiled.
    """
    axes = {one.name: [design[one.name] for design in designs] for one in problem.drivers}
    size = len(designs) if grid is None else min(grid, block_size(grid))
    data = sweep(
        mechanism,
        axes,
        quantities,
        plan="list",
        gradients=list(axes),
        hold_axes=True,
        chunk=size,
        findings=grid is not None,
    )
    return _read(problem, data)


def _read(problem: StudyProblem, data: "xarray.Dataset") -> DriverMap:
    drivers = [one.name for one in problem.drivers]
    dimensions = data["failed"].dims
    coordinates = {name: np.asarray(data[name].values, float) for name in drivers}
    names = [name for name in problem.names if name in data]
    values: dict[str, np.ndarray] = {}
    elasticities: dict[str, np.ndarray] = {}
    for name in names:
        check_single(name, data[name].dims[len(dimensions) :])
        value = values[name] = np.asarray(data[name].values, float)
        # 0 has no relative change.
        divisor = np.where(value == 0, np.nan, value)
        elasticities[name] = np.stack(
            [
                np.asarray((data[f"{name}_by_{by}"] * data[by]).transpose(*dimensions).values)
                / divisor
                for by in drivers
            ],
            axis=-1,
        )
    usable = ~np.asarray(data["failed"].values, bool)
    violations: dict[str, np.ndarray] = {}
    for one in problem.limits:
        if one.quantity in data:
            excess = _violation(one, np.asarray(data[one.quantity].values, float), usable)
            before = violations.get(one.quantity)
            violations[one.quantity] = excess if before is None else np.maximum(before, excess)
    error = np.asarray(data["error"].values) > 0
    counts = count_codes(data).reasons
    reasons = dict(sorted(counts.items(), key=lambda one: -one[1]))
    return DriverMap(coordinates, values, elasticities, usable, error, violations, reasons)


def _violation(limit: Constraint, value: np.ndarray, usable: np.ndarray) -> np.ndarray:
    """Largest violation over the components of a quantity, relative to the scale of the limit."""
    sides: list[tuple[float | None, float]] = [(limit.lower, -1.0), (limit.upper, 1.0)]
    if limit.equal is not None:
        sides = [(limit.equal, -1.0), (limit.equal, 1.0)]
    scale = limit_scale(limit, find_quantity(limit.quantity).unit)
    beyond: Any = np.zeros_like(value)
    for bound, sign in sides:
        if bound is not None and np.isfinite(bound):
            beyond = np.maximum(beyond, sign * (value - bound) / scale)
    parts = tuple(range(usable.ndim, value.ndim))
    return np.max(beyond, axis=parts) if parts else beyond
