"""Measurements from a CSV file: header cells `name [unit]`, one row per measured point."""

import math
from pathlib import Path

import numpy as np

from .._errors import FileError, UnknownNameError, closest, missing_extra
from ..fields import ANY
from ..file.numbers import (
    CsvColumn,
    csv_column,
    csv_heading,
    csv_number,
    csv_rows,
    one_line,
)
from ..mechanism import Mechanism, all_parameters, find_parameters
from ..quantities import catalogue, quantity_of
from ._measurements import Measurements, impossible, is_quantity

_DATA = Path(__file__).parent / "data"


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
        return _measurements(_path(source, name), name, mechanism)
    except ModuleNotFoundError as error:
        raise missing_extra("file", "reading units of measurements", error) from error


def _path(source: str | Path, name: str) -> Path:
    if str(source) in example_data_names():
        return _DATA / f"{source}.csv"
    try:
        there = Path(source).is_file()
    except (OSError, ValueError) as error:
        raise FileError(f"{name}: cannot be read: {error}") from error
    if not there:
        known = ", ".join(example_data_names())
        raise FileError(
            f"{name}: there is no such file; give a CSV file, or the name of example data ({known})"
        )
    return Path(source)


def _measurements(path: Path, name: str, mechanism: Mechanism) -> Measurements:
    (number, header), *body = csv_rows(path, name)
    heads = [_head(cell, f"{name}: row {number}", mechanism) for cell in header]
    names = [head.name for head in heads]
    for one in names:
        if names.count(one) > 1:
            raise FileError(f"{name}: column {one} is there twice; remove one")
    if not any(map(is_quantity, names)):
        raise FileError(
            f"{name}: no column is a quantity of the catalogue (see `prsm quantities`); add one, "
            "such as `drive_torque [N m]`"
        )
    rows = []
    for number, row in body:
        place = f"{name}: row {number}, column"
        rows.append([_cell(c, head, place) for c, head in zip(row, heads, strict=True)])
    table = np.array(rows).T
    try:
        return Measurements.from_columns(dict(zip(names, table, strict=True)))
    except ValueError as error:
        raise FileError(f"{name}: {error}") from error


def _head(cell: str, place: str, mechanism: Mechanism) -> CsvColumn:
    name, unit = csv_heading(cell, place, "drive_torque [N m]")
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
    return csv_column(name, unit, si, limit, place)


def _cell(cell: str, column: CsvColumn, place: str) -> float:
    if cell.strip():
        value = csv_number(cell, column, place)
        if is_quantity(column.name) and impossible(column.name, value):
            raise FileError(f"{place} {column.name}: {_no_efficiency(cell.strip(), value, column)}")
        return value
    if is_quantity(column.name):
        return math.nan
    raise FileError(f"{place} {column.name}: is empty; every row needs this condition")


def _no_efficiency(cell: str, value: float, column: CsvColumn) -> str:
    """Why a measured efficiency is none, and the remedy."""
    shown, name = one_line(cell, 60), column.name
    if column.unit:
        return f"{shown} {column.unit}: an efficiency lies between 0 and 100 %"
    words = f"{shown}: an efficiency is a number from 0 to 1"
    if 1 < value <= 100:
        words += f"; write {value / 100:g}, or head the column `{name} [%]`"
    return words
