"""Cells of the report's tables as numbers with units, for programs that calculate."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ..report import Table
from ..text import MINUS, UNIT_LABELS, NumberText

#: Units that the report writes beside those of the display units.
_UNITS = UNIT_LABELS | {"°", "GPa"}
_NUMBER = re.compile(
    r"(?P<relation>at most |at least |equal to |[≤≥<>±]\s?)?"
    r"(?P<digits>[-+]?\d+(?:\.(?P<decimals>\d+))?)"
    r"(?:·10(?P<power>[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?"
    r"(?P<unit>\s?\S+)?"
)
_POWERS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


@dataclass(frozen=True)
class NumberCell:
    """A number with its unit (empty if none), a relation (`at most`), and how it was printed.

    `signed`: whether a sign is printed in front of positive numbers too.
    """

    value: float
    unit: str
    relation: str
    decimals: int
    exponent: bool
    signed: bool = False


@dataclass(frozen=True)
class Column:
    """A column of a sheet: its heading with the unit, if all its numbers have the same."""

    heading: str
    cells: tuple[NumberCell | str, ...]


def number_cell(text: str) -> NumberCell | None:
    """The number of a cell, whole if the text carries it, else as printed.

    **Returns:** `None` if the cell holds anything else.
    """
    match = _NUMBER.fullmatch(text.replace(MINUS, "-").strip())
    if match is None:
        return None
    unit, power = (match["unit"] or "").strip(), match["power"] or ""
    relation, value = (match["relation"] or "").strip(), 0.0
    if isinstance(text, NumberText):
        value, unit, relation = text.value, text.unit, text.relation
    elif unit and unit not in _UNITS:
        return None
    else:
        value = float(match["digits"] + (f"e{power.translate(_POWERS)}" if power else ""))
    signed, decimals = match["digits"].startswith("+"), len(match["decimals"] or "")
    return NumberCell(value, unit, relation, decimals, bool(power), signed)


def _split_heading(heading: str) -> tuple[str, str]:
    """Name and unit of a heading such as "contact radius in mm"."""
    name, _, unit = heading.rpartition(" in ")
    return (name, unit) if name and unit in _UNITS else (heading, "")


def columns_of(table: Table, numbers: bool = True) -> list[Column]:
    """The columns of a table: numbers as numbers, units in headings.

    Numbers of several units get a column of their own for the units, and relations ("at most")
    another.

    **Arguments:**

    - `table`: the table, as it is printed.
    - `numbers`: false to keep everything as text, where digits are no number (versions).
    """
    names = [head or ("name" if index == 0 else "value") for index, head in enumerate(table.head)]
    columns = []
    for index, head in enumerate(names):
        texts = [row[index] for row in table.rows]
        parsed = [number_cell(text) if numbers else None for text in texts]
        columns += _columns(head, texts, parsed)
    return columns


def _columns(head: str, texts: Sequence[str], parsed: Sequence[NumberCell | None]) -> list[Column]:
    name, unit = _split_heading(head)
    found = [one for one in parsed if one is not None]
    cells = tuple(text if one is None else one for text, one in zip(texts, parsed, strict=True))
    units = {one.unit for one in found}
    several = len(units) > 1 or (units - {""} and unit)
    if not several:
        unit = unit or next(iter(units), "")
    columns = [Column(f"{name} [{unit}]" if unit else name, cells)]
    if several:
        labels = tuple("" if one is None else one.unit for one in parsed)
        columns.append(Column("unit" if name == "value" else f"unit of {name}", labels))
    if any(one.relation for one in found):
        relations = tuple("" if one is None else one.relation for one in parsed)
        columns.append(Column(f"{name} is", relations))
    return columns
