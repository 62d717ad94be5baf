"""The `[scenario]` table: drive of the screw, load on the nut, and duration.

Its functions are tables with a key `kind`; their keys are the fields of the class of that kind.
"""

import dataclasses
import typing
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..._errors import closest
from ...fields import ANY, limit_of
from ...scenario import LOADS_OF_MOTION, PROFILES, Scenario, TorqueScenario
from ..numbers import Misplaced, Place, read_integer, read_number
from ._table import read_boolean, read_choice

#: The kind of a plain number as one of several loads.
NUMBER = "number"


def kinds_of(unit: str) -> dict[str, type]:
    """Classes of functions with values of this unit, by the key `kind`."""
    kinds = dict(PROFILES)
    if unit != "rad/s":
        kinds = {name: cls for name, cls in kinds.items() if not name.endswith("_move")}
    return kinds | LOADS_OF_MOTION if unit == "N" else kinds


def scenario_of(data: object) -> Scenario | TorqueScenario:
    """The scenario of a table.

    **Raises:** `Misplaced` at the first error.
    """
    place = ("scenario",)
    if not isinstance(data, dict):
        raise Misplaced(place, "must be a table of keys")
    drives = [name for name in ("speed", "torque") if name in data]
    if len(drives) != 1:
        text = "both" if drives else "none"
        raise Misplaced(place, f"needs either speed or torque; found {text}")
    cls = Scenario if drives == ["speed"] else TorqueScenario
    return _module(cls, data, place, "1")


def _module(cls: type, data: Mapping[str, Any], place: Place, unit: str):
    fields = {field.name: field for field in dataclasses.fields(cls)}
    hints = typing.get_type_hints(cls)
    for key in data:
        if key not in fields and key != "kind":
            raise Misplaced((*place, key), f"unknown key; {closest(str(key)[:99], fields)}")
    values = {}
    for name, field in fields.items():
        if name in data:
            values[name] = _value(field, hints[name], data[name], (*place, name), unit)
        elif field.default is dataclasses.MISSING:
            meaning = field.metadata.get("description")
            raise Misplaced(
                (*place, name), "is missing" + (f"; give the {meaning}" if meaning else "")
            )
    try:
        return cls(**values)
    except ValueError as error:
        raise Misplaced(place, str(error)) from error


def _value(field: dataclasses.Field[Any], hint, value, place: Place, outer: str):
    unit = field.metadata.get("unit")
    unit = outer if unit == "*" else unit
    limit = limit_of(unit or "1", field.metadata.get("limit"))
    try:
        if field.name == "part":
            return _parts(value, place, outer)
        if field.metadata.get("list"):
            if not isinstance(value, list) or len(value) < 2:
                raise ValueError("must be an array of two or more numbers")
            return np.array([read_number(one, unit, limit) for one in value])
        if isinstance(value, dict) and unit is not None and not _is_number(hint):
            return _function(value, place, unit)
        if unit is not None:
            return read_number(value, unit, limit)
        if hint is bool:
            return read_boolean(value)
        if hint is int:
            return read_integer(value, limit)
        return read_choice(value, typing.get_args(hint))
    except ValueError as error:
        raise Misplaced(place, str(error)) from error


def _is_number(hint) -> bool:
    """Whether a field takes numbers only."""
    members = typing.get_args(hint) or (hint,)
    return not any(isinstance(member, type) and hasattr(member, "kind") for member in members)


def _parts(value, place: Place, unit: str) -> tuple[Any, ...]:
    if not isinstance(value, list) or not all(isinstance(row, dict) for row in value):
        raise ValueError("must be tables, each under a header in double brackets")
    return tuple(_function(row, (*place, index), unit) for index, row in enumerate(value))


def _function(data: Mapping[str, Any], place: Place, unit: str):
    kinds = kinds_of(unit)
    choices = ", ".join(f'"{name}"' for name in kinds)
    in_sum = isinstance(place[-1], int) and unit == "N"
    if "kind" not in data:
        raise Misplaced((*place, "kind"), f"is missing; choose one of {choices}")
    kind = data["kind"]
    if in_sum and kind == NUMBER:
        return _number(data, place, unit)
    if not isinstance(kind, str) or kind not in kinds:
        raise Misplaced((*place, "kind"), f"choose one of {choices}")
    return _module(kinds[kind], data, place, unit)


def _number(data: Mapping[str, Any], place: Place, unit: str) -> np.ndarray:
    if set(data) != {"kind", "value"}:
        raise Misplaced(place, "a number has the keys kind and value")
    try:
        return np.asarray(read_number(data["value"], unit, ANY))
    except ValueError as error:
        raise Misplaced((*place, "value"), str(error)) from error
