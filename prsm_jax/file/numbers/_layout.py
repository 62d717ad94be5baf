"""Mapping of classes of the mechanism to tables, shared by reading and writing."""

import dataclasses
import re

import equinox as eqx

from ...fields import Declared, Scalar, declared, members, module_classes
from ...friction import FrictionLaw, friction_laws


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

    def fields(self, unit: str = "1") -> list[Declared]:
        """Fields of the table, with those of a law; `unit` in place of `*`."""
        entries: list[Declared] = []
        for one in declared(self.cls, unit):
            if one.units is not None:
                assert self.law is not None
                entries += [of_law.used_as(one.units) for of_law in declared(self.law)]
            elif not (one.law_decides and self.law is not None and self.law.load_independent):
                entries.append(one)
        return entries

    def needs(self, one: Declared) -> bool:
        """Whether the table needs a field."""
        return one.required or (one.law_decides and self.law is not None)


def takes_numbers(hint: object) -> bool:
    """Whether a part may be a plain number."""
    return Scalar in members(hint)


def tag_of(hint: object) -> str:
    """The key by which the tables at a place are told apart: `kind` of functions, else `law`."""
    return "kind" if any(hasattr(cls, "kind") for cls in module_classes(hint)) else "law"


def table_choices(hint: object, unit: str | None = None) -> dict[str, TableChoice]:
    """Tables possible at a place of the file, by the value of `tag_of`; `""` without that key.

    Laws are listed by their names; other classes of a union by their attribute `kind` or `law`, or
    else by the class name in lower case, without the last word if all classes share it.

    **Arguments:**

    - `hint`: type hint of the part.
    - `unit`: SI unit of a function's values; some profiles have only one.
    """
    classes = [c for c in module_classes(hint) if getattr(c, "value_unit", unit) == unit]
    if classes == [FrictionLaw]:
        return {name: TableChoice(cls) for name, cls in friction_laws().items()}
    if len(classes) == 1:
        if any(one.units is not None for one in declared(classes[0])):
            laws = friction_laws(of_threads=False).items()
            return {name: TableChoice(classes[0], law) for name, law in laws}
        return {"": TableChoice(classes[0])}
    words = {cls: re.findall(r"[A-Z][a-z0-9]*", cls.__name__) for cls in classes}
    same_ending = len({parts[-1] for parts in words.values()}) == 1

    def name(cls: type) -> str:
        parts = words[cls]
        by_name = "_".join(parts[:-1] if same_ending and len(parts) > 1 else parts).lower()
        return getattr(cls, "kind", getattr(cls, "law", by_name))

    return {name(cls): TableChoice(cls) for cls in words}


def usual_law(hint: object) -> str | None:
    """The law that a table without the key `law` means; `None` if it must be named."""
    for cls in module_classes(hint):
        for one in declared(cls):
            if one.units is not None:
                return one.metadata["usual_law"]
    return None
