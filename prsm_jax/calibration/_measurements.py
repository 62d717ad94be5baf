"""Measured values of quantities, and the conditions under which they were measured."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from .._errors import UnknownNameError
from ..fields import refuse_complex
from ..quantities import catalogue, find_quantity

#: Quantities that are an output over an input.
_EFFICIENCIES = ("efficiency", "efficiency_forward", "efficiency_backward", "duty_efficiency")
#: Scatter of a measured efficiency beyond 0 and 1; what is farther away is another unit.
_SCATTER = 0.1
_COMPONENT = re.compile(r"(\w+)\[(\d+)\]")


def split_component(name: str) -> tuple[str, int | None]:
    """Name of a quantity, and the number of its component (from 1) if `name[2]` gives one."""
    match = _COMPONENT.fullmatch(name)
    return (name, None) if match is None else (match[1], int(match[2]))


def is_quantity(name: str) -> bool:
    """Whether a name is that of a quantity or of its component; a dotted name is a parameter."""
    return split_component(name)[0] in {one.name for one in catalogue()}


def impossible(name: str, values: ArrayLike | float) -> np.ndarray:
    """Which values of a quantity [SI] cannot have been measured: efficiencies lie from 0 to 1.

    Scatter about either is possible, and so is NaN, for what was not measured.
    """
    numbers = np.asarray(values, float)
    ratio = split_component(name)[0] in _EFFICIENCIES
    return np.asarray(ratio & ((numbers < -_SCATTER) | (numbers > 1 + _SCATTER)))


@dataclass(frozen=True)
class Measurements:
    """A table of measurements [SI]: one row per measured point.

    - `values`: measured values by quantity of the catalogue, a number per row, NaN where it was
      not measured. A component of a quantity is named `natural_frequencies[2]`. Without a number,
      each row of a quantity with several components (frequencies) holds one measured component,
      which is paired with a computed one so that the sum of |ln(measured/computed)| of the row is
      least.
    - `conditions`: numbers of the mechanism during the measurement, by the name of a parameter
      (`operating_point.load`), a number per row. All other numbers are those of the mechanism.

    **Raises:** `ValueError` for columns of different lengths, without a value, with a number that
    is not finite, or with an efficiency that is not from 0 to 1; `UnknownNameError` for an unknown
    quantity.
    """

    values: Mapping[str, ArrayLike]
    conditions: Mapping[str, ArrayLike] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.values:
            raise ValueError("the data have no measured quantity; name a column as one of them")
        for name in self.values:
            find_quantity(split_component(name)[0])
        for name, column in {**self.values, **self.conditions}.items():
            refuse_complex(f"column {name!r}", column)
        columns = {
            kind: {name: np.array(column, float) for name, column in mapping.items()}
            for kind, mapping in (("values", self.values), ("conditions", self.conditions))
        }
        everything = columns["values"] | columns["conditions"]
        first, rows = next((name, column.shape) for name, column in everything.items())
        for name, column in everything.items():
            if column.ndim != 1 or column.shape != rows:
                raise ValueError(
                    f"column {name!r} has the shape {column.shape} and {first!r} {rows}; give one "
                    "number per row"
                )
        for name, column in columns["conditions"].items():
            if not np.isfinite(column).all():
                row = int(np.argmin(np.isfinite(column))) + 1
                raise ValueError(
                    f"condition {name!r} is {column[row - 1]} in row {row}; it must be finite"
                )
        for name, column in columns["values"].items():
            if np.isinf(column).any() or np.isnan(column).all():
                raise ValueError(
                    f"measured {name!r} is infinite, or NaN in all rows; give finite numbers, and "
                    "NaN where nothing was measured"
                )
            wrong = impossible(name, column)
            if wrong.any():
                row = int(np.argmax(wrong))
                raise ValueError(
                    f"measured {name!r} is {column[row]:g} in row {row + 1}; an efficiency is a "
                    "number from 0 to 1"
                )
        for kind, mapping in columns.items():
            object.__setattr__(self, kind, mapping)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.values.values())))  # type: ignore[arg-type]

    @classmethod
    def from_columns(cls, columns: Mapping[str, ArrayLike]) -> "Measurements":
        """Measurements from columns [SI]: names of quantities are values, all others conditions."""
        values = {name: column for name, column in columns.items() if is_quantity(name)}
        return cls(values, {name: columns[name] for name in columns if name not in values})


def check_conditions(data: Measurements, parameters: tuple[str, ...]) -> None:
    """**Raises:** `UnknownNameError` if a condition is fitted at the same time."""
    both = [name for name in data.conditions if name in parameters]
    if both:
        raise UnknownNameError(
            f"{both[0]!r} is a condition of the data and a fitted parameter; keep one of them"
        )
