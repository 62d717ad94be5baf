"""Markdown tables, and what stands in their cells."""

from collections.abc import Iterable, Sequence
from typing import Any


def row_of(cells: Iterable[str]) -> str:
    """A line of a table."""
    return "| " + " | ".join(cells) + " |"


def table_of(heads: Sequence[str], rows: Iterable[Iterable[str]] = ()) -> list[str]:
    """The lines of a table."""
    return [row_of(heads), row_of(["---"] * len(heads)), *map(row_of, rows)]


def time_text(seconds: float) -> str:
    """A time with three digits in a unit that fits."""
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if seconds * factor >= 1:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def setting_text(name: str, value: Any) -> str:
    """Name and value of a setting; empty without one."""
    if value is None:
        return ""
    return f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}"
