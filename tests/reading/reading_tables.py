"""Tables read cell by cell: those of reports, of HTML, and of the terminal."""

import re
from collections.abc import Sequence
from html.parser import HTMLParser
from typing import Any

import numpy as np
from reading_units import MINUS, assert_reads, label_unit, numbers, parse, same_dimension, to_si


def assert_cell(text: str, expected: Any, column: str = "", row: str = "") -> None:
    """A cell reads as expected.

    **Arguments:**

    - `text`: the cell.
    - `expected`: a text, or `(SI value, SI unit)`, or a list of those.
    - `column`, `row`: heads, which name the unit of a cell without one.
    """
    if isinstance(expected, str):
        assert text == expected, f"{text!r} is not {expected!r}"
        return
    pairs = expected if isinstance(expected, list) else [expected]
    unit = label_unit(column) or label_unit(row)
    if unit and not any(one.label for one in numbers(text)):
        ((value, si_unit, *rest),) = pairs
        assert same_dimension(unit, si_unit), f"{column or row!r} is not in {si_unit}"
        shown, rounding = parse(text)
        assert rest or rounding <= 0.00501 * abs(shown) or shown == 0, f"{text!r} is coarse"
        found, half = float(to_si(shown, unit)), float(to_si(rounding, unit))
        off = abs(found - float(value))
        assert off <= 1.00001 * abs(half) + 1e-12 * abs(float(value)), (
            f"{text!r} under {column!r}, {row!r} is not {value} {si_unit}"
        )
        return
    assert_reads(text, *pairs)


