"""The schema of a file, derived from the classes of the mechanism.

One pydantic model per class, made from its dataclass fields and their metadata: a new field of
the mechanism is a new key of the file, with its unit, its description and no second declaration.
Only what differs between pytree and file is written out: `[[stage]]`, `[[duty_cycle]]` and
`[optimise]`.
"""

import dataclasses
import functools
import typing
from typing import Annotated, Any, Literal

import equinox as eqx
from pydantic import BeforeValidator, Discriminator, Field, Tag, create_model

from ..mechanism import DutyCycle, OperatingPoint, Stage, limit_of
from .numbers import (
    law_names,
    module_classes,
    read_integer,
    read_number,
    read_numbers,
    row_class,
    unnamed_law,
)
from .tables import (
    OptimiseTable,
    Table,
    checked,
    problem,
    read_boolean,
    read_choice,
    read_tables,
    read_text,
)


def _number_or_choice(field: dataclasses.Field, hint) -> Any:
    unit = field.metadata.get("unit")
    if field.metadata.get("list"):
        return Annotated[tuple, checked(read_numbers, unit, limit_of(field.name, unit or "1"))]
    if unit is not None:
        return Annotated[float, checked(read_number, unit, limit_of(field.name, unit))]
    if hint is bool:
        return Annotated[bool, checked(read_boolean)]
    if hint is int:
        return Annotated[int, checked(read_integer, limit_of(field.name, "1"))]
    if typing.get_origin(hint) is Literal:
        return Annotated[str, checked(read_choice, typing.get_args(hint))]
    return Annotated[str, checked(read_text)]


def _law_of(laws: dict[str, type]):
    """How to find which member of a union a table means: by its key `law`."""
    choices = ", ".join(f'"{name}"' for name in laws)
    unnamed = unnamed_law(laws)

    def tag(data) -> str:
        return data.get("law", unnamed)

    def check(data):
        if not isinstance(data, dict):
            raise problem("must be a table of keys")
        if "law" not in data:
            if unnamed is not None:
                return data
            raise problem(f"is missing; choose one of {choices}", key="law")
        if not isinstance(data["law"], str) or data["law"] not in laws:
            raise problem(f"choose one of {choices}", key="law")
        return data

    return Discriminator(tag), BeforeValidator(check)


def _table_type(classes: tuple[type, ...]) -> Any:
    if len(classes) == 1:
        return table_of(classes[0])
    laws = law_names(classes)
    discriminator, check = _law_of(laws)
    members = tuple(Annotated[table_of(cls, law), Tag(law)] for law, cls in laws.items())
    return Annotated[typing.Union[members], discriminator, check]  # noqa: UP007


def _kind(field: dataclasses.Field, hint) -> Any:
    row = row_class(hint)
    if row is not None:
        return Annotated[list[table_of(row)], BeforeValidator(read_tables)]  # pyright: ignore[reportInvalidTypeForm]
    classes = module_classes(hint)
    return _table_type(classes) if classes else _number_or_choice(field, hint)


def _meaning(field: dataclasses.Field) -> str:
    unit, text = field.metadata.get("unit", "1"), field.metadata.get("description", "")
    return text if unit == "1" or not text else f"{text} [{unit}]"


@functools.cache
def table_of(cls: type, law: str | None = None) -> type[Table]:
    """The model of a class of the mechanism, from its fields; with a key `law` if there is one."""
    hints = typing.get_type_hints(cls)
    fields: dict[str, Any] = {}
    if law is not None:
        required = law != unnamed_law({law: cls})
        fields["law"] = (Annotated[str, checked(read_text)], ... if required else law)
    for field in dataclasses.fields(cls):
        kind = _kind(field, hints[field.name])
        if field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            fields[field.name] = (kind, Field(description=_meaning(field)))
        else:
            fields[field.name] = (kind | None, None)
    model = create_model(cls.__name__, __base__=Table, **fields)
    model.module = cls
    return model


@functools.cache
def document() -> type[Table]:
    """The model of a whole file."""
    rows = BeforeValidator(read_tables)
    point: Any = table_of(OperatingPoint)
    stages: Any = Annotated[list[table_of(Stage)], rows]  # pyright: ignore[reportInvalidTypeForm]
    phases: Any = Annotated[list[table_of(DutyCycle)], rows]  # pyright: ignore[reportInvalidTypeForm]
    fields: dict[str, Any] = {
        "title": (Annotated[str, checked(read_text)], ""),
        "operating_point": (point | None, None),
        "stage": (stages, Field(description="stages, as [[stage]]")),
        "duty_cycle": (phases | None, None),
        "optimise": (OptimiseTable | None, None),
        # Read by `_scenario_table`: units there depend on where a profile stands.
        "scenario": (Any, None),
    }
    return create_model("Document", __base__=Table, **fields)


def module_of(table: Table) -> eqx.Module:
    """The part of the mechanism that a validated table describes.

    **Raises:** `ValueError` if the class of the mechanism refuses the values.
    """
    assert table.module is not None
    values = {}
    for name in table.model_fields_set - {"law"}:
        value = getattr(table, name)
        if isinstance(value, list):
            values[name] = tuple(module_of(row) for row in value)
        else:
            values[name] = module_of(value) if isinstance(value, Table) else value
    return table.module(**values)
