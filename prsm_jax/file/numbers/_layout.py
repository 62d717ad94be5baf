"""How the classes of the mechanism become tables: what reading and writing agree on."""

import re
import types
import typing

import equinox as eqx


def module_classes(hint) -> tuple[type[eqx.Module], ...]:
    """The classes of the mechanism that a type hint allows; empty for numbers and choices."""
    union = typing.get_origin(hint) in (typing.Union, types.UnionType)
    members = typing.get_args(hint) if union else (hint,)
    return tuple(m for m in members if isinstance(m, type) and issubclass(m, eqx.Module))


def row_class(hint) -> type[eqx.Module] | None:
    """The class of the elements of a tuple of modules, which is an array of tables in a file."""
    if typing.get_origin(hint) is not tuple:
        return None
    classes = module_classes(typing.get_args(hint)[0])
    return classes[0] if classes else None


def law_names(classes: tuple[type, ...]) -> dict[str, type]:
    """The value of the key `law` for each class of a union.

    What the class itself says in `law`; else its name in lower case without the last word, if all
    share it: `CoulombFriction` in a union of frictions is `coulomb`.
    """
    words = {cls: re.findall(r"[A-Z][a-z0-9]*", cls.__name__) for cls in classes}
    same_ending = len({parts[-1] for parts in words.values()}) == 1

    def name(cls: type) -> str:
        parts = words[cls]
        by_name = "_".join(parts[:-1] if same_ending and len(parts) > 1 else parts).lower()
        return getattr(cls, "law", by_name)

    return {name(cls): cls for cls in words}


def unnamed_law(laws: dict[str, type]) -> str | None:
    """The law that a table without the key `law` means; `None` where it has to be named."""
    for name, cls in laws.items():
        if getattr(cls, "law_may_be_omitted", False):
            return name
    return None
