"""The tables of a report as a workbook of Excel: a sheet for each section, units in headings."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from .._errors import missing_extra
from ..process import whole_file
from ..report import ReportData, Section
from ..report.document import report_sections
from ..sweeps import text_cell
from ..text import printable
from ._cells import Column, NumberCell, columns_of

#: Excel allows no longer name of a sheet, and none of these characters.
_LONGEST_NAME = 31
_NOT_IN_NAMES = str.maketrans(dict.fromkeys("[]:*?/\\", " "))
#: Section whose digits are versions and revisions, which are no numbers.
_TEXT_ONLY = "provenance"
_WIDTH = 24


def write_workbook(path: str | os.PathLike[str], data: ReportData) -> Path:
    """Write the tables of a report to a workbook of Excel.

    Each section is a sheet with its sentences and tables. Numbers are numbers, not rounded, and
    shown with as many digits as in the report; their unit is in the heading, or in a column beside
    them where it changes from row to row. A sheet "Assumptions" lists what the numbers of each
    section rest on. Text is never a formula.

    **Arguments:**

    - `path`: the file, which ends in `.xlsx`; it is complete or, if anything fails, as before.
    - `data`: what `prsm_jax.report.analyse` returns.

    **Returns:** the path.

    **Raises:** `ValueError` for another ending; `MissingExtraError` without openpyxl.
    """
    target = Path(path)
    if target.suffix.lower() != ".xlsx":
        raise ValueError(f"workbook {target}: the ending must be .xlsx")
    try:
        import openpyxl
    except ImportError as error:
        raise missing_extra("export", "a workbook of Excel", error) from error
    sections = report_sections(data)
    book = openpyxl.Workbook(write_only=True)
    try:
        _fill(book, sections)
        with whole_file(target) as partial:
            book.save(partial)
    except BaseException:
        # Without saving, the files of the sheets would stay open.
        for sheet in book:
            sheet.close()
        raise
    return target


def _fill(book: Any, sections: Sequence[Section]) -> None:
    names: list[str] = []
    for section in sections:
        sheet = _sheet(book, section.title, names)
        for words in (*section.paragraphs, *section.faults):
            sheet.append([_text(sheet, words)])
        for table in section.tables:
            sheet.append([])
            if table.caption:
                sheet.append([_bold(sheet, table.caption)])
            _append(sheet, columns_of(table, section.anchor != _TEXT_ONLY))
    sheet = _sheet(book, "Assumptions", names)
    sheet.append([_bold(sheet, "section"), _bold(sheet, "assumption")])
    for section in sections:
        for sentence in section.assumptions:
            sheet.append([_text(sheet, section.title), _text(sheet, sentence)])


def _sheet(book: Any, title: str, names: list[str]) -> Any:
    """A new sheet; its name is the title as far as Excel allows, and differs from all others."""
    plain = printable(title).translate(_NOT_IN_NAMES).strip("' ")[:_LONGEST_NAME] or "sheet"
    name, count = plain, 1
    while name.lower() in names:
        count += 1
        name = f"{plain[: _LONGEST_NAME - 4]} {count}"
    names.append(name.lower())
    sheet = book.create_sheet(name)
    for letter in "ABCDEFGHIJKL":
        sheet.column_dimensions[letter].width = _WIDTH
    return sheet


def _append(sheet: Any, columns: Iterable[Column]) -> None:
    columns = list(columns)
    sheet.append([_bold(sheet, one.heading) for one in columns])
    for row in zip(*(one.cells for one in columns), strict=True):
        sheet.append([_cell(sheet, one) for one in row])


def _cell(sheet: Any, content: NumberCell | str) -> Any:
    import openpyxl.cell

    if isinstance(content, str):
        return _text(sheet, content)
    cell = openpyxl.cell.WriteOnlyCell(sheet, content.value)
    decimals = "." + "0" * content.decimals if content.decimals else ""
    digits = f"0{decimals}E+00" if content.exponent else f"0{decimals}"
    cell.number_format = f"+{digits};-{digits};{digits}" if content.signed else digits
    return cell


def _text(sheet: Any, words: str) -> Any:
    return text_cell(sheet, printable(words)) if words else None


def _bold(sheet: Any, words: str) -> Any:
    from openpyxl.styles import Font

    cell = text_cell(sheet, printable(words))
    cell.font = Font(bold=True)
    return cell
