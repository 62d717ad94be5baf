"""Tables of numbers in text: cells of a CSV table, and commas in numbers."""

import csv
import re

_LONGEST = 200
#: What may follow the digits: an exponent and a unit.
_REST = r"(?P<rest>(?:[eE][+-]?\d+)?(?:[^\d.,][^,]*)?)"
_DECIMAL = re.compile(r"(?P<before>[+-]?\d+(?:\.\d{3})*),(?P<after>\d+)" + _REST)
_GROUPED = re.compile(r"(?P<number>[+-]?\d{1,3}(?:,\d{3})+(?:\.\d+)?)" + _REST)
_COMMA = re.compile(r"[+-]?\d[\d.]*,")


def csv_cells(text: str) -> list[tuple[int, list[str]]]:
    """Cells of a CSV table, the header first, each row with the number of its line.

    Cells are separated by commas, or by semicolons if the header has semicolons alone. Lines that
    begin with `#` are comments. Rows of empty cells are left out: spreadsheets append them.

    **Raises:** `ValueError` for text that is no such table.
    """
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        return []
    delimiter = ";" if ";" in lines[0][1] and "," not in lines[0][1] else ","
    try:
        rows = list(csv.reader([line for _, line in lines], delimiter=delimiter, strict=True))
    except csv.Error as error:
        raise ValueError(f"is not a CSV table: {error}") from error
    if len(rows) != len(lines):
        raise ValueError("a quoted cell contains a line break; write each row in one line")
    return [
        (number, row)
        for (number, _), row in zip(lines, rows, strict=True)
        if any(cell.strip() for cell in row)
    ]


def comma_in_number(text: str) -> str:
    """What is wrong with a number that contains a comma, and the remedy; empty without one.

    **Arguments:**

    - `text`: a number, with or without a unit, such as `1,9765 N m`.
    """
    text = text.strip()
    if len(text) > _LONGEST or not _COMMA.match(text):
        return ""
    match = _DECIMAL.fullmatch(text)
    if match is not None:
        before, after, rest = match.group("before", "after", "rest")
        whole = before.replace(".", "")
        words = f"decimal comma; write {whole}.{after}{rest}"
        # Of `1,500` nobody but the author knows which number it is.
        digits = whole.lstrip("+-")
        if len(after) == 3 and len(digits) <= 3 and not digits.startswith("0"):
            words += f", or {whole}{after}{rest} if the comma separates thousands"
        return words
    match = _GROUPED.fullmatch(text)
    if match is not None:
        number, rest = match.group("number", "rest")
        return f"comma between digits; write {number.replace(',', '')}{rest}"
    return "commas between digits; give one number, with a decimal point"
