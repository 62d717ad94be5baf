"""The axes of a sweep: checked, and split into traced and static axes."""

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..mechanism import Mechanism, check_independent, find_parameters, set_parameter


@dataclass(frozen=True)
class Axis:
    """One axis of the grid, in SI units."""

    name: str
    values: np.ndarray
    unit: str
    description: str
    #: Whether values are whole numbers that are part of the program (`roller_count`), not data.
    static: bool


@dataclass(frozen=True)
class Grid:
    """All axes in the given order."""

    axes: tuple[Axis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def points(self) -> int:
        return int(np.prod(self.shape))

    @property
    def traced(self) -> tuple[Axis, ...]:
        return tuple(axis for axis in self.axes if not axis.static)

    def combinations(
        self, mechanism: Mechanism
    ) -> Iterator[tuple[tuple[Any, ...], str, Mechanism]]:
        """For every combination of static values: its place in the grid, text and mechanism."""
        choices = [range(len(axis.values)) if axis.static else [None] for axis in self.axes]
        for choice in itertools.product(*choices):
            chosen, words = mechanism, []
            for axis, index in zip(self.axes, choice, strict=True):
                if index is not None:
                    chosen = set_parameter(chosen, axis.name, axis.values[index])
                    words.append(f"{axis.name} = {axis.values[index]}")
            where = tuple(slice(None) if index is None else index for index in choice)
            yield where, ", ".join(words), chosen


def grid_of(mechanism: Mechanism, axes: Mapping[str, Any], fixed: Mapping[str, object]) -> Grid:
    """Check the axes of a sweep.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `axes`: values [SI] by the name of a parameter.
    - `fixed`: `speed` and `load` given in addition to the axes, or `None`.

    **Raises:** `UnknownNameError` for an unknown name; `ValueError` for no axes, two axes that
    set the same number, and values that are empty, not one-dimensional, not finite, or not whole
    where they have to be.
    """
    if not axes:
        raise ValueError("axes is empty; give at least one, as {name: values}")
    check_independent(mechanism, axes)
    checked = []
    for name, values in axes.items():
        parameters = find_parameters(mechanism, name)
        parameter = parameters[0]
        _, _, field = parameter.path.partition("operating_point.")
        if fixed.get(field) is not None:
            raise ValueError(f"{field} is given and is also an axis of the sweep; remove one")
        checked.append(
            Axis(
                name,
                _values(name, values, parameter.static),
                parameter.unit,
                parameter.description,
                parameter.static,
            )
        )
    grid = Grid(tuple(checked))
    for _ in grid.combinations(mechanism):
        pass  # an invalid whole number raises an error before anything is computed
    return grid


def _values(name: str, values, static: bool) -> np.ndarray:
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"axis {name!r} is not a list of numbers: {error}") from error
    if array.ndim != 1:
        raise ValueError(
            f"axis {name!r} has the shape {array.shape}; give a one-dimensional list of values"
        )
    if array.size == 0:
        raise ValueError(f"axis {name!r} is empty; give at least one value")
    if not np.isfinite(array).all():
        raise ValueError(f"axis {name!r} holds {array[~np.isfinite(array)][0]}; remove it")
    if not static:
        return array
    if (array != np.round(array)).any():
        first = array[array != np.round(array)][0]
        raise ValueError(f"axis {name!r} holds {first:g}; it must hold whole numbers")
    return array.astype(np.int64)
