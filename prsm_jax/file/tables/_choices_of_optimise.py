"""`choices` of the `[optimise]` table: lists of values, or a series of standard numbers."""

from typing import Any

from ..._errors import UnknownNameError
from ...mechanism import SERIES, Choice, Mechanism, Parameter, find_parameters, numbers_of_series
from ..numbers import Misplaced, Place, read_integer, read_number
from ._table import Key, plain, read_choice, read_keys

# Limits are read when the parameter's unit is known.
_SERIES = {
    "series": Key(plain(read_choice, SERIES), "series: modules, leads, R5, R10, R20 or R40"),
    "lower": Key(lambda value, _: value, "lower limit"),
    "upper": Key(lambda value, _: value, "upper limit"),
}


def read_choices(value: Any, place: Place) -> dict[str, Any]:
    """The values of each choice, not yet in SI: a list, or series and limits.

    **Raises:** `Misplaced` for anything else.
    """
    if not isinstance(value, dict) or not value:
        words = "must be a table of lists, such as { roller_count = [8, 9, 10] }"
        raise Misplaced((place, words))
    for name, one in value.items():
        if isinstance(one, dict):
            read_keys(one, (*place, name), _SERIES)
        elif not isinstance(one, list) or not one:
            words = 'must be a list of values, or { series = "modules", lower = …, upper = … }'
            raise Misplaced(((*place, name), words))
    return value


def choice_of(
    name: str, values: Any, mechanism: Mechanism, taken: dict[str, str], place: Place
) -> Choice:
    """One choice with its values in SI.

    **Arguments:**

    - `name`, `values`: as `read_choices` returns them.
    - `mechanism`: the mechanism whose parameter is named.
    - `taken`: names of variables and choices by the path of what they set; this one is added.
    - `place`: of the values.

    **Raises:** `Misplaced` for a name or values that make no sense.
    """
    try:
        parameters = find_parameters(mechanism, name)
    except UnknownNameError as error:
        raise Misplaced((place, str(error))) from error
    for parameter in parameters:
        if parameter.path in taken:
            raise Misplaced((place, f"moves the same number as {taken[parameter.path]!r}"))
        taken[parameter.path] = name
    if isinstance(values, list):
        numbers = _listed(values, parameters[0], place)
    else:
        numbers = _of_series(values, parameters[0], place)
    try:
        return Choice(name, numbers)
    except ValueError as error:
        raise Misplaced((place, str(error))) from error


def _listed(values: list[Any], of: Parameter, place: Place) -> tuple[float, ...]:
    try:
        if of.static:
            return tuple(float(read_integer(value, of.limit)) for value in values)
        return tuple(read_number(value, of.unit, of.limit) for value in values)
    except ValueError as error:
        raise Misplaced((place, str(error))) from error


def _of_series(table: dict[str, Any], of: Parameter, place: Place) -> tuple[float, ...]:
    series = table["series"]
    if of.static:
        raise Misplaced((place, "is a whole number, and a series is of real numbers; list values"))
    if "rad" in of.unit:
        raise Misplaced(
            (place, "is an angle or a speed of rotation, without a series; list values")
        )
    if series in ("modules", "leads") and of.unit != "m":
        raise Misplaced((place, f'the series "{series}" has lengths; list values, or name R10'))
    reader = Key(plain(read_number, of.unit, of.limit))
    limits = read_keys(
        {side: table[side] for side in ("lower", "upper")},
        place,
        {"lower": reader, "upper": reader},
    )
    try:
        return numbers_of_series(series, limits["lower"], limits["upper"])
    except ValueError as error:
        raise Misplaced((place, str(error))) from error
