"""Reading tables: known keys only, and everything that is wrong in one error."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar

from ..._errors import closest
from ..numbers import Misplaced, Place

_LONGEST_KEY = 100
_Row = TypeVar("_Row")


class Key(NamedTuple):
    """A key of a table.

    - `read`: from value and place; it raises `ValueError` with what is allowed, or `Misplaced`.
    - `meaning`: what to give for a key that the table needs; `None` if it may be absent.
    """

    read: Callable[[Any, Place], Any]
    meaning: str | None = None


def plain(read: Callable, *args: Any) -> Callable[[Any, Place], Any]:
    """A reader that does not need the place."""
    return lambda value, place: read(value, *args)


def read_keys(data: Any, place: Place, keys: Mapping[str, Key]) -> dict[str, Any]:
    """The values of the keys that a table has.

    **Raises:** `Misplaced` if it is no table, has an unknown key, or lacks one; else with all
    values that are wrong.
    """
    if not isinstance(data, dict):
        raise Misplaced((place, "must be a table of keys"))
    for key in data:
        if key not in keys:
            known = [name for name in keys if name not in data]
            hint = closest(key, known or keys, keys) if len(key) < _LONGEST_KEY else ""
            raise Misplaced(((*place, key), f"unknown key; {hint}"))
    for name, key in keys.items():
        if key.meaning is not None and name not in data:
            give = f"; give the {key.meaning}" if key.meaning else ""
            raise Misplaced(((*place, name), f"is missing{give}"))
    given = {name: key for name, key in keys.items() if name in data}
    return dict(
        zip(given, _all([(k.read, data[n], (*place, n)) for n, k in given.items()]), strict=True)
    )


def read_rows(value: Any, place: Place, read: Callable[[Any, Place], _Row]) -> tuple[_Row, ...]:
    """The rows of an array of tables.

    **Raises:** `Misplaced` if it is not one or is empty; else with all that is wrong in its rows.
    """
    if not isinstance(value, list) or not all(isinstance(row, dict) for row in value):
        raise Misplaced((place, "must be tables, each under a header in double brackets"))
    if not value:
        raise Misplaced((place, "is empty; give at least one table"))
    return tuple(_all([(read, row, (*place, index)) for index, row in enumerate(value)]))


def _all(readings: list[tuple[Callable[[Any, Place], Any], Any, Place]]) -> list:
    values, problems = [], []
    for read, value, place in readings:
        try:
            values.append(read(value, place))
        except Misplaced as error:
            problems += error.problems
        except ValueError as error:
            problems.append((place, str(error)))
    if problems:
        raise Misplaced(*problems)
    return values


def read_text(value) -> str:
    """A string. **Raises:** `ValueError` if it is anything else."""
    if not isinstance(value, str):
        raise ValueError("must be a string")
    return value


def read_name(value) -> str:
    """A name of this package's vocabulary. **Raises:** `ValueError` if it cannot be one."""
    if not (isinstance(value, str) and len(value) <= _LONGEST_KEY):
        raise ValueError("must be a name, as a string")
    if not value.isascii() or not value.replace("_", "").replace(".", "").isalnum():
        raise ValueError("must be a name of letters, digits, _ and .")
    return value


def read_boolean(value) -> bool:
    """True or false. **Raises:** `ValueError` if it is anything else."""
    if not isinstance(value, bool):
        raise ValueError("must be true or false")
    return value


def read_choice(value, allowed: tuple[str, ...]) -> str:
    """One of several words. **Raises:** `ValueError` if it is none of them."""
    if not isinstance(value, str) or value not in allowed:
        choices = ", ".join(f'"{name}"' for name in allowed)
        raise ValueError(f"choose one of {choices}")
    return value
