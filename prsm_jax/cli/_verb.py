"""A verb of a user's own."""

from collections.abc import Callable
from typing import TypeVar

from ._app import app

_Verb = TypeVar("_Verb", bound=Callable)


def verb(function: _Verb) -> _Verb:
    """Add a function to the command line under its name; the module is given by `--plugin`.

    Its arguments, their types and its docstring make the command's (cyclopts). Arguments named
    `output: Output` or `common: Common` bring the options that all verbs share; `emit` sends
    results where they ask for them. It returns the exit status.

    **Raises:** `ValueError` if a verb of this package has the name.
    """
    name = function.__name__.replace("_", "-")
    if name in app and not _of_a_user(name):
        raise ValueError(f"the verb {name!r} exists already; choose another name")
    if name in app:
        del app[name]
    _own.add(name)
    app.command(function)
    return function


_own: set[str] = set()


def _of_a_user(name: str) -> bool:
    return name in _own
