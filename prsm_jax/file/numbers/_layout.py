"""Mapping of classes of the mechanism to tables, shared by reading and writing."""

import dataclasses
import re
import types
import typing
from typing import Any

import equinox as eqx

from ...friction import FrictionLaw, friction_laws


def module_classes(hint: object) -> tuple[type[eqx.Module], ...]:
    """The classes of the mechanism that a type hint allows; empty for numbers and choices."""
    union = typing.get_origin(hint) in (typing.Union, types.UnionType)
    members = typing.get_args(hint) if union else (hint,)
    return tuple(m for m in members if isinstance(m, type) and issubclass(m, eqx.Module))


def row_class(hint: object) -> type[eqx.Module] | None:
    """The class of the elements of a tuple of modules, which is an array of tables in a file."""
    if typing.get_origin(hint) is not tuple:
        return None
    classes = module_classes(typing.get_args(hint)[0])
    return classes[0] if classes else None


@dataclasses.dataclass(frozen=True)
class TableChoice:
    """One of the tables that are possible at a place of the file.

    - `cls`: class of the mechanism.
    - `law`: class of a law whose numbers stand in the same table, if there is one.
    """

    cls: type[eqx.Module]
    law: type[FrictionLaw] | None = None

    def holds(self, value: object) -> bool:
        """Whether a part of the mechanism is of this kind."""
        of_law = self.law is None or type(getattr(value, "law", None)) is self.law
        return type(value) is self.cls and of_law

    def fields(self) -> list[tuple[dataclasses.Field[Any], object, dict[str, str]]]:
        """Fields of the table with type hints, and units that replace those of a law's numbers."""
        hints = typing.get_type_hints(self.cls)
        entries = []
        for field in dataclasses.fields(self.cls):
            if not is_law_field(field):
                of_radius = self.law is not None and self.law.load_independent
                if not (of_radius and field.name == "radius"):
                    entries.append((field, hints[field.name], {}))
                continue
            assert self.law is not None
            own = typing.get_type_hints(self.law)
            units = field.metadata["units"]
            entries += [(one, own[one.name], units) for one in dataclasses.fields(self.law)]
        return entries

    def needs(self, field: dataclasses.Field[Any]) -> bool:
        """Whether the table needs a field."""
        if self.law is not None and field.name == "radius":
            return True
        no_default = field.default is dataclasses.MISSING
        return no_default and field.default_factory is dataclasses.MISSING


def is_law_field(field: dataclasses.Field[Any]) -> bool:
    """Whether a field is a law whose numbers are in the table of the field's owner."""
    return bool(field.metadata.get("same_table"))


def unit_of(field: dataclasses.Field[Any], units: dict[str, str]) -> str | None:
    """SI unit of a number after replacement by `units`; `None` if the field is no number."""
    unit: str | None = field.metadata.get("unit")
    return None if unit is None else units.get(unit, unit)


def table_choices(hint: object) -> dict[str, TableChoice]:
    """Tables possible at a place of the file, by the value of the key `law`; `""` without the key.

    Laws are listed by their names; other classes of a union by their attribute `law`, or else by
    the class name in lower case, without the last word if all classes share it.
    """
    classes = module_classes(hint)
    if classes == (FrictionLaw,):
        return {name: TableChoice(cls) for name, cls in friction_laws().items()}
    if len(classes) == 1:
        if any(is_law_field(field) for field in dataclasses.fields(classes[0])):
            laws = friction_laws(of_threads=False).items()
            return {name: TableChoice(classes[0], law) for name, law in laws}
        return {"": TableChoice(classes[0])}
    words = {cls: re.findall(r"[A-Z][a-z0-9]*", cls.__name__) for cls in classes}
    same_ending = len({parts[-1] for parts in words.values()}) == 1

    def name(cls: type) -> str:
        parts = words[cls]
        by_name = "_".join(parts[:-1] if same_ending and len(parts) > 1 else parts).lower()
        return getattr(cls, "law", by_name)

    return {name(cls): TableChoice(cls) for cls in words}


def usual_law(hint: object) -> str | None:
    """The law that a table without the key `law` means; `None` if it must be named."""
    for cls in module_classes(hint):
        for field in dataclasses.fields(cls):
            if is_law_field(field):
                return field.metadata["usual_law"]
    return None
