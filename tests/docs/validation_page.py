"""`python -m tests.docs.validation_page`: writes docs/validation.md from `prsm validate`."""

from collections.abc import Sequence
from pathlib import Path

from prsm_jax.validation import Row, sources, summary, validate
from prsm_jax.validation._table import _difference, _number, details

PAGE = Path(__file__).parents[2] / "docs" / "validation.md"

_HEAD = """\
# Validation: published numbers beside computed ones

This page is written by `python -m tests.docs.validation_page`; a test compares it with what
`prsm validate` computes. Do not edit it by hand. [Published numbers,
explained](published_tables.md) has the meaning of the verdicts, and discusses the rows that matter
most. The papers give no measurements, so no row compares with one.

"""
_COLUMNS = ("item", "published", "computed", "difference", "verdict")


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", r"\|").replace("*", r"\*") for cell in cells) + " |"


def _counts(rows: Sequence[Row]) -> list[str]:
    lines = [_line(("source", "rows", "verdicts")), "|---|---|---|"]
    for name, verdicts in summary(rows).items():
        said = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items() if count)
        lines.append(_line((name, str(sum(verdicts.values())), said)))
    return lines


def _section(name: str, citation: str, rows: Sequence[Row]) -> list[str]:
    lines = ["", f"## {name}", "", f"{citation}.", "", _line(_COLUMNS), "|---" * 5 + "|"]
    notes: dict[str, int] = {}
    for row in rows:
        note = f"{row.note} ({said})" if (said := details(row)) else row.note
        mark = f" [{notes.setdefault(note, len(notes) + 1)}]" if note else ""
        published, computed = (_number(value, row.unit) for value in (row.published, row.computed))
        lines.append(_line((row.item, published, computed, _difference(row), row.verdict + mark)))
    if notes:
        lines.append("")
        lines += [f"{k}. {note.replace('*', chr(92) + '*')}" for note, k in notes.items()]
    return lines


def page(rows: Sequence[Row]) -> str:
    """The page of these rows."""
    lines = _counts(rows)
    for name, citation in sources().items():
        lines += _section(name, citation, [row for row in rows if row.source == name])
    return _HEAD + "\n".join(lines) + "\n"


def main() -> int:
    """Write the page."""
    PAGE.write_text(page(validate()), encoding="utf-8")
    print(PAGE.relative_to(PAGE.parents[1]))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
