"""The parts a report is made of, before they become HTML or Markdown."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..interactive import Chart

#: How a cell with a number begins: a sign, digits or infinity.
_NUMBER = re.compile("[-+\N{MINUS SIGN}<>≤≥]?\\s*[\\d∞]")
#: A longer cell is a sentence.
_SENTENCE = 60
#: A table of more rows may not fit on a page.
_ROWS_OF_A_PAGE = 22


@dataclass(frozen=True)
class Table:
    """A table of finished text; words are aligned on the left, numbers on the right."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def text_columns(self) -> tuple[int, ...]:
        """The first column, and those in which most cells are not numbers.

        A sentence is none, although it may begin with one.
        """
        columns = [0]
        for index in range(1, len(self.head)):
            cells = [row[index] for row in self.rows if row[index]]
            words = [one for one in cells if len(one) > _SENTENCE or not _NUMBER.match(one)]
            if 2 * len(words) > len(cells):
                columns.append(index)
        return tuple(columns)

    @property
    def verdict_columns(self) -> tuple[int, ...]:
        """Columns of verdicts, which are shown in colour."""
        return tuple(i for i, words in enumerate(self.head) if words.startswith("verdict"))

    @property
    def long(self) -> bool:
        """Whether it may be broken between two pages; its head is then repeated."""
        return len(self.rows) > _ROWS_OF_A_PAGE


@dataclass(frozen=True)
class Picture:
    """A picture to be drawn: a file name, a caption, and the function that draws it.

    `chart` makes its curves, for the interactive chart that a browser shows in its place.
    """

    name: str
    caption: str
    draw: Callable[[], Any]
    chart: Callable[[], Chart] | None = None


@dataclass(frozen=True)
class Section:
    """A heading with paragraphs, tables, assumptions and pictures."""

    anchor: str
    title: str
    paragraphs: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
    #: Sentences from `prsm_jax.assumptions`, printed beneath the tables.
    assumptions: tuple[str, ...] = ()
    #: Parts missing because of a fault of this program, as sentences.
    faults: tuple[str, ...] = ()
    #: "pass", "warning" or "fail" of a section that states it, else empty.
    status: str = ""
