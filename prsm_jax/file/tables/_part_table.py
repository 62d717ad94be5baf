"""Reading the table of any part of a mechanism, from the fields that its class declares."""

from typing import Any

import equinox as eqx
import numpy as np

from ...fields import ANY, Contradiction, Declared, declared
from ..numbers import (
    Misplaced,
    Place,
    TableChoice,
    read_integer,
    read_number,
    read_numbers,
    table_choices,
    tag_of,
    takes_numbers,
    usual_law,
)
from ._table import Key, plain, read_boolean, read_choice, read_keys, read_rows, read_text

#: The kind of a plain number as one of several loads.
NUMBER = "number"


def read_value(one: Declared, value: Any, place: Place, outer: str = "1") -> Any:
    """The value of a field.

    **Arguments:**

    - `one`: the field.
    - `value`: in the file.
    - `place`: of the value in the file.
    - `outer`: SI unit of the function to which the field belongs.

    **Raises:** `ValueError` with what is allowed, or `Misplaced` with the places of all errors.
    """
    unit = one.unit or outer
    if one.element is not None:
        return read_rows(value, place, lambda row, at: _read_part(one.element, row, at, unit))
    if one.classes and (one.unit is None or isinstance(value, dict)):
        return _read_part(one.hint, value, place, unit)
    if one.is_list:
        return np.array(read_numbers(value, unit, one.limit, one.least))
    if one.unit is not None:
        return read_number(value, unit, one.limit)
    if one.whole:
        return read_integer(value, one.limit)
    if one.words:
        return read_choice(value, one.words)
    return read_boolean(value) if one.hint is bool else read_text(value)


def _read_part(hint: Any, data: Any, place: Place, unit: str) -> Any:
    choices, tag = table_choices(hint, unit), tag_of(hint)
    if not isinstance(data, dict):
        raise Misplaced((place, "must be a table of keys"))
    if "" in choices:
        return read_module(choices[""], data, place, unit)
    name = data.get(tag, usual_law(hint))
    if name == NUMBER and takes_numbers(hint):
        keys = {tag: Key(plain(read_text)), "value": Key(plain(read_number, unit, ANY), "number")}
        return np.asarray(read_keys(data, place, keys)["value"])
    if name is None:
        words = ", ".join(f'"{word}"' for word in choices)
        raise Misplaced(((*place, tag), f"is missing; choose one of {words}"))
    try:
        choice = choices[read_choice(name, tuple(choices))]
    except ValueError as error:
        raise Misplaced(((*place, tag), str(error))) from error
    return read_module(choice, data, place, unit, tag)


def read_module(
    choice: TableChoice, data: Any, place: Place, unit: str = "1", tag: str | None = None
) -> eqx.Module:
    """The part of the mechanism that a table describes.

    **Arguments:**

    - `choice`: its class.
    - `data`: the table.
    - `place`: of the table in the file.
    - `unit`: SI unit of the values of a function.
    - `tag`: the key that names the class, if there is one.

    **Raises:** `Misplaced` with the places of all errors.
    """
    keys = {} if tag is None else {tag: Key(plain(read_text))}
    for one in choice.fields(unit):
        keys[one.name] = Key(
            lambda value, at, one=one: read_value(one, value, at, unit),
            meaning(one) if choice.needs(one) else None,
        )
    values = read_keys(data, place, keys)
    values.pop(tag or "", None)
    try:
        if choice.law is not None:
            own = {one.name for one in declared(choice.law)} & values.keys()
            values["law"] = choice.law(**{name: values.pop(name) for name in own})
        return choice.cls(**values)
    except Contradiction as error:
        raise Misplaced(((*place, *error.place), error.message)) from error
    except ValueError as error:
        raise Misplaced((place, str(error))) from error


def meaning(one: Declared) -> str:
    """What to give for a field, with its unit."""
    named = one.description and one.unit not in (None, "1")
    return f"{one.description} [{one.unit}]" if named else one.description
