"""The places of a mechanism where an optional part may be, read from its dataclasses.

There is no list of names: a field that may be `None` (or an empty tuple of tables) is a place, and
its metadata say what results miss without the part.
"""

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any

import equinox as eqx

from ..fields import Declared, declared, members, module_classes
from ..file import TableChoice, table_choices
from ..mechanism import Mechanism

#: Tables whose name in the file is not the name of the field, and those whose classes are
#: distinguished by their keys, not by a key `law`.
_HEADERS = {"design_problem": "optimise"}
_BY_KEYS = ("scenario",)
_LISTS = ("duty_cycle",)


@dataclasses.dataclass(frozen=True)
class Place:
    """One place for an optional part.

    - `path`: fields and indices that lead to it from the mechanism.
    - `name`: the same as in names of numbers, such as `stage.1.friction.spin`.
    - `kind`: `table`, `number`, `list` (of tables) or `stage`.
    - `present`: whether the part is there.
    - `law`, `laws`: the law that is there, and the possible laws, if there are several.
    - `meaning`: what the part is.
    - `without`: what results miss without it.
    - `write`: what to write in the file to have it.
    """

    path: tuple[str | int, ...]
    name: str
    kind: str
    present: bool
    law: str | None
    laws: tuple[str, ...]
    meaning: str
    without: str
    write: str


def places(mechanism: Mechanism) -> tuple[Place, ...]:
    """All places of a mechanism for optional parts, in the order of its fields.

    **Arguments:**

    - `mechanism`: the mechanism; its parts count, not its numbers.
    """
    optional: list[Place] = []
    for index, stage in enumerate(mechanism.stages):
        if index:
            optional.append(_stage(index))
        optional += _inside(stage, ("stages", index), f"stage.{index + 1}", "stage")
    if len(mechanism.stages) == 1:
        optional.append(dataclasses.replace(_stage(1), present=False))
    rest = [one for one in _inside(mechanism, (), "", "") if one.path[0] != "stages"]
    return (*optional, *rest)


def without(mechanism: Mechanism, place: Place) -> Mechanism:
    """The same mechanism without the part at a place.

    **Raises:** `ValueError` if another part needs it.
    """
    return _without(mechanism, place.path)


def _without(value: Any, path: tuple[str | int, ...]) -> Any:
    head, *rest = path
    if isinstance(head, int):
        if not rest:
            return (*value[:head], *value[head + 1 :])
        return (*value[:head], _without(value[head], tuple(rest)), *value[head + 1 :])
    inner = getattr(value, head)
    default = next(one.default for one in dataclasses.fields(value) if one.name == head)
    empty = () if isinstance(inner, tuple) and default is not None else None
    changed = _without(inner, tuple(rest)) if rest else empty
    return dataclasses.replace(value, **{head: changed})


def _stage(index: int) -> Place:
    return Place(
        ("stages", index),
        f"stage.{index + 1}",
        "stage",
        True,
        None,
        (),
        "Another planetary roller screw, driven by the nut before it",
        "fewer stages: less travel per turn, and different losses",
        "[[stage]] with all keys that a stage needs",
    )


def _inside(
    module: Any,
    path: tuple[str | int, ...],
    name: str,
    header: str,
    units: Mapping[str, str] | None = None,
) -> Iterator[Place]:
    for one in declared(type(module)):
        value, here = getattr(module, one.name), (*path, one.name)
        if one.units is not None:
            yield from _inside(value, here, name, header, one.units)
            continue
        own = ".".join(filter(None, (name, one.name)))
        below = ".".join(filter(None, (header, _HEADERS.get(one.name, one.name))))
        if is_optional(one):
            is_number = one.unit is not None
            field = one.used_as(units or {})
            yield _place(field, value, here, own, header if is_number else below)
        if isinstance(value, eqx.Module):
            yield from _inside(value, here, own, below)
        elif isinstance(value, tuple) and one.name != "stages":
            for index, element in enumerate(value):
                if isinstance(element, eqx.Module):
                    number = getattr(element, "number", index + 1)
                    yield from _inside(element, (*here, index), f"{own}.{number}", below)


def is_optional(one: Declared) -> bool:
    """Whether a field of the mechanism may be left out."""
    may_be_none = type(None) in members(one.hint) and not one.law_decides
    return may_be_none or (one.element is not None and one.default == ())


def _place(one: Declared, value: Any, path: tuple[Any, ...], name: str, header: str) -> Place:
    present = bool(value) if isinstance(value, tuple) else value is not None
    if one.unit is not None:
        key = one.name if one.unit == "1" else f"{one.name}, in {one.unit}"
        text = one.description
        return Place(
            path, name, "number", present, None, (), text, f"not given: {text}",
            f"[{header}] {key}",
        )  # fmt: skip
    misses = one.metadata["without"]
    if one.element is not None:
        (row,) = module_classes(one.element)
        return Place(
            path,
            name,
            "list",
            present,
            None,
            (),
            _first(row),
            misses,
            f"[[{header}]]{_keys(TableChoice(row))}",
        )
    choices = {} if one.name in _BY_KEYS else table_choices(one.hint)
    laws = {} if "" in choices else choices
    law = next((word for word, choice in laws.items() if choice.holds(value)), None)
    classes = one.classes
    if present and law is not None:
        meaning = _first(choices[law].cls)
    elif present and len(classes) > 1:
        meaning = _first(type(value))
    elif len(classes) == 1:
        meaning = _first(classes[0])
    else:
        meaning = one.description or _any_of(classes)
    opening = f"[[{header}]]" if one.name in _LISTS else f"[{header}]"
    if laws:
        write = f"{opening} with law = " + ", ".join(
            f'"{word}"{_keys(choice)}' for word, choice in laws.items()
        )
    else:
        write = opening + "; or".join(_keys(TableChoice(cls)) for cls in classes)
    return Place(path, name, "table", present, law, tuple(laws), meaning, misses, write)


def _any_of(classes: tuple[type, ...]) -> str:
    return "; or ".join(_first(cls) for cls in classes)


def _first(cls: type) -> str:
    """The first paragraph of the docstring of a class, up to ": force"."""
    paragraph = " ".join((cls.__doc__ or "").strip().partition("\n\n")[0].split())
    return paragraph.partition(": force")[0].rstrip(".")


def _keys(choice: TableChoice) -> str:
    """The keys that a table needs, in brackets."""
    needed = [one.name for one in choice.fields() if choice.needs(one)]
    return f" ({', '.join(needed)})" if needed else ""
