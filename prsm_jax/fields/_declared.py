"""What a class declares about its fields: unit, limit, list, words, and classes of parts.

Construction in Python, files, `--set`, names of numbers and explanations all read this.
"""

import dataclasses
import functools
import inspect
import types
import typing
from collections.abc import Iterator, Mapping
from typing import Any

import equinox as eqx

from ._limits import ANY, Limit, limit_of


@functools.cache
def _hints(cls: type) -> dict[str, Any]:
    return typing.get_type_hints(cls)


def members(hint: Any) -> tuple[Any, ...]:
    """The members of a union; the hint itself if it is none."""
    union = typing.get_origin(hint) in (typing.Union, types.UnionType)
    return typing.get_args(hint) if union else (hint,)


def module_classes(hint: Any) -> tuple[type[eqx.Module], ...]:
    """The classes of parts that a type hint allows; empty for numbers and choices.

    An abstract class beside others stands for classes of users, and is left out.
    """
    classes = tuple(m for m in members(hint) if isinstance(m, type) and issubclass(m, eqx.Module))
    return tuple(cls for cls in classes if not inspect.isabstract(cls)) or classes


@dataclasses.dataclass(frozen=True)
class Declared:
    """One field, as its class declares it.

    - `owner`: the class.
    - `name`: of the field.
    - `unit`: SI unit of a number or list of numbers; `None` for all else.
    - `limit`: of a number, of each number of a list, or of a whole number.
    - `metadata`: what `number`, `numbers`, `choice` and `part` have stored.
    - `default`: `dataclasses.MISSING` if the field has none.
    """

    owner: type
    name: str
    unit: str | None
    limit: Limit
    metadata: Mapping[str, Any]
    default: Any

    @functools.cached_property
    def hint(self) -> Any:
        """The type hint. Resolved when asked: a law may name types that only checkers know."""
        return _hints(self.owner)[self.name]

    @property
    def description(self) -> str:
        """What it is; empty if the field does not say."""
        return self.metadata.get("description", "")

    @property
    def required(self) -> bool:
        """Whether there is no default."""
        return self.default is dataclasses.MISSING

    @property
    def is_list(self) -> bool:
        """Whether it is a list of numbers."""
        return "least" in self.metadata

    @property
    def least(self) -> int:
        """Smallest number of entries of a list."""
        return self.metadata["least"]

    @property
    def traced_limit(self) -> Limit:
        """The limit in a trace: a stiffness without a limit of its own may be negative there.

        `check` reports it, with its effect.
        """
        by_unit = self.metadata.get("limit") is None
        return ANY if by_unit and self.unit == "N/m" else self.limit

    @property
    def static(self) -> bool:
        """Whether it is a choice: a word, a whole number, a text, true or false."""
        return self.metadata.get("static", False) or self.metadata.get("choice", False)

    @property
    def registered(self) -> Mapping[str, Any]:
        """What each word of a choice stands for now, if users may add words; empty for all else."""
        return self.metadata["registered"]() if "registered" in self.metadata else {}

    @property
    def words(self) -> tuple[str, ...]:
        """The words of a choice, from its `Literal` or as registered; empty for all else."""
        return tuple(self.registered) or self._literal

    @functools.cached_property
    def _literal(self) -> tuple[str, ...]:
        is_word = self.static and typing.get_origin(self.hint) is typing.Literal
        return typing.get_args(self.hint) if is_word else ()

    def word_of(self, value: Any) -> str | None:
        """The registered word that stands for a value; `None` if there is none."""
        return next((word for word, one in self.registered.items() if one == value), None)

    @property
    def whole(self) -> bool:
        """Whether it is a whole number."""
        return self.static and self.hint is int

    @functools.cached_property
    def classes(self) -> tuple[type[eqx.Module], ...]:
        """The classes of parts that may stand here; empty for numbers and choices."""
        return module_classes(self.hint)

    @functools.cached_property
    def element(self) -> Any:
        """Type hint of the parts of a tuple, an array of tables in a file; else `None`."""
        if typing.get_origin(self.hint) is not tuple:
            return None
        element = typing.get_args(self.hint)[0]
        return element if module_classes(element) else None

    @property
    def units(self) -> Mapping[str, str] | None:
        """Of a law whose numbers stand in the table of its owner: its units there, by its own."""
        return self.metadata["units"] if self.metadata.get("same_table") else None

    @property
    def law_decides(self) -> bool:
        """Whether the law beside it determines if the number is required."""
        return self.metadata.get("law_decides", False)

    @property
    def implied(self) -> bool:
        """Whether a file has it only if it is not the default."""
        return self.metadata.get("implied", False)

    def used_as(self, units: Mapping[str, str]) -> "Declared":
        """The same number where it has another unit; its limit stays."""
        return dataclasses.replace(self, unit=units.get(self.unit or "", self.unit))


@functools.cache
def declared(cls: type, unit: str = "1") -> tuple[Declared, ...]:
    """The fields of a class.

    **Arguments:**

    - `cls`: a part of a mechanism, a law, a profile, or another dataclass.
    - `unit`: SI unit in place of `*`, that of a function's values.
    """

    def one(field: dataclasses.Field[Any]) -> Declared:
        own = field.metadata.get("unit")
        own = unit if own == "*" else own
        limit = limit_of(own or "1", field.metadata.get("limit"))
        made = field.default_factory is not dataclasses.MISSING
        default = field.default_factory if made else field.default
        return Declared(cls, field.name, own, limit, field.metadata, default)

    # The type of a thread is that of its stage, and is declared there.
    fields = (field for field in dataclasses.fields(cls) if not field.metadata.get("of_owner"))
    return tuple(one(field) for field in fields)


def values_of(module: Any, unit: str = "1") -> Iterator[tuple[Declared, Any]]:
    """The fields of a part with their values; a law's numbers stand in the table of its owner.

    **Arguments:**

    - `module`: the part.
    - `unit`: as in `declared`.
    """
    for one in declared(type(module), unit):
        value = getattr(module, one.name)
        if one.units is None:
            yield one, value
        else:
            yield from ((of_law.used_as(one.units), x) for of_law, x in values_of(value, unit))
