"""Old names of public fields and arguments: they keep working, with a `DeprecationWarning`."""

import functools
import warnings
from collections.abc import Callable
from typing import Any, TypeVar, cast

_Target = TypeVar("_Target", bound=Callable[..., Any])


def _warn(owner: str, old: str, new: str) -> None:
    warnings.warn(f"{owner}: {old} is now {new}", DeprecationWarning, stacklevel=3)


def renamed(old: str, new: str) -> property:
    """The old name of a field, as a property of its class.

    **Arguments:**

    - `old`, `new`: the names.
    """

    def value(self):
        _warn(type(self).__name__, old, new)
        return getattr(self, new)

    return property(value, doc=f"Old name of `{new}`.")


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
