"""Rows as text: a plain table, a Markdown table, and counts."""

import textwrap
from collections.abc import Sequence

from ._registry import sources
from ._row import VERDICTS, Row, Verdict

#: Widths of published, computed, difference and verdict, in a wide and in a narrow table; the item
#: takes the remaining width, and each is wrapped.
_WIDE, _NARROW = (20, 24, 9, 18), (13, 14, 9, 13)
_GAP, _LEAST_WIDE = 2, 119


def _widths(width: int) -> tuple[int, ...]:
    others = _WIDE if width >= _LEAST_WIDE else _NARROW
    return (min(40, max(12, width - sum(others) - _GAP * len(others))), *others)


def _number(value: float | str, unit: str = "1") -> str:
    if isinstance(value, str):
        return value
    text = f"{value:.6g}"
    return text if unit == "1" else f"{text} {unit}"


def _difference(row: Row) -> str:
    if row.relative_difference is None:
        return ""
    percent = 100 * row.relative_difference
    # No paper prints so many digits; they would only show rounding.
    if abs(percent) < 1e-3:
        return "0 %"
    return f"{percent:+.2g} %" if abs(percent) < 99.5 else f"{percent:+.0f} %"


def _lines(row: Row, widths: tuple[int, ...]) -> list[str]:
    texts = (
        row.item,
        _number(row.published, row.unit),
        _number(row.computed, row.unit),
        _difference(row),
        row.verdict,
    )
    cells = [textwrap.wrap(text, width) or [""] for text, width in zip(texts, widths, strict=True)]
    lines = []
    for index in range(max(map(len, cells))):
        parts = [cell[index] if index < len(cell) else "" for cell in cells]
        padded = [part.ljust(width) for part, width in zip(parts, widths, strict=True)]
        lines.append((" " * _GAP).join(padded).rstrip())
    return lines


def details(row: Row) -> str:
    """Bounds and evidence of a row that differs, and the toolkit's own number, in one line."""

    def span(bounds: tuple[float, float], unit: str) -> str:
        low, high = (f"{value:.6g}" for value in bounds)
        end = high if unit == "1" else f"{high} {unit}"
        return f"{low} to {end}" if low != high else end

    parts = []
    if row.bounds is not None:
        parts.append(f"must stay within {span(row.bounds, row.unit)}")
    if row.evidence is not None and row.evidence_bounds is not None:
        allowed = span(row.evidence_bounds, "1")
        parts.append(f"evidence {row.evidence:.6g}, within {allowed}")
    if row.own is not None:
        parts.append(f"the toolkit's own model: {_number(row.own, row.unit)}")
    return "; ".join(parts)


def table(rows: Sequence[Row], width: int = 120) -> str:
    """The rows as a plain-text table, grouped by source, with the notes below their rows.

    A note that repeats the one before it is not printed again.

    **Arguments:**

    - `rows`: what `validate` returned, or some of it.
    - `width`: number of characters in a line, at least 70.
    """
    citations, widths = sources(), _widths(width)
    lines: list[str] = []
    source = note = None
    for row in rows:
        if row.source != source:
            source, note = row.source, None
            heading = f"{source}: {citations.get(source, '')}".rstrip(": ")
            header = ("item", "published", "computed", "differs", "verdict")
            padded = [n.ljust(w) for n, w in zip(header, widths, strict=True)]
            names = (" " * _GAP).join(padded).rstrip()
            lines += ["", *textwrap.wrap(heading, width), names, "-" * width]
        lines += _lines(row, widths)
        if said := details(row):
            lines += textwrap.wrap(said, width, initial_indent="    ", subsequent_indent="    ")
        if row.note and row.note != note:
            lines += textwrap.wrap(row.note, width, initial_indent="    ", subsequent_indent="    ")
        note = row.note
    return "\n".join(lines).lstrip("\n")


def markdown(rows: Sequence[Row]) -> str:
    """The rows as a Markdown table."""
    head = ("source", "item", "published", "computed", "difference", "verdict", "note")
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for row in rows:
        cells = (
            row.source,
            row.item,
            _number(row.published, row.unit),
            _number(row.computed, row.unit),
            _difference(row),
            row.verdict,
            f"{row.note} ({said})" if (said := details(row)) else row.note,
        )
        lines.append("| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |")
    return "\n".join(lines)


def summary(rows: Sequence[Row]) -> dict[str, dict[Verdict, int]]:
    """Number of rows with each verdict, by source and, under `"all"`, in total.

    Every verdict is a key of every count, so that a missing one reads 0.
    """
    counts = {name: dict.fromkeys(VERDICTS, 0) for name in (*(r.source for r in rows), "all")}
    for row in rows:
        counts[row.source][row.verdict] += 1
        counts["all"][row.verdict] += 1
    return counts
