"""Friction laws by name, for files, `--set` and the schema."""

import dataclasses
import re
import typing
from collections.abc import Callable
from typing import TypeVar

from ..programs import origin_of
from ._law import FrictionLaw, check_law_inputs

_Law = TypeVar("_Law", bound=type[FrictionLaw])
_LAWS: dict[str, type[FrictionLaw]] = {}


def friction_law(name: str) -> Callable[[_Law], _Law]:
    """Register a class of friction law by a name, for `law = "name"` in files.

    The same class may be defined again, e.g. if a cell of a notebook is run twice; the last one is
    used.

    **Arguments:**

    - `name`: lower-case words joined by underscores.

    **Raises:** `TypeError` if the class is not a `FrictionLaw`; `ValueError` if the name is
    malformed or used by another class, if `asks` contains an unknown name, or if a field is not a
    number.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise ValueError(f"friction law {name!r}: a name is lower-case words joined by underscores")

    # No type check at run time: the message below is clearer.
    @typing.no_type_check
    def decorate(cls: _Law) -> _Law:
        if not (isinstance(cls, type) and issubclass(cls, FrictionLaw)):
            raise TypeError(f"friction law {name!r}: {cls!r} must be a class of FrictionLaw")
        registered = _LAWS.get(name)
        if registered is not None and origin_of(registered) != origin_of(cls):
            raise ValueError(
                f"friction law {name!r}: {registered.__module__}.{registered.__qualname__} has "
                "this name; choose another"
            )
        check_law_inputs(cls, cls.asks)
        for field in dataclasses.fields(cls):
            if field.name in ("law", "radius"):
                raise ValueError(
                    f"friction law {name!r}: the field name {field.name} is used by splines and "
                    "bearings; choose another name"
                )
            if "unit" not in field.metadata:
                raise ValueError(
                    f"friction law {name!r}: {field.name} has no unit; write "
                    f'`{field.name}: Number = number("N", "what it is")` after '
                    "`from prsm_jax.fields import Number, number`"
                )
        cls.law = name
        _LAWS[name] = cls
        return cls

    return decorate


def friction_laws(*, of_threads: bool = True) -> dict[str, type[FrictionLaw]]:
    """All named laws in the order of their names.

    Laws of splines and bearings have no state and use only the slip speed.

    **Arguments:**

    - `of_threads`: true for laws of threads, which are all; false for those of splines and
      bearings.
    """
    known = sorted(_LAWS.items())
    return {name: cls for name, cls in known if of_threads or not (cls.has_state or cls.asks)}
