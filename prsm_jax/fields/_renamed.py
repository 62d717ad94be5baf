"""Old names of public fields and arguments: they keep working, with a `DeprecationWarning`."""

import functools
import warnings
from collections.abc import Callable
from typing import Any, TypeVar, cast

_Target = TypeVar("_Target", bound=Callable[..., Any])


def _warn(owner: str, old: str, new: str, stacklevel: int = 3) -> None:
    warnings.warn(f"{owner}: {old} is now {new}", DeprecationWarning, stacklevel)


def old_name(module: object, old: str, new: str) -> Any:
    """The value of a field, with the warning that its name is new; for a property `old`.

    **Arguments:**

    - `module`: the object that has the field.
    - `old`, `new`: the names.
    """
    _warn(type(module).__name__, old, new, stacklevel=4)
    return getattr(module, new)


def renamed_arguments(**new_names: str) -> Callable[[_Target], _Target]:
    """Decorator: a function, or a class, that accepts old names of keyword arguments.

    **Arguments:**

    - `new_names`: the new name of each old one.
    """

    def decorate(target: _Target) -> _Target:
        function: Any = target.__init__ if isinstance(target, type) else target
        owner = target.__name__

        @functools.wraps(function)
        def accepting(*args, **kwargs):
            for old, new in new_names.items():
                if old in kwargs:
                    if new in kwargs:
                        raise TypeError(f"{owner}: {old} is the old name of {new}; give one")
                    _warn(owner, old, new)
                    kwargs[new] = kwargs.pop(old)
            return function(*args, **kwargs)

        if isinstance(target, type):
            target.__init__ = accepting
            return cast(_Target, target)
        return cast(_Target, accepting)

    return decorate
