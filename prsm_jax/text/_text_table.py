"""Plain-text tables that fit a given width without losing a character."""

import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._plain_text import markdown, printable

#: Shown where there is no number.
NOT_DEFINED = "–"
_GAP = 2
_NUMBER = re.compile(rf"[+-]?(\d+\.?\d*(e[+-]\d+)?|∞)|{NOT_DEFINED}")
#: The least width of a column of words, and the length up to which a word is not broken.
_NARROW, _LONG_WORD = 12, 40


def cell_text(value: Any) -> str:
    """A cell as text: numbers to six significant digits, a dash for what is not defined."""
    if value is None:
        return NOT_DEFINED
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return NOT_DEFINED if np.isnan(value) else f"{float(value):z.6g}".replace("inf", "∞")
    return printable(str(value))


@dataclass(frozen=True)
class TextTable:
    """A table; numbers stay numbers until it is printed.

    Columns of numbers are right-aligned and never broken. If a table is too wide, its columns of
    words are wrapped; if that is not enough, it is printed in several parts that repeat the first
    column.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]

    def text(self, width: int | None = None) -> str:
        """The table as plain text, ending with a line break.

        **Arguments:**

        - `width`: number of characters in a line; default as many as it needs.
        """
        cells = [[cell_text(cell) for cell in row] for row in self.rows]
        title = printable(self.title)
        lines = textwrap.wrap(title, width) if width else [title]
        for part in self._parts(cells, width):
            lines += self._part(cells, part, width)
        return "\n".join(line for line in lines if line) + "\n"

    def markdown(self) -> str:
        """The table as Markdown, ending with a line break."""
        rows = [[markdown(cell_text(c)) for c in row] for row in self.rows]
        head = [markdown(name) for name in self.columns]
        lines = [head, ["---:" if self._numeric(i) else "---" for i in range(len(head))], *rows]
        body = "\n".join("| " + " | ".join(line) + " |" for line in lines)
        return (f"**{markdown(self.title)}**\n\n" if self.title else "") + body + "\n"

    def _numeric(self, column: int) -> bool:
        cells = [text for text in (cell_text(row[column]) for row in self.rows) if text]
        return bool(cells) and all(_NUMBER.fullmatch(text) for text in cells)

    def _least(self, cells: list[list[str]], column: int) -> int:
        """The least width of a column at which no number and no short word is broken."""
        head = max(map(len, self.columns[column].split()), default=0)
        texts = [row[column] for row in cells]
        if self._numeric(column):
            return max(head, *map(len, texts))
        words = [len(word) for text in texts for word in text.split()]
        longest, widest = max(words, default=0), max(map(len, texts), default=0)
        return max(head, min(longest, _LONG_WORD), min(widest, _NARROW))

    def _parts(self, cells: list[list[str]], width: int | None) -> list[list[int]]:
        """Which columns are printed side by side."""
        everything = list(range(len(self.columns)))
        if width is None or not everything:
            return [everything]
        least = [self._least(cells, column) for column in everything]
        parts, part = [], [0]
        for column in everything[1:]:
            needed = sum(least[c] + _GAP for c in part) + least[column]
            if needed > width and len(part) > 1:
                parts.append(part)
                part = [0]
            part.append(column)
        return [*parts, part]

    def _part(self, cells: list[list[str]], part: list[int], width: int | None) -> list[str]:
        columns = self.columns
        widths = {
            c: max(len(columns[c]), *(len(row[c]) for row in cells)) if cells else len(columns[c])
            for c in part
        }
        if width is not None:
            least = {c: self._least(cells, c) for c in part}
            spare = width - _GAP * (len(part) - 1)
            # The widest column that can shrink is narrowed.
            while sum(widths.values()) > spare:
                shrinkable = [c for c in part if widths[c] > least[c]]
                if not shrinkable:
                    break
                widths[max(shrinkable, key=lambda c: widths[c])] -= 1

        def line(texts: list[str], right: Sequence[bool]) -> list[str]:
            wrapped = [
                textwrap.wrap(text, max(widths[c], 1), break_on_hyphens=False) or [""]
                for text, c in zip(texts, part, strict=True)
            ]
            lines = []
            for index in range(max(map(len, wrapped))):
                pieces = [
                    (w[index] if index < len(w) else "").rjust(widths[c])
                    if right_here
                    else (w[index] if index < len(w) else "").ljust(widths[c])
                    for w, c, right_here in zip(wrapped, part, right, strict=True)
                ]
                lines.append((" " * _GAP).join(pieces).rstrip())
            return lines

        right = [self._numeric(c) for c in part]
        lines = []
        if any(columns[c] for c in part):
            lines += line([columns[c] for c in part], right)
            lines.append("─" * (sum(widths.values()) + _GAP * (len(part) - 1)))
        for row in cells:
            lines += line([row[c] for c in part], right)
        return lines
