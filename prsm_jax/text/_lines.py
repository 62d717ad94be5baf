"""Lines of labels and numbers with units, aligned: how results and mechanisms print themselves."""

import html
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._display_units import MINUS, display_unit, is_efficiency, number, state_without_efficiency
from ._plain_text import printable
from ._text_table import NOT_DEFINED

_WIDTH = 79
#: Whole numbers below this are printed with all their digits.
_LARGEST = 1e7
#: Of more lines, the first are printed.
_MOST_LINES = 24


@dataclass(frozen=True)
class Line:
    """A label, and SI numbers or words.

    - `label`: what it is.
    - `value`: words, true or false, a number, or an array of numbers, of which those that are
      complex are shown by their magnitudes.
    - `unit`: SI unit of the numbers.
    - `quantity`: name of the quantity, which tells an efficiency from other ratios.
    - `most`: as many numbers are listed; of more, the smallest and the largest are shown.
    """

    label: str
    value: Any
    unit: str = "1"
    quantity: str = ""
    most: int = 4

    @property
    def text(self) -> str:
        """The value in an engineer's units."""
        if self.value is None:
            return NOT_DEFINED
        if isinstance(self.value, str):
            return printable(self.value)
        array = np.asarray(self.value).ravel()
        if array.size == 0:
            return "none"
        if array.dtype == bool:
            return _truth(array)
        if np.iscomplexobj(array):
            array = np.abs(array)
        return self._numbers(array)

    def _numbers(self, array: np.ndarray) -> str:
        whole = np.issubdtype(array.dtype, np.integer)
        values = array.astype(float)
        ratio = self.quantity if self.unit == "1" and is_efficiency(self.quantity) else ""
        # A thread that locks or jams has no efficiency.
        stuck = values < 0 if ratio else np.zeros(values.shape, bool)
        usable = values[~np.isnan(values) & ~stuck]
        ends = (float(usable.min()), float(usable.max())) if usable.size else (0.0, 0.0)
        unit = display_unit(self.unit, ends, self.quantity)

        def one(value: float) -> str:
            state = state_without_efficiency(ratio, value)
            # A count is a whole number, whether or not it has become a float.
            counts = not unit.label and (whole or (value.is_integer() and abs(value) < _LARGEST))
            return state or (f"{value:.0f}".replace("-", MINUS) if counts else number(unit(value)))

        if values.size <= self.most:
            words = ", ".join(map(one, values))
            return f"{words} {unit.label}".rstrip() if usable.size else words
        parts: list[str] = []
        if usable.size:
            low, high = map(one, ends)
            parts.append(f"{low if low == high else f'{low} … {high}'} {unit.label}".rstrip())
        if stuck.any():
            state = state_without_efficiency(ratio, -1.0)
            parts.append(f"{state}: {_of(int(stuck.sum()), values.size)}")
        undefined = int(np.isnan(values).sum())
        if undefined:
            parts.append(f"not defined: {_of(undefined, values.size)}")
        return "; ".join(parts)


def _of(count: int, total: int) -> str:
    return f"{count} of {total}"


def _truth(array: np.ndarray) -> str:
    true = int(array.sum())
    if true in (0, array.size):
        return "yes" if true else "no"
    return f"yes: {_of(true, array.size)}"


def aligned(title: str, lines: Sequence[Line]) -> str:
    """A title and a line for each value, at most 25 lines of 79 characters.

    **Arguments:**

    - `title`: the first line.
    - `lines`: the others; values too long for one line are continued below it.
    """
    rows = [(printable(line.label), line.text) for line in lines]
    margin = max((len(label) for label, _ in rows), default=0) + 4
    texts = [printable(title)]
    for label, text in rows:
        start = f"  {label}".ljust(margin)
        texts += textwrap.wrap(
            text, _WIDTH, initial_indent=start, subsequent_indent=" " * margin
        ) or [start.rstrip()]
    if len(texts) > _MOST_LINES + 1:
        left = len(texts) - _MOST_LINES
        texts = [*texts[:_MOST_LINES], f"  … {left} more lines"]
    return "\n".join(texts)


def html_table(title: str, lines: Sequence[Line]) -> str:
    """The same for a notebook; all text is escaped.

    **Arguments:**

    - `title`: above the table.
    - `lines`: its rows.
    """
    rows = "".join(
        f'<tr><th style="text-align:left">{html.escape(printable(line.label))}</th>'
        f'<td style="text-align:left">{html.escape(line.text)}</td></tr>'
        for line in lines
    )
    return f"<table><caption>{html.escape(printable(title))}</caption>{rows}</table>"
