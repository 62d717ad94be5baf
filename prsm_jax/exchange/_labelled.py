"""Numbers of a result with their names, units and dimensions, for files of other programs."""

import dataclasses
import typing
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..fields import declared, members, units_of
from ..programs import is_known
from ..results import Result

#: SI units of fields that results do not print, and that therefore declare none.
_NOT_PRINTED = {
    "efficiency": "1",
    "stage_torque": "N·m",
    "carrier_acceleration": "rad/s²",
    "screw_acceleration": "rad/s²",
    "newton_residual": "1",
    "slip_direction": "1",
    "bristle_power": "W",
    "bristle_deflection": "m",
    "sticking": "1",
    "valid": "1",
    "code": "1",
    "solved": "1",
}
_PLAIN_UNIT = str.maketrans({"·": " ", "²": "^2", "³": "^3", "µ": "u"})


@dataclasses.dataclass(frozen=True)
class Labelled:
    """An array of a result, in SI.

    - `path`: its name, after the names of the parts that it belongs to.
    - `values`: the numbers.
    - `unit`: in ASCII, such as `N m` or `rad/s^2`; `1` without unit.
    - `dimensions`: what its axes run over, such as `stage`, `time`.
    """

    path: tuple[str, ...]
    values: np.ndarray
    unit: str
    dimensions: tuple[str, ...]


def labelled(result: Result) -> list[Labelled]:
    """All numbers of a result of one design whose units are known, in the order of its fields.

    **Arguments:**

    - `result`: the result.

    **Raises:** `ValueError` for a batch of designs, and inside a trace.
    """
    what = type(result).__name__
    if not isinstance(result, Result):
        raise ValueError(f"a {what} has no named numbers with units; give a result, such as a run")
    if not is_known(result):
        raise ValueError(f"this {what} is traced; write files outside of jax.jit and jax.grad")
    if result.batch_shape:
        raise ValueError(
            f"this {what} is of {result.batch_shape} designs; write a file for each of them"
        )
    return list(_numbers(result, ()))


def _numbers(result: Any, above: tuple[str, ...]) -> Iterator[Labelled]:
    units = _NOT_PRINTED | dict(units_of(type(result)))
    for field in declared(type(result)):
        value, path = getattr(result, field.name), (*above, field.name)
        if isinstance(value, Result):
            yield from _numbers(value, path)
        elif value is not None and field.name in units:
            unit = units[field.name].translate(_PLAIN_UNIT)
            parts = value.items() if isinstance(value, dict) else [(None, value)]
            for key, part in parts:
                array = np.asarray(part)
                inner = path if key is None else (*path, str(key))
                yield Labelled(inner, array, unit, _dimensions(field.hint, array.ndim))


def _dimensions(hint: Any, count: int) -> tuple[str, ...]:
    """Names of the axes, from an annotation such as `Float[Array, "stages times"]`."""
    inner = [one for member in members(hint) for one in (member, *typing.get_args(member))]
    words = next((one.dim_str.split() for one in inner if hasattr(one, "dim_str")), [])
    names = ["component" if word.isdigit() else word.removesuffix("s") for word in words]
    return tuple(names) if len(names) == count else tuple(f"axis_{k}" for k in range(count))


def words_of(result: Any) -> dict[str, str]:
    """What a result says about itself in words: the method, and how it ended."""
    solver = getattr(result, "solver", result)
    found = {"method": getattr(solver, "name", None), "outcome": getattr(solver, "result", None)}
    return {name: words for name, words in found.items() if isinstance(words, str)}
