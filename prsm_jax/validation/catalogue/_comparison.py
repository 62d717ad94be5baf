"""Errors of the computed columns, by size and in summary."""

import dataclasses
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ...catalogue_sizes import catalogue_rows
from .._row import Row as ResultRow, half_unit, number
from ._predicted import PREDICTED, Row, mechanism_of, predicted, size_name

#: Diameters whose sizes the rules of `catalogue_mechanism` are fitted to: every second one [mm].
FITTED_DIAMETERS_MM = (8.0, 21.0, 30.0, 44.0, 56.0, 68.0, 92.0)


@dataclasses.dataclass(frozen=True)
class ErrorSummary:
    """Relative errors of one column over some sizes, without sign."""

    sizes: int
    median: float
    #: 90th percentile and largest error.
    percentile_90: float
    largest: float
    #: 90th percentile of the part that rounding of the printed number cannot explain.
    beyond_rounding_90: float


@dataclasses.dataclass(frozen=True)
class CatalogueComparison:
    """Printed and computed numbers of some sizes, in the units that their names end with."""

    rows: tuple[Row, ...]
    #: By column and size; NaN where nothing above 0 is printed.
    printed: dict[str, Float[np.ndarray, " sizes"]]
    computed: dict[str, Float[np.ndarray, " sizes"]]
    #: Half a unit of the last printed digit, by column.
    half_units: dict[str, float]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the sizes."""
        return tuple(map(size_name, self.rows))

    @property
    def predicted_half(self) -> Bool[np.ndarray, " sizes"]:
        """Sizes of diameters that the rules were not fitted to."""
        return ~np.isin([row["nominal_diameter_mm"] for row in self.rows], FITTED_DIAMETERS_MM)

    def errors(self, column: str) -> Float[np.ndarray, " sizes"]:
        """Relative errors of a column: computed over printed, less 1.

        **Arguments:**

        - `column`: its name.
        """
        return self.computed[column] / self.printed[column] - 1

    def summary(
        self, column: str, where: Bool[np.ndarray, " sizes"] | None = None
    ) -> ErrorSummary | None:
        """Errors of a column over its printed sizes, without sign; `None` if none is printed.

        **Arguments:**

        - `column`: its name.
        - `where`: the sizes that count; default all.
        """
        counts = np.isfinite(self.printed[column])
        if where is not None:
            counts = counts & where
        if not counts.any():
            return None
        printed, computed = self.printed[column][counts], self.computed[column][counts]
        size = np.abs(computed / printed - 1)
        beyond = np.maximum(np.abs(computed - printed) - self.half_units[column], 0) / printed
        return ErrorSummary(
            int(counts.sum()),
            float(np.median(size)),
            float(np.percentile(size, 90)),
            float(size.max()),
            float(np.percentile(beyond, 90)),
        )

    def to_dict(self) -> dict[str, Any]:
        """Summaries by column, and all sizes, as JSON types; errors are relative."""
        columns = [name for name in PREDICTED if self.summary(name) is not None]
        return {
            "columns": {name: self._column(name) for name in columns},
            "sizes": [
                {name: row[name] for name in ("nominal_diameter_mm", "lead_mm", "starts")}
                | {
                    name: {
                        "printed": float(self.printed[name][index]),
                        "computed": float(self.computed[name][index]),
                        "error": float(self.errors(name)[index]),
                    }
                    for name in columns
                    if np.isfinite(self.printed[name][index])
                }
                for index, row in enumerate(self.rows)
            ],
        }

    def rows_of_numbers(self) -> tuple[ResultRow, ...]:
        """One row for each printed number; reproduced if its error is within the goal.

        The goal is 20 % for capacities and 10 % else, and half a unit of the printed digits.
        """
        return tuple(
            dataclasses.replace(
                number(
                    f"{size}: {column.name}",
                    f"{self.printed[name][index]:.12g}",
                    self.computed[name][index],
                    column.unit,
                    tolerance=self.half_units[name] + column.goal * self.printed[name][index],
                    note=f"within {100 * column.goal:g} % and rounding",
                ),
                source="catalogue",
            )
            for index, size in enumerate(self.names)
            for name, column in PREDICTED.items()
            if np.isfinite(self.printed[name][index])
        )

    def _column(self, name: str) -> dict[str, Any]:
        halves = {"all": None, "predicted_half": self.predicted_half}
        found = {half: self.summary(name, where) for half, where in halves.items()}
        return {half: one and dataclasses.asdict(one) for half, one in found.items()}


def _compared(rows: Sequence[Row]) -> CatalogueComparison:
    given = {
        name: np.array([row.get(name, np.nan) for row in rows], dtype=float) for name in PREDICTED
    }
    printed = {name: np.where(values > 0, values, np.nan) for name, values in given.items()}
    half_units = {
        name: min(half_unit(f"{x:.12g}") for x in [*values[np.isfinite(values)], 0.0])
        for name, values in printed.items()
    }
    return CatalogueComparison(
        tuple(rows), printed, predicted([mechanism_of(row) for row in rows]), half_units
    )


@functools.cache
def _shipped() -> CatalogueComparison:
    return _compared(catalogue_rows())


def compare_catalogue(path: str | Path | None = None) -> CatalogueComparison:
    """A maker's printed numbers beside those of the mechanisms that rules build from dimensions.

    **Arguments:**

    - `path`: a CSV file as `prsm_jax.catalogue_sizes.catalogue_rows` reads it; default: the 90
      shipped sizes.

    **Raises:** `FileError` for a file that cannot be read, and for a size whose dimensions do not
    make a screw.
    """
    return _shipped() if path is None else _compared(catalogue_rows(path))
