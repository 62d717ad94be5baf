"""Sweeps as files for other programs: CSV, Excel, Parquet and netCDF.

Designs are rows; components of a quantity (stages, modes) are columns of their own. Rows are read
and written in pieces, so that memory does not grow with the number of designs, except for Excel and
netCDF.
"""

import math
import os
from collections.abc import Callable, Generator, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._errors import missing_extra
from ..process import whole_file
from ._plan import blocks_of

if TYPE_CHECKING:
    import pandas
    import xarray

#: Rows of a sheet of Excel, less the line of the names.
_EXCEL_ROWS = 2**20 - 1
#: First characters of cells that spreadsheets calculate.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
#: Rows that are in memory at once.
_PIECE = 50_000


def export(
    data: "xarray.Dataset", path: str | os.PathLike[str], assumptions: Iterable[str] = ()
) -> None:
    """Write a sweep to a file, in the format of its ending.

    | ending | format |
    | --- | --- |
    | `.csv` | text; units in the names of columns |
    | `.xlsx` | Excel; sheets of designs, of columns with units and descriptions, of assumptions |
    | `.parquet` | columns with units and descriptions as metadata |
    | `.nc` | netCDF 4, with the dimensions of the sweep |

    **Arguments:**

    - `data`: the data set of `sweep`.
    - `path`: the file; it is complete or, if anything fails, as before.
    - `assumptions`: sentences on the assumptions of the analysis; a CSV file does not have them.

    **Raises:** `ValueError` for another ending, a folder that does not exist, and more designs than
    a sheet of Excel has rows; `MissingExtraError` without the library of the format.
    """
    target = Path(path)
    check_export(target)
    write, _ = _FORMATS[target.suffix.lower()]
    sentences = list(assumptions)
    with whole_file(target) as partial:
        write(data, partial, sentences)


def check_export(path: str | os.PathLike[str]) -> None:
    """Check, before anything is computed, that a file of this name can be written.

    **Raises:** as `export`, but for the number of designs.
    """
    target = Path(path)
    if target.suffix.lower() not in _FORMATS:
        raise ValueError(f"export to {target}: the ending must be one of {', '.join(_FORMATS)}")
    if not target.absolute().parent.is_dir():
        raise ValueError(f"export to {target}: the folder {target.parent} does not exist; make it")
    _, library = _FORMATS[target.suffix.lower()]
    if library is not None:
        try:
            __import__(library)
        except ImportError as error:
            raise missing_extra("export", f"an export to {target.suffix}", error) from error


