"""The table of a maker's sizes: 90 planetary roller screws of 8 to 120 mm."""

import csv
from pathlib import Path

_TABLE = Path(__file__).parent / "data" / "roller_screws.csv"
#: Columns that are arguments of their own, in other units.
SIZE = ("nominal_diameter_mm", "lead_mm", "starts")
#: Columns that are results of a mechanism, and cannot be given.
CAPACITIES = ("dynamic_capacity_kn", "static_capacity_kn")


def catalogue_rows() -> tuple[dict[str, float], ...]:
    """All sizes, by column, in the units that the names of the columns end with.

    A cell that the maker leaves empty is absent. `nut_mass_kg` includes the rollers, and shafts
    are printed per metre.
    """
    with _TABLE.open(encoding="utf-8", newline="") as file:
        return tuple(
            {name: float(cell) for name, cell in row.items() if cell}
            for row in csv.DictReader(file)
        )


def columns() -> tuple[str, ...]:
    """Columns that `catalogue_mechanism` takes, beside the size."""
    with _TABLE.open(encoding="utf-8", newline="") as file:
        names = next(csv.reader(file))
    return tuple(name for name in names if name not in (*SIZE, *CAPACITIES))
