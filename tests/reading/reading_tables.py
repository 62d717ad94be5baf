"""Tables read cell by cell: those of reports, of HTML, and of the terminal."""

import re
from collections.abc import Sequence
from html.parser import HTMLParser
from typing import Any

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


def terminal_tables(text: str) -> dict[str, list[list[str]]]:
    """Tables as the command line prints them, by title: rows of cells, the head first.

    A line of the title, then columns two spaces apart; a rule stands under the head.
    """
    found: dict[str, list[list[str]]] = {}
    title = ""
    for line in text.splitlines():
        if not line.strip() or set(line.strip()) <= set("─━ "):
            continue
        if not line.startswith(" "):
            title = line.strip()
            found[title] = []
        else:
            found[title].append([cell for cell in re.split(r"\s{2,}", line.strip()) if cell])
    return found


__all__ = ["MINUS", "assert_cell", "assert_table", "html_tables", "terminal_tables"]
