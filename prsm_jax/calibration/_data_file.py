"""Measurements from a CSV file: header cells `name [unit]`, one row per measured point."""

import csv
import math
import re
from pathlib import Path

import numpy as np

from .._errors import FileError, UnknownNameError, closest, missing_extra
from ..fields import ANY, Limit
from ..file.numbers import one_line, read_number, utf8_text
from ..mechanism import Mechanism, all_parameters, find_parameters
from ..quantities import catalogue, quantity_of
from ._measurements import Measurements, is_quantity

_DATA = Path(__file__).parent / "data"
_LARGEST_FILE = 20_000_000
_HEADER = re.compile(r"\s*([\w.]+(?:\[\d+\])?)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")


def example_data_names() -> tuple[str, ...]:
    """Names of the shipped example data, which are generated from the model with noise."""
    return tuple(sorted(path.stem for path in _DATA.glob("*.csv")))


def read_measurements(source: str | Path, mechanism: Mechanism) -> Measurements:
    """Read measurements from a CSV file.

    Lines that begin with `#` are comments. The first other line has a cell `name [unit]` for each
    column: a quantity of the catalogue, or a number of the mechanism as a condition. Cells are
    separated by commas or semicolons; an empty cell of a quantity means that it was not measured.

    **Arguments:**

    - `source`: path of the file, or the name of shipped example data.
    - `mechanism`: the mechanism that the conditions belong to.

    **Returns:** the measurements in SI.

    **Raises:** `FileError`, with one line that names file, row, column, value and remedy;
    `MissingExtraError` if pint is not installed.
    """
    name = one_line(str(source), 300)
    try:
        return _measurements(_text(source, name), name, mechanism)
    except ModuleNotFoundError as error:
        raise missing_extra("file", "reading units of measurements", error) from error


def _text(source: str | Path, name: str) -> str:
    path = Path(source)
    if str(source) in example_data_names():
        path = _DATA / f"{source}.csv"
    try:
        if not path.is_file():
            known = ", ".join(example_data_names())
            raise FileError(
                f"{name}: there is no such file; give a CSV file, or the name of example data "
                f"({known})"
            )
        if path.stat().st_size > _LARGEST_FILE:
            raise FileError(f"{name}: is larger than {_LARGEST_FILE} bytes; give fewer rows")
        return utf8_text(path.read_bytes(), name)
    except FileError:
        raise
    except (OSError, ValueError) as error:
        raise FileError(f"{name}: cannot be read: {error}") from error


def _measurements(text: str, name: str, mechanism: Mechanism) -> Measurements:
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise FileError(f"{name}: needs a header line `name [unit],…` and a row of numbers")
    delimiter = ";" if ";" in lines[0][1] and "," not in lines[0][1] else ","
    try:
        cells = list(csv.reader([line for _, line in lines], delimiter=delimiter, strict=True))
    except csv.Error as error:
        raise FileError(f"{name}: is not a CSV table: {error}") from error
    if len(cells) != len(lines):
        raise FileError(f"{name}: a quoted cell contains a line break; write each row in one line")
    heads = [_head(cell, f"{name}: row {lines[0][0]}", mechanism) for cell in cells[0]]
    names = [head[0] for head in heads]
    for one in names:
        if names.count(one) > 1:
            raise FileError(f"{name}: column {one} is there twice; remove one")
    if not any(map(is_quantity, names)):
        raise FileError(
            f"{name}: no column is a quantity of the catalogue (see `prsm quantities`); add one, "
            "such as `drive_torque [N m]`"
        )
    rows = []
    for (number, _), row in zip(lines[1:], cells[1:], strict=True):
        if len(row) != len(heads):
            raise FileError(
                f"{name}: row {number} has {len(row)} cells and the header {len(heads)}; give one "
                "number per column"
            )
        place = f"{name}: row {number}, column"
        rows.append([_cell(c, head, place) for c, head in zip(row, heads, strict=True)])
    table = np.array(rows).T
    try:
        return Measurements.from_columns(dict(zip(names, table, strict=True)))
    except ValueError as error:
        raise FileError(f"{name}: {error}") from error


def _head(cell: str, place: str, mechanism: Mechanism) -> tuple[str, str, str, Limit]:
    """Name, unit as written, SI unit and limit of a column."""
    shown = one_line(cell, 80)
    match = _HEADER.fullmatch(cell)
    if match is None:
        raise FileError(
            f"{place}, column {shown!r}: must be `name [unit]`, such as `drive_torque [N m]`"
        )
    name, unit = match[1], match[2]
    try:
        if is_quantity(name):
            si, limit = quantity_of(name).unit, ANY
        else:
            parameter = find_parameters(mechanism, name)[0]
            if parameter.static:
                raise FileError(
                    f"{place}, column {name}: is a whole number of the mechanism; give a file for "
                    "each of its values"
                )
            si, limit = parameter.unit, parameter.limit
    except UnknownNameError as error:
        paths = [one.path for one in all_parameters(mechanism)]
        near = closest(name, (one.name for one in catalogue()), paths)
        # A list of all quantities and numbers would be too long to help.
        hint = near if near.startswith("did you mean") else "see `prsm quantities`"
        if "ambiguous" in str(error):
            hint = str(error)
        raise FileError(
            f"{place}, column {name}: neither a quantity of the catalogue nor a number of the "
            f"mechanism; {hint}"
        ) from error
    if unit is None or unit in ("", "-", "1"):
        if si != "1":
            raise FileError(
                f"{place}, column {name}: has no unit; write `{name} [{si.replace('·', ' ')}]`, or "
                "another unit of the same kind"
            )
        return name, "", si, limit
    try:
        read_number(f"1 {unit}", si, ANY)
    except ValueError as error:
        raise FileError(one_line(f"{place}, column {name}: unit {unit!r}: {error}", 400)) from error
    return name, unit, si, limit


def _cell(cell: str, head: tuple[str, str, str, Limit], place: str) -> float:
    name, unit, si, limit = head
    text = cell.strip()
    if not text:
        if is_quantity(name):
            return math.nan
        raise FileError(f"{place} {name}: is empty; every row needs this condition")
    try:
        # The reader of units also reads dimensionless numbers, because it refuses words.
        return read_number(f"{text} {unit}".strip(), si, limit)
    except ValueError as error:
        what = str(error).partition(";")[0]
        raise FileError(
            f"{place} {name}: {one_line(text, 60)!r}: {one_line(what, 200)}; give a number in "
            f"{unit or 'plain digits'}"
        ) from error
