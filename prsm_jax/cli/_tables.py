"""Tables that fit the width of the terminal, in engineering units."""

import shutil
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any

from ..text import TextTable as TextTable, display_unit

#: Columns of files, of pipes, and of a terminal that does not report its width.
_WIDTH = 80
_LEAST = 40

#: A line of a list of quantities: label, SI value, SI unit and, for an efficiency, the name of the
#: quantity.
Line = tuple[Any, ...]


def terminal_width() -> int:
    """Characters in a line of the terminal; 80 where there is none."""
    return max(shutil.get_terminal_size((_WIDTH, 24)).columns, _LEAST)


def table(title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """A plain-text table that fits the terminal; numbers to six significant digits."""
    return TextTable(title, columns, rows).text(terminal_width())


def prose(text: str) -> str:
    """Sentences broken into lines that fit the terminal; a path is never broken."""
    lines = [
        textwrap.wrap(line, terminal_width(), break_long_words=False, break_on_hyphens=False)
        for line in text.splitlines()
    ]
    return "\n".join("\n".join(parts) for parts in lines) + "\n"


def in_units(lines: Iterable[Line]) -> list[tuple[str, float | None, str]]:
    """Label, value and unit of each line, converted from SI to an engineering unit."""
    rows = []
    for words, value, unit, *name in lines:
        known = value is not None
        shown = display_unit(unit, abs(float(value)) if known else 0.0, *name)
        rows.append((words, float(shown(float(value))) if known else None, shown.label))
    return rows
