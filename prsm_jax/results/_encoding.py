"""Results as JSON and plain arrays, and back; nothing but numbers, words and known classes.

A class is written by its room and name. Reading looks the name up among the classes that the
package has; it imports only rooms of the package, calls no constructor, and so runs no code that a
file could choose.
"""

import dataclasses
import functools
import importlib
import math
import pkgutil
import re
import sys
from collections.abc import Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from ..fields import Count

_PACKAGE = __name__.partition(".")[0]
#: Kinds of NumPy's dtypes that files hold: truths, numbers, complex numbers.
KINDS = "biufc"


class NotKept(ValueError):
    """What a file cannot hold, or does not hold."""


def encode(value: Any, place: str, arrays: dict[str, np.ndarray]) -> Any:
    """A value as JSON; its arrays are added to a dictionary by their places.

    **Arguments:**

    - `value`: the value.
    - `place`: where it stands, such as `losses.spin`.
    - `arrays`: receives the arrays.

    **Raises:** `NotKept` for a function, and for a class that is not of this package.
    """
    # First: a number of NumPy is a Python number as well.
    if isinstance(value, jax.Array | np.ndarray | np.generic):
        return _array(value, place, arrays)
    if isinstance(value, Count):
        return {"count": int(value)}
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else {"float": str(value)}
    if isinstance(value, Mapping):
        pairs = [
            [encode(key, place, arrays), encode(one, _inner(place, key), arrays)]
            for key, one in value.items()
        ]
        return {"dict": pairs}
    names = _fields_of(value)
    if names is not None:
        fields = {name: encode(getattr(value, name), _inner(place, name), arrays) for name in names}
        return {"class": _name_of(type(value), place), "fields": fields}
    if isinstance(value, list | tuple):
        kind = "list" if isinstance(value, list) else "tuple"
        return {kind: [encode(one, _inner(place, k), arrays) for k, one in enumerate(value, 1)]}
    what = getattr(value, "__name__", type(value).__name__)
    raise NotKept(f"{place or 'it'} is {what}, which a file cannot hold: only numbers and words")


def _inner(place: str, name: object) -> str:
    return f"{place}.{name}" if place else str(name)


def _array(value: Any, place: str, arrays: dict[str, np.ndarray]) -> dict[str, Any]:
    if isinstance(value, Tracer):
        raise NotKept(f"{place} is traced: save results outside of jax.jit, jax.vmap and jax.grad")
    array = np.asarray(value)
    if array.dtype.kind not in KINDS or not array.dtype.isnative:
        raise NotKept(f"{place} is an array of {array.dtype}; a file holds numbers only")
    name = re.sub(r"[^\w.-]", "_", place)[:100] or "values"
    while name in arrays:
        name += "_"
    arrays[name] = array
    kind = "jax" if isinstance(value, jax.Array) else "numpy"
    return {"array": name, "of": kind if isinstance(value, jax.Array | np.ndarray) else "scalar"}


def _fields_of(value: Any) -> tuple[str, ...] | None:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return tuple(field.name for field in dataclasses.fields(value))
    return getattr(type(value), "_fields", None) if isinstance(value, tuple) else None


def _name_of(cls: type, place: str) -> str:
    """Room and name of a class at a door; else the names of its modules, too."""
    package, _, inner = cls.__module__.partition(".")
    if package != _PACKAGE:
        raise NotKept(
            f"{place or 'it'} is of the class {cls.__module__}.{cls.__qualname__}, which is not of "
            f"{_PACKAGE}; a file cannot hold it"
        )
    room = inner.partition(".")[0]
    door = importlib.import_module(f"{_PACKAGE}.{room}")
    at_door = vars(door).get(cls.__name__) is cls
    return f"{room}.{cls.__name__}" if at_door else f"{inner}.{cls.__qualname__}"


def decode(written: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    """The value of `encode`.

    **Arguments:**

    - `written`: what `encode` returned.
    - `arrays`: the arrays by name.

    **Raises:** `NotKept` for anything that `encode` does not write, an unknown class, and other
    fields than the class has.
    """
    if written is None or isinstance(written, bool | int | float | str):
        return written
    if not isinstance(written, dict):
        raise NotKept("its header is damaged")
    match written:
        case {"float": "nan" | "inf" | "-inf" as word}:
            return float(word)
        case {"count": int(number)}:
            return Count(number)
        case {"array": str(name), "of": str(kind)} if name in arrays:
            array = arrays[name]
            return {"jax": jnp.asarray, "scalar": lambda one: one[()]}.get(kind, np.array)(array)
        case {"dict": list(pairs)}:
            return {decode(key, arrays): decode(value, arrays) for key, value in pairs}
        case {"list": list(rows)}:
            return [decode(row, arrays) for row in rows]
        case {"tuple": list(rows)}:
            return tuple(decode(row, arrays) for row in rows)
        case {"class": str(name), "fields": dict(fields)}:
            return _made(_class_of(name), {k: decode(v, arrays) for k, v in fields.items()})
        case _:
            raise NotKept("its header is damaged")


def _made(cls: Any, fields: dict[str, Any]) -> Any:
    """An object with these fields; its constructor does not run, nor do its checks."""
    named = tuple(f.name for f in dataclasses.fields(cls)) if _is_dataclass(cls) else cls._fields
    if set(named) != set(fields):
        other = ", ".join(sorted(set(named) ^ set(fields)))
        raise NotKept(f"its {cls.__name__} has other fields than in this version: {other}")
    if not _is_dataclass(cls):
        return tuple.__new__(cls, [fields[name] for name in named])
    one = object.__new__(cls)
    for name in named:
        object.__setattr__(one, name, fields[name])
    return one


def _is_dataclass(cls: Any) -> bool:
    return dataclasses.is_dataclass(cls)


def _class_of(name: str) -> type:
    room = name.partition(".")[0]
    found = _classes_of(room).get(name) if room in _rooms() else None
    if found is None:
        raise NotKept(f"this version has no class {name[:100]!r}")
    return found


@functools.cache
def _rooms() -> frozenset[str]:
    """The rooms of the package that are there."""
    places = sys.modules[_PACKAGE].__path__
    return frozenset(one.name for one in pkgutil.iter_modules(places) if one.ispkg)


@functools.cache
def _classes_of(room: str) -> dict[str, type]:
    """Classes with fields that the modules of a room define, by the names of `_name_of`."""
    importlib.import_module(f"{_PACKAGE}.{room}")
    start = f"{_PACKAGE}.{room}"
    classes: dict[str, type] = {}
    for module in [name for name in sys.modules if f"{name}.".startswith(f"{start}.")]:
        for cls in list(vars(sys.modules[module]).values()):
            fits = isinstance(cls, type) and cls.__module__ == module
            if fits and (
                _is_dataclass(cls) or (issubclass(cls, tuple) and hasattr(cls, "_fields"))
            ):
                classes[_name_of(cls, "")] = cls
    return classes
