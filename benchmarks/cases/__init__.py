"""The cases: every module here offers `case(quick)`, and its name is the case's name.

A case that is long even if quick has a second argument, `smoke`.
"""

import importlib
import inspect
import pkgutil

from ..defaults import with_defaults
from ..harness import Case


def case_names() -> tuple[str, ...]:
    """Names of all cases, in alphabetical order."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def find_case(name: str, *, quick: bool, smoke: bool = False) -> Case:
    """Build a case by name, smaller if `quick`, and as small as it gets for `smoke`.

    **Raises:** `ValueError` for an unknown name.
    """
    if name not in case_names():
        raise ValueError(f"there is no case {name!r}; choose from {', '.join(case_names())}")
    make = importlib.import_module(f"{__name__}.{name}").case
    small = "smoke" in inspect.signature(make).parameters
    return with_defaults(make(quick, smoke) if small else make(quick))