def assert_table(table: Any, head: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Every cell of a table of a report reads as expected, and there is no other."""
    assert tuple(table.head) == tuple(head)
    found = [tuple(row) for row in table.rows]
    names = [row[0] for row in found], [row[0] for row in rows]
    assert len(found) == len(rows), f"rows {names[0]}, expected {names[1]}"
    for cells, wanted in zip(found, rows, strict=True):
        assert len(cells) == len(wanted) == len(head), f"{cells} against {wanted}"
        for index, (cell, one) in enumerate(zip(cells, wanted, strict=True)):
            column = head[index]
            try:
                assert_cell(cell, one, column, cells[0] if index else "")
            except AssertionError as error:
                raise AssertionError(f"{table.caption}, {cells[0]}, {column}: {error}") from error


class _Reader(HTMLParser):
    """Captions and cells of all tables of a page."""

    def __init__(self):
        super().__init__()
        self.tables: list[tuple[str, list[list[str]]]] = []
        self._into: list[str] | None = None

    def handle_starttag(self, tag, attrs):
        if tag == "table":
            self.tables.append(("", []))
        elif tag == "tr":
            self.tables[-1][1].append([])
        elif tag in ("td", "th", "caption"):
            self._into = []

    def handle_data(self, data):
        if self._into is not None:
            self._into.append(data)

    def handle_endtag(self, tag):
        if tag not in ("td", "th", "caption") or self._into is None:
            return
        words = "".join(self._into).strip()
        self._into = None
        _caption, rows = self.tables[-1]
        if tag == "caption":
            self.tables[-1] = (words, rows)
        else:
            rows[-1].append(words)


def html_tables(text: str) -> list[tuple[str, list[list[str]]]]:
    """Caption and rows, the head first where there is one, of every table of a page."""
    reader = _Reader()
    reader.feed(text)
    return reader.tables


#: What the terminal prints of a number: six significant digits, zeros at the end left out.
_SIX_DIGITS = 5.1e-6


class Terminal:
    """What a verb printed, line by line; `finish` fails if a line with a number was not read."""

    def __init__(self, text: str):
        # What results rest on has tests of its own.
        text = text.partition("\nAssumptions\n")[0].partition("\nprsm check finds ")[0]
        self.lines = [
            [cell for cell in re.split(r"\s{2,}", line.strip()) if cell]
            for line in text.splitlines()
            if line.strip() and not set(line.strip()) <= set("─━-")
        ]

    def row(self, first: str) -> list[str]:
        """The cells behind the first one of the next line that begins so."""
        for index, cells in enumerate(self.lines):
            if cells[0] == first:
                return self.lines.pop(index)[1:]
        raise AssertionError(f"no line {first!r}; left are {self.lines}")

    def line(self, first: str, value: Any, si_unit: str) -> None:
        """Words, a value, and its unit: a list of quantities."""
        cells = self.row(first)
        assert 1 <= len(cells) <= 2, cells
        _assert_six(cells[0], cells[1] if len(cells) > 1 else "", value, si_unit, first)

    def table(self, head: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
        """A table with a head that names units at its ends; rows of text or `(value, unit)`."""
        columns = [head[0], *self.row(head[0])]
        assert columns == list(head)
        for row in rows:
            cells = self.row(row[0])
            wanted = [one for one in row[1:] if one != ""]
            names = [name for name, one in zip(columns[1:], row[1:], strict=True) if one != ""]
            assert len(cells) == len(wanted), (cells, wanted)
            for cell, one, name in zip(cells, wanted, names, strict=True):
                if isinstance(one, str):
                    assert cell == one, f"{name}: {cell!r} is not {one!r}"
                else:
                    _assert_six(cell, column_unit(name), *one, f"{row[0]}, {name}")  # pyright: ignore[reportCallIssue]

    def finish(self) -> None:
        """Every line with a number has been read."""
        left = [cells for cells in self.lines if any(c.isdigit() for c in "".join(cells))]
        assert left == []


def column_unit(name: str) -> str:
    """The unit at the end of a head or of a name: `r mm`, `lead [mm]`; none is a ratio."""
    bracket = re.search(r"\[(.+)\]$", name)
    if bracket:
        return bracket[1]
    last = name.split(" ")[-1]
    return last if re.fullmatch(_UNITS, last) and " " in name else ("rpm" if name == "rpm" else "")


_UNITS = r"mm|µm|m|deg|N|kN|MPa|N/µm|Hz|kHz|N·m|W|kW|rpm|%"


def _assert_six(cell: str, label: str, value: Any, si_unit: str, place: str) -> None:
    assert same_dimension(label, si_unit), f"{place}: {label!r} for {si_unit!r}"
    shown = float(cell.replace("∞", "inf").replace(MINUS, "-"))
    found, expected = float(to_si(shown, label)), float(value)
    near = found == expected or abs(found - expected) <= _SIX_DIGITS * abs(expected)
    assert near, f"{place}: {cell} {label} is not {expected} {si_unit}"


def assert_json(found: Any, expected: Any, path: str = "") -> None:
    """JSON has these keys and no others, and these numbers to the last bit but two."""
    if isinstance(expected, dict):
        assert isinstance(found, dict), path
        assert set(found) == set(expected), f"{path}: keys {set(found) ^ set(expected)}"
        for key, value in expected.items():
            assert_json(found[key], value, f"{path}.{key}")
        return
    if isinstance(expected, list | tuple) and not _numeric(expected):
        assert len(found) == len(expected), path
        for index, (one, value) in enumerate(zip(found, expected, strict=True)):
            assert_json(one, value, f"{path}[{index}]")
        return
    if expected is None or isinstance(expected, str | bool):
        assert found == expected, f"{path}: {found!r} is not {expected!r}"
        return
    wanted = np.asarray(expected)
    if wanted.dtype == bool:
        assert np.asarray(found).tolist() == wanted.tolist(), path
        return
    shown = np.asarray(found, float)
    np.testing.assert_allclose(shown, wanted, rtol=1e-13, atol=0, err_msg=path)


def without_words(found: dict) -> dict:
    """The JSON without what it rests on and what the checks say, which are no numbers."""
    for key in ("assumptions", "findings"):
        words = found.pop(key, [])
        assert all(isinstance(one, str) and one for one in words)
    # Whether the mechanism can exist; that it can be false is tested with the findings.
    assert found.pop("valid", True) is True
    return found


def _numeric(values: Any) -> bool:
    try:
        return np.asarray(values).dtype.kind in "fiub"
    except ValueError:
        return False
