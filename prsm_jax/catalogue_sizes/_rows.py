"""Tables of a maker's sizes: the 90 planetary roller screws of 8 to 120 mm, or other files."""

import functools
import math
from pathlib import Path

from .._errors import FileError, closest
from ..text import comma_in_number, csv_cells

_LARGEST_FILE = 20_000_000
_TABLE = Path(__file__).parent / "data" / "roller_screws.csv"
#: Columns that are arguments of their own, in other units.
SIZE = ("nominal_diameter_mm", "lead_mm", "starts")
#: Columns that are dimensions of the parts; crest and root are printed for some sizes only.
DIMENSIONS = (
    "crest_diameter_mm",
    "root_diameter_mm",
    "nut_outer_diameter_mm",
    "nut_length_mm",
    "roller_circle_diameter_mm",
)
#: Columns without which a size of a file cannot be compared.
_NEEDED = (*SIZE, "nut_outer_diameter_mm", "nut_length_mm")
#: Columns that are results of a mechanism, and cannot be given.
CAPACITIES = ("dynamic_capacity_kn", "static_capacity_kn")


def _table(path: Path) -> tuple[tuple[str, ...], list[tuple[int, list[str]]]]:
    """Names of the columns, and the cells below them with the numbers of their lines."""
    rows = csv_cells(path.read_text(encoding="utf-8-sig"))
    cells = [(number, [cell.strip() for cell in row]) for number, row in rows]
    return (tuple(cells[0][1]), cells[1:]) if cells else ((), [])


@functools.cache
def all_columns() -> tuple[str, ...]:
    """All columns of the table, in its order."""
    return _table(_TABLE)[0]


def columns() -> tuple[str, ...]:
    """Columns that `catalogue_mechanism` takes, beside the size."""
    return tuple(name for name in all_columns() if name not in (*SIZE, *CAPACITIES))


def _check_header(path: Path, found: tuple[str, ...]) -> None:
    known = all_columns()
    for name in found:
        if name not in known:
            raise FileError(
                f"{path}: unknown column {name!r}; {closest(name, known)} (a name ends with its "
                "unit, and other units are not converted)"
            )
        if found.count(name) > 1:
            raise FileError(f"{path}: the column {name} is there {found.count(name)} times")
    if missing := [name for name in _NEEDED if name not in found]:
        raise FileError(
            f"{path}: the header lacks {', '.join(missing)}; a size needs {', '.join(_NEEDED)}"
        )
    if not set(found) - {*SIZE, *DIMENSIONS}:
        raise FileError(
            f"{path}: nothing to compare with; give a printed result, for example "
            "static_capacity_kn"
        )


def _number(path: Path, line: int, name: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        words = comma_in_number(cell) or "give a finite number"
        raise FileError(f"{path}, line {line}: {name} is {cell!r}; {words}")
    return value


def _check_size(path: Path) -> None:
    """A pipe or device would have no end."""
    if path.exists() and not path.is_file():
        raise FileError(f"{path}: is not a file; give a CSV file")
    if path.stat().st_size > _LARGEST_FILE:
        raise FileError(f"{path}: is larger than {_LARGEST_FILE} bytes; give fewer rows")


def catalogue_rows(path: str | Path | None = None) -> tuple[dict[str, float], ...]:
    """All sizes, by column, in the units that the names of the columns end with.

    A cell that the maker leaves empty is absent. `nut_mass_kg` includes the rollers, and shafts
    are printed per metre.

    **Arguments:**

    - `path`: a CSV file with columns of the shipped table under the same names, separated by commas
      or semicolons; lines that begin with `#` are comments. It needs the size and the diameter and
      length of the nut, and at least one printed result. Default: the table.

    **Raises:** `FileError` for a file that cannot be read or has no rows, for an unknown, missing
    or repeated column, a line with more or fewer cells than the header, and for a cell that is not
    a number or may not be empty.
    """
    path = _TABLE if path is None else Path(path)
    try:
        _check_size(path)
        names, lines = _table(path)
    except FileError:
        raise
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"{path}: cannot be read as a CSV file: {error}") from error
    except ValueError as error:
        raise FileError(f"{path}: {error}") from error
    _check_header(path, names)
    if not lines:
        raise FileError(f"{path}: there is a header, but no size below it")
    rows: list[dict[str, float]] = []
    for number, cells in lines:
        if len(cells) != len(names):
            raise FileError(
                f"{path}, line {number}: {len(cells)} cells, but the header has {len(names)}"
            )
        row = {
            name: _number(path, number, name, cell)
            for name, cell in zip(names, cells, strict=True)
            if cell
        }
        if empty := [name for name in _NEEDED if name not in row]:
            raise FileError(f"{path}, line {number}: {', '.join(empty)} may not be empty")
        rows.append(row)
    return tuple(rows)