class _Column:
    """One column: a coordinate of the designs, or one component of a variable."""

    def __init__(self, data: "xarray.Dataset", name: str, component: tuple[int, ...]):
        array = data[name]
        self.variable, self.component = name, component
        own = array.dims[array.ndim - len(component) :] if component else ()
        parts = [
            f"{dimension} {int(data[dimension][index]) if dimension in data.coords else index + 1}"
            for dimension, index in zip(own, component, strict=True)
        ]
        self.name = f"{name} ({', '.join(map(str, parts))})" if parts else name
        self.unit = str(array.attrs.get("units", ""))
        self.description = str(array.attrs.get("long_name", ""))
        meanings = str(array.attrs.get("flag_meanings", "")).split()
        #: Words for the numbers of a code.
        self.words = meanings

    @property
    def heading(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit and self.unit != "1" else self.name


def _columns(data: "xarray.Dataset", designs: tuple[str, ...]) -> list[_Column]:
    coordinates = [name for name, array in data.coords.items() if set(array.dims) <= set(designs)]
    columns = [_Column(data, str(name), ()) for name in coordinates]
    for name, array in data.data_vars.items():
        own = array.shape[len(designs) :]
        columns += [_Column(data, str(name), index) for index in np.ndindex(*own)]
    return columns


def _design_dimensions(data: "xarray.Dataset") -> tuple[str, ...]:
    """Dimensions that all variables share: those of the code."""
    return tuple(map(str, data["code"].dims))


def _pieces(
    data: "xarray.Dataset", columns: Sequence[_Column], designs: tuple[str, ...]
) -> "Generator[pandas.DataFrame, None, None]":
    """Tables of neighbouring designs, in the order of the sweep."""
    import pandas

    blocks = blocks_of(tuple(data.sizes[name] for name in designs), _PIECE)
    for number in range(len(blocks)):
        part = data.isel(dict(zip(designs, blocks.slices(number), strict=True))).load()
        shape = tuple(part.sizes[name] for name in designs)
        table = {}
        for column in columns:
            array = part[column.variable]
            if column.variable in part.coords:
                spread = np.broadcast_to(
                    array.values.reshape(
                        [part.sizes[n] if n in array.dims else 1 for n in designs]
                    ),
                    shape,
                )
                table[column.heading] = spread.ravel()
                continue
            values = array.values[(..., *column.component)].ravel()
            if column.words:
                values = np.array(column.words, object)[values]
            table[column.heading] = values
        yield pandas.DataFrame(table)


def _csv(data: "xarray.Dataset", path: Path, assumptions: list[str]) -> None:
    designs = _design_dimensions(data)
    columns = _columns(data, designs)
    with path.open("w", encoding="utf-8", newline="") as file:
        for index, table in enumerate(_pieces(data, columns, designs)):
            words = table.select_dtypes(exclude=["number", "bool"]).map(_no_formula)
            table = table.assign(**words).rename(columns=_no_formula)
            table.to_csv(file, index=False, header=index == 0)


def _no_formula(value: Any) -> Any:
    """Text that spreadsheets do not take for a formula; a number stays as it is.

    The names and words of a store that somebody else wrote could be formulas.
    """
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value


def _excel(data: "xarray.Dataset", path: Path, assumptions: list[str]) -> None:
    import openpyxl

    designs = _design_dimensions(data)
    count = int(np.prod([data.sizes[name] for name in designs]))
    if count > _EXCEL_ROWS:
        raise ValueError(
            f"{count} designs are more than the {_EXCEL_ROWS} rows of a sheet of Excel; export to "
            ".csv or .parquet"
        )
    book = openpyxl.Workbook(write_only=True)
    try:
        _fill(book, data, designs, assumptions)
        book.save(path)
    except BaseException:
        # Without saving, a file of the sheet would stay open.
        for sheet in book:
            sheet.close()
        raise


def _fill(book: Any, data: "xarray.Dataset", designs: tuple[str, ...], assumptions: list[str]):
    """Write the sheets of a workbook."""
    columns = _columns(data, designs)
    sheet = book.create_sheet("designs")
    sheet.freeze_panes = "A2"
    sheet.append([text_cell(sheet, column.heading) for column in columns])
    for table in _pieces(data, columns, designs):
        for row in table.itertuples(index=False):
            sheet.append([_cell(sheet, value) for value in row])
    described = book.create_sheet("columns")
    described.append(["column", "unit", "description"])
    for column in columns:
        described.append(
            [text_cell(described, one) for one in (column.name, column.unit, column.description)]
        )
    rests = book.create_sheet("assumptions")
    for sentence in assumptions:
        rests.append([text_cell(rests, sentence)])
    for name, value in data.attrs.items():
        rests.append([text_cell(rests, f"{name}: {value}")])


def _cell(sheet: Any, value: Any) -> Any:
    """A value of a cell. NaN and infinity, which Excel does not have, give an empty cell."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, str):
        return text_cell(sheet, value)
    return None if isinstance(value, float) and not math.isfinite(value) else value


def text_cell(sheet: Any, text: str) -> Any:
    """A cell of text, which Excel does not take for a formula.

    **Arguments:**

    - `sheet`: of a workbook of openpyxl that is only written.
    - `text`: the text.
    """
    import openpyxl.cell

    cell = openpyxl.cell.WriteOnlyCell(sheet, text)
    cell.data_type = "s"
    return cell


def _parquet(data: "xarray.Dataset", path: Path, assumptions: list[str]) -> None:
    import pyarrow
    import pyarrow.parquet

    designs = _design_dimensions(data)
    columns = _columns(data, designs)
    by_heading = {column.heading: column for column in columns}
    about = {str(name): str(value) for name, value in data.attrs.items()}
    about["assumptions"] = "\n".join(assumptions)
    writer = None
    try:
        for table in _pieces(data, columns, designs):
            # Names without units here: the metadata of the column has them.
            rows = pyarrow.Table.from_pandas(table, preserve_index=False)
            fields = [
                field.with_name(by_heading[field.name].name).with_metadata(
                    {
                        "units": by_heading[field.name].unit,
                        "description": by_heading[field.name].description,
                    }
                )
                for field in rows.schema
            ]
            schema = pyarrow.schema(fields, metadata=about)
            if writer is None:
                writer = pyarrow.parquet.ParquetWriter(path, schema)
            writer.write_table(pyarrow.Table.from_arrays(rows.columns, schema=schema))
    finally:
        if writer is not None:
            writer.close()


def _netcdf(data: "xarray.Dataset", path: Path, assumptions: list[str]) -> None:
    labelled = data.assign_attrs(assumptions="\n".join(assumptions))
    labelled.to_netcdf(path, engine="h5netcdf")


#: By ending: the function that writes the format, and the further library that it needs.
_FORMATS: dict[str, tuple[Callable[[Any, Path, list[str]], None], str | None]] = {
    ".csv": (_csv, None),
    ".xlsx": (_excel, "openpyxl"),
    ".parquet": (_parquet, "pyarrow"),
    ".nc": (_netcdf, "h5netcdf"),
}
