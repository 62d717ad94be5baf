"""The `[tolerances]` table: permissible deviations of numbers by their names, and their cost."""

from typing import Any

from ..._errors import UnknownNameError
from ...fields import ANY, POSITIVE, Limit
from ...mechanism import (
    DISTRIBUTIONS,
    Mechanism,
    Parameter,
    Tolerance,
    check_tolerance,
    find_parameters,
)
from ..numbers import Misplaced, Place, is_plain_number, read_number, refuse_shares
from ._table import Key, plain, read_choice, read_keys, read_name

_SIGNS = ("±", "+/-", "+-")
_SIDES = ("lower", "upper")
_FORMS = 'give "±0.02 mm" or { lower = "-0.01 mm", upper = "0.03 mm" }'


def read_tolerances(data: Any, place: Place) -> dict[str, Any]:
    """The table as it stands; units are read when its names have been looked up.

    **Raises:** `Misplaced` if it is no table, is empty, or has a name that cannot be one.
    """
    if not isinstance(data, dict):
        raise Misplaced((place, "must be a table of keys"))
    if not set(data) - {"cost"}:
        raise Misplaced((place, f"is empty; for the name of a number {_FORMS}"))
    for name, value in data.items():
        try:
            read_name(name)
        except ValueError as error:
            raise Misplaced(((*place, name), str(error))) from error
        if name != "cost" and isinstance(value, dict) and not set(value) & set(_SIDES):
            raise Misplaced(((*place, name), f"{_FORMS}; a name with dots needs quotes"))
    return data


def _read_side(value: Any, unit: str, limit: Limit) -> float:
    refuse_shares(value)
    return read_number(value, unit, limit)


def _symmetric(value: Any, unit: str) -> float:
    """Half the width of a symmetric tolerance: `"±0.02 mm"`, or a bare number in SI."""
    refuse_shares(value)
    if isinstance(value, str):
        sign = next((sign for sign in _SIGNS if value.strip().startswith(sign)), None)
        if sign is None:
            raise ValueError(f"not a tolerance; {_FORMS}")
        text = value.strip()[len(sign) :].strip()
        value = float(text) if unit == "1" and is_plain_number(text) else text
    return read_number(value, unit, POSITIVE)


def _fields(value: Any, unit: str, place: Place) -> dict[str, Any]:
    if not isinstance(value, dict):
        try:
            half = _symmetric(value, unit)
        except ValueError as error:
            raise Misplaced((place, str(error))) from error
        return {"lower": -half, "upper": half}
    side = plain(_read_side, unit, ANY)
    keys = {
        **{one: Key(side, f"{one} deviation") for one in _SIDES},
        "distribution": Key(plain(read_choice, DISTRIBUTIONS)),
        "sigmas": Key(plain(read_number, "1", POSITIVE)),
    }
    return read_keys(value, place, keys)


def _find(mechanism: Mechanism, name: str, place: Place) -> tuple[Parameter, ...]:
    try:
        return find_parameters(mechanism, name)
    except UnknownNameError as error:
        raise Misplaced((place, str(error))) from error


def _tolerance(
    name: str, value: Any, cost: float | None, parameters: tuple[Parameter, ...], mechanism
) -> Tolerance:
    place = ("tolerances", name)
    fields = _fields(value, parameters[0].unit, place)
    if cost is not None:
        fields["cost"] = cost
    try:
        tolerance = Tolerance(name, **fields)
        check_tolerance(mechanism, tolerance, parameters)
    except ValueError as error:
        message = str(error).removeprefix(f"tolerance {name!r}: ")
        raise Misplaced((place, message)) from error
    return tolerance


def tolerances_of(table: dict[str, Any], mechanism: Mechanism) -> tuple[Tolerance, ...]:
    """The tolerances of a `[tolerances]` table.

    **Arguments:**

    - `table`: its keys, as `read_tolerances` returns them.
    - `mechanism`: the mechanism whose numbers have the tolerances.

    **Raises:** `Misplaced` for a name, deviation or cost that makes no sense, with its place.
    """
    rows = {name: value for name, value in table.items() if name != "cost"}
    cost_key = Key(plain(read_number, "1", POSITIVE))
    costs = read_keys(table.get("cost", {}), ("tolerances", "cost"), dict.fromkeys(rows, cost_key))
    taken: dict[str, str] = {}
    tolerances, problems = [], []
    for name, value in rows.items():
        place = ("tolerances", name)
        try:
            parameters = _find(mechanism, name, place)
            for parameter in parameters:
                if parameter.path in taken:
                    message = f"sets the same number as {taken[parameter.path]!r}"
                    raise Misplaced((place, message))
                taken[parameter.path] = name
            tolerances.append(_tolerance(name, value, costs.get(name), parameters, mechanism))
        except Misplaced as error:
            problems += error.problems
    if problems:
        raise Misplaced(*problems)
    return tuple(tolerances)
