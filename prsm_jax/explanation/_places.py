"""The places of a mechanism where an optional part may be, read from its dataclasses.

There is no list of names: a field that may be `None` (or an empty tuple of tables) is a place, and
its metadata say what results miss without the part.
"""

import dataclasses
import types
import typing
from collections.abc import Iterator
from typing import Any

import equinox as eqx

from ..file import TableChoice, is_law_field, module_classes, row_class, table_choices
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
    - `misses`: what results miss without it.
    - `write`: what to write in the file to have it.
    """

    path: tuple[str | int, ...]
    name: str
    kind: str
    present: bool
    law: str | None
    laws: tuple[str, ...]
    meaning: str
    misses: str
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
    empty = () if isinstance(inner, tuple) else None
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


def _inside(module: Any, path: tuple[str | int, ...], name: str, header: str) -> Iterator[Place]:
    hints = typing.get_type_hints(type(module))
    for field in dataclasses.fields(module):
        value, hint = getattr(module, field.name), hints[field.name]
        here = (*path, field.name)
        if is_law_field(field):
            yield from _inside(value, here, name, header)
            continue
        own = ".".join(filter(None, (name, field.name)))
        below = ".".join(filter(None, (header, _HEADERS.get(field.name, field.name))))
        if is_optional(field, hint):
            yield _place(field, hint, value, here, own, header if _is_number(field) else below)
        if isinstance(value, eqx.Module):
            yield from _inside(value, here, own, below)
        elif isinstance(value, tuple) and field.name != "stages":
            for index, one in enumerate(value):
                if isinstance(one, eqx.Module):
                    number = getattr(one, "number", index + 1)
                    yield from _inside(one, (*here, index), f"{own}.{number}", below)


def is_optional(field: dataclasses.Field[Any], hint: Any) -> bool:
    """Whether a field of the mechanism may be left out."""
    if field.metadata.get("law_decides"):
        return False
    union = typing.get_origin(hint) in (typing.Union, types.UnionType)
    may_be_none = union and type(None) in typing.get_args(hint)
    return may_be_none or (row_class(hint) is not None and field.default == ())


def _is_number(field: dataclasses.Field[Any]) -> bool:
    return "unit" in field.metadata


def _place(
    field: dataclasses.Field[Any],
    hint: Any,
    value: Any,
    path: tuple[Any, ...],
    name: str,
    header: str,
) -> Place:
    present = bool(value) if isinstance(value, tuple) else value is not None
    if _is_number(field):
        unit = field.metadata["unit"]
        key = field.name if unit == "1" else f"{field.name}, in {unit}"
        text = field.metadata["description"]
        return Place(
            path, name, "number", present, None, (), text, f"not given: {text}",
            f"[{header}] {key}",
        )  # fmt: skip
    misses = field.metadata["without"]
    row = row_class(hint)
    if row is not None:
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
    choices = {} if field.name in _BY_KEYS else table_choices(hint)
    laws = {} if "" in choices else choices
    law = next((word for word, one in laws.items() if one.holds(value)), None)
    classes = module_classes(hint)
    if present and law is not None:
        meaning = _first(choices[law].cls)
    elif present and len(classes) > 1:
        meaning = _first(type(value))
    elif len(classes) == 1:
        meaning = _first(classes[0])
    else:
        meaning = field.metadata.get("description") or _any_of(classes)
    opening = f"[[{header}]]" if field.name in _LISTS else f"[{header}]"
    if laws:
        write = f"{opening} with law = " + ", ".join(
            f'"{word}"{_keys(one)}' for word, one in laws.items()
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
    needed = [field.name for field, _, _ in choice.fields() if choice.needs(field)]
    return f" ({', '.join(needed)})" if needed else ""
