"""CSV tables of numbers with units: header cells `name [unit]`, and one number in each cell."""

import re
from pathlib import Path
from typing import NamedTuple

from ..._errors import FileError
from ...fields import ANY, Limit
from ...text import comma_in_number, csv_cells
from ._messages import one_line, utf8_text
from ._numbers import read_number

_LARGEST_FILE = 20_000_000
_HEADER = re.compile(r"\s*([\w.]+(?:\[\d+\])?)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")


class CsvColumn(NamedTuple):
    """A column: its name, its unit as written, its SI unit, and the limit of its numbers."""

    name: str
    unit: str
    si: str
    limit: Limit


def csv_rows(path: Path, name: str) -> list[tuple[int, list[str]]]:
    """Cells of a CSV file, the header first, each row with the number of its line.

    The cells are those of `csv_cells`.

    **Arguments:**

    - `path`: the file.
    - `name`: what messages call it.

    **Raises:** `FileError` if it cannot be read, is no table of at least two rows, or has rows of
    different lengths.
    """
    try:
        if path.stat().st_size > _LARGEST_FILE:
            raise FileError(f"{name}: is larger than {_LARGEST_FILE} bytes; give fewer rows")
        text = utf8_text(path.read_bytes(), name)
    except FileError:
        raise
    except (OSError, ValueError) as error:
        raise FileError(f"{name}: cannot be read: {error}") from error
    try:
        cells = csv_cells(text)
    except ValueError as error:
        raise FileError(f"{name}: {error}") from error
    if len(cells) < 2:
        raise FileError(f"{name}: needs a header line `name [unit],…` and a row of numbers")
    columns = len(cells[0][1])
    for number, row in cells:
        if len(row) != columns:
            raise FileError(
                f"{name}: row {number} has {len(row)} cells and the header {columns}; give one "
                "number per column, with decimal points"
            )
    return cells


def csv_heading(cell: str, place: str, example: str) -> tuple[str, str | None]:
    """Name and unit of a header cell; no unit if none is written.

    **Arguments:**

    - `cell`: the cell.
    - `place`: where it stands, for messages.
    - `example`: a heading that would be right.

    **Raises:** `FileError` for a cell of another form.
    """
    match = _HEADER.fullmatch(cell)
    if match is None:
        shown = one_line(cell, 80)
        raise FileError(f"{place}, column {shown!r}: must be `name [unit]`, such as `{example}`")
    return match[1], match[2]


def csv_column(name: str, unit: str | None, si: str, limit: Limit, place: str) -> CsvColumn:
    """A column with a unit that fits.

    **Arguments:**

    - `name`, `unit`: of its heading.
    - `si`, `limit`: SI unit and limit of what the name stands for.
    - `place`: where the heading stands, for messages.

    **Raises:** `FileError` without a unit where one is needed, and for one of another kind.
    """
    if unit is None or unit in ("", "-", "1"):
        if si != "1":
            raise FileError(
                f"{place}, column {name}: has no unit; write `{name} [{si.replace('·', ' ')}]`, or "
                "another unit of the same kind"
            )
        return CsvColumn(name, "", si, limit)
    try:
        read_number(f"1 {unit}", si, ANY)
    except ValueError as error:
        raise FileError(one_line(f"{place}, column {name}: unit {unit!r}: {error}", 400)) from error
    return CsvColumn(name, unit, si, limit)


def csv_number(cell: str, column: CsvColumn, place: str) -> float:
    """The number in a cell that is not empty [SI].

    **Raises:** `FileError` for anything else than a number within the limit of the column.
    """
    text = cell.strip()
    comma = comma_in_number(text)
    if comma:
        raise FileError(f"{place} {column.name}: {one_line(text, 60)!r}: {one_line(comma, 200)}")
    try:
        # The reader of units also reads dimensionless numbers, because it refuses words.
        return read_number(f"{text} {column.unit}".strip(), column.si, column.limit)
    except ValueError as error:
        what = str(error).partition(";")[0]
        raise FileError(
            f"{place} {column.name}: {one_line(text, 60)!r}: {one_line(what, 200)}; give a number "
            f"in {column.unit or 'plain digits'}"
        ) from error
