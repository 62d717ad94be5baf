"""Verbs that users add."""

from collections.abc import Callable
from typing import Any, TypeVar

from ..programs import origin_of
from ._verbs import app

_Verb = TypeVar("_Verb", bound=Callable[..., Any])
#: Module and name of the functions behind verbs that were added.
_own: dict[str, tuple[str, str]] = {}


def verb(function: _Verb) -> _Verb:
    """Add a function to the command line under its name; the module is given by `--plugin`.

    Its arguments, their types and its docstring define those of the command (cyclopts). Arguments
    named `output: Output` or `common: Common` bring the options that all verbs share; `emit` writes
    results as these options say. The function returns the exit status.

    **Raises:** `ValueError` if another function has the name.
    """
    name = function.__name__.replace("_", "-")
    if name in app:
        if _own.get(name) != origin_of(function):
            raise ValueError(f"the verb {name!r} exists already; choose another name")
        del app[name]
    _own[name] = origin_of(function)
    app.command(function)
    return function
