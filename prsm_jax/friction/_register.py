"""Friction laws by name: what files, `--set` and the schema know."""

import dataclasses
import re
import typing
from collections.abc import Callable
from typing import TypeVar

from ..programs import origin_of
from ._law import FrictionLaw, check_asked

_Law = TypeVar("_Law", bound=type[FrictionLaw])
_LAWS: dict[str, type[FrictionLaw]] = {}


def friction_law(name: str) -> Callable[[_Law], _Law]:
    """Name a class of friction law, so that files can hold it as `law = "name"`.

    The same class may be defined again, as when a cell of a notebook is run twice; the last one
    counts.

    **Arguments:**

    - `name`: lower-case words joined by underscores.

    **Raises:** `TypeError` if the class is no `FrictionLaw`; `ValueError` if the name is not one or
    another class has it, if `asks` holds an unknown name, or a field is no number.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise ValueError(f"friction law {name!r}: a name is lower-case words joined by underscores")

    # No type check at run time: the sentence below says it better.
    @typing.no_type_check
    def decorate(cls: _Law) -> _Law:
        if not (isinstance(cls, type) and issubclass(cls, FrictionLaw)):
            raise TypeError(f"friction law {name!r}: {cls!r} must be a class of FrictionLaw")
        known = _LAWS.get(name)
        if known is not None and origin_of(known) != origin_of(cls):
            raise ValueError(
                f"friction law {name!r}: {known.__module__}.{known.__qualname__} has this name; "
                "choose another"
            )
        check_asked(cls, cls.asks)
        for field in dataclasses.fields(cls):
            if field.name in ("law", "radius"):
                raise ValueError(
                    f"friction law {name!r}: a field is called {field.name}, as one of splines and "
                    "bearings; choose another name"
                )
            if "unit" not in field.metadata:
                raise ValueError(
                    f"friction law {name!r}: {field.name} has no unit; declare it as "
                    f'{field.name}: prsm.Scalar = prsm.number("N", "what it is")'
                )
        cls.law = name
        _LAWS[name] = cls
        return cls

    return decorate


def friction_laws(*, of_threads: bool = True) -> dict[str, type[FrictionLaw]]:
    """All named laws in the order of their names.

    Those of splines and bearings have no state, and know the slip speed alone.

    **Arguments:**

    - `of_threads`: whether threads rub by it.
    """
    known = sorted(_LAWS.items())
    return {name: cls for name, cls in known if of_threads or not (cls.has_state or cls.asks)}
