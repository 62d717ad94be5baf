"""Hints for names that a mechanism does not have: the table of a file, or names like it."""

import functools
from collections.abc import Iterator, Set

from ..._errors import closest
from ...fields import declared
from .._mechanism import Mechanism

#: Table of a file by the field of a mechanism that names can begin with.
_TABLES = {"stages": "stage", "operating_point": "operating_point", "axis": "axis"}


def _numbers(cls: type, table: str, unit: str = "1") -> Iterator[tuple[str, str]]:
    """Table and key of every number and word that a class declares, present or not."""
    for one in declared(cls, unit):
        for part in one.classes:
            # The numbers of a law may stand in the table of its owner.
            inner = table if one.units is not None else f"{table}.{one.name}"
            yield from _numbers(part, inner, one.unit or unit)
        if not one.classes and not one.is_list and (one.unit or one.whole or one.words):
            yield table, one.name


@functools.cache
def _declared_numbers() -> tuple[tuple[str, str], ...]:
    fields = {one.name: one for one in declared(Mechanism)}
    found = dict.fromkeys(
        number
        for field, table in _TABLES.items()
        for cls in (fields[field].classes or _elements(fields[field].element))
        for number in _numbers(cls, table)
    )
    return tuple(found)


def _elements(element: type | None) -> tuple[type, ...]:
    return () if element is None else (element,)


def hint_of(name: str, paths: Set[str]) -> str:
    """What to do about a name that no parameter has.

    **Arguments:**

    - `name`: as in `find_parameters`.
    - `paths`: of the parameters that the mechanism has, without numbers of stages.

    **Returns:** the table of a file that would give it, if there is one; else names like it, or
    all names.
    """
    head, _, rest = name.partition(".")
    number, _, ending = rest.partition(".")
    ending = ending if head == "stage" and number.isdigit() else name
    places = [
        (table, key)
        for table, key in _declared_numbers()
        if f".{table}.{key}".endswith(f".{ending}")
    ]
    if places:
        tables = dict.fromkeys(f"[{table}]" for table, _ in places)
        given = f"first give {places[0][1]} in {' or '.join(tables)}"
        return f"the mechanism does not have it; {given}"
    return closest(name, paths | {path.rsplit(".", 1)[1] for path in paths})
