"""The schema of a file, derived from the classes of the mechanism.

One pydantic model per class, made from its dataclass fields and their metadata: a new field of
the mechanism is a new key of the file, with its unit and description, without a second declaration.
Only the differences between pytree and file are written out: `[[stage]]`, `[[duty_cycle]]` and
`[optimise]`.
"""

import dataclasses
import functools
import typing
from collections.abc import Iterable
from typing import Annotated, Any, Literal

import equinox as eqx
from pydantic import BeforeValidator, Discriminator, Field, Tag, create_model

from ..fields import limit_of
from ..friction import friction_laws
from ..mechanism import DutyCycle, OperatingPoint, Stage
from .numbers import (
    TableChoice,
    module_classes,
    read_integer,
    read_number,
    read_numbers,
    row_class,
    table_choices,
    unit_of,
    usual_law,
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


def _number_or_choice(field: dataclasses.Field[Any], hint, unit: str | None) -> Any:
    limit = limit_of(unit or "1", field.metadata.get("limit"))
    if field.metadata.get("list"):
        return Annotated[tuple[Any, ...], checked(read_numbers, unit, limit)]
    if unit is not None:
        return Annotated[float, checked(read_number, unit, limit)]
    if hint is bool:
        return Annotated[bool, checked(read_boolean)]
    if hint is int:
        return Annotated[int, checked(read_integer, limit)]
    if typing.get_origin(hint) is Literal:
        return Annotated[str, checked(read_choice, typing.get_args(hint))]
    return Annotated[str, checked(read_text)]


def _law_of(laws: Iterable[str], usual: str | None):
    """Select the member of a union that a table describes, by its key `law`."""
    choices = ", ".join(f'"{name}"' for name in laws)

    def tag(data) -> str:
        return data.get("law", usual)

    def check(data):
        if not isinstance(data, dict):
            raise problem("must be a table of keys")
        if "law" not in data:
            if usual is not None:
                return data
            raise problem(f"is missing; choose one of {choices}", key="law")
        if not isinstance(data["law"], str) or data["law"] not in laws:
            raise problem(f"choose one of {choices}", key="law")
        return data

    return Discriminator(tag), BeforeValidator(check)


def _table_type(hint) -> Any:
    choices, usual = table_choices(hint), usual_law(hint)
    if "" in choices:
        return table_of(choices[""])
    discriminator, check = _law_of(choices.keys(), usual)
    members = tuple(
        Annotated[table_of(choice, name, usual), Tag(name)] for name, choice in choices.items()
    )
    return Annotated[typing.Union[members], discriminator, check]  # noqa: UP007


def _kind(field: dataclasses.Field[Any], hint, unit: str | None) -> Any:
    row = row_class(hint)
    if row is not None:
        rows = table_of(TableChoice(row))
        return Annotated[list[rows], BeforeValidator(read_tables)]
    return _table_type(hint) if module_classes(hint) else _number_or_choice(field, hint, unit)


def _meaning(field: dataclasses.Field[Any], unit: str | None) -> str:
    text = field.metadata.get("description", "")
    return text if unit in (None, "1") or not text else f"{text} [{unit}]"


def table_of(choice: TableChoice, name: str = "", usual: str | None = None) -> type[Table]:
    """The model of a class of the mechanism, from its fields; with a key `law` if it has a name."""
    fields: dict[str, Any] = {}
    if name:
        fields["law"] = (Annotated[str, checked(read_text)], name if name == usual else ...)
    for field, hint, units in choice.fields():
        unit = unit_of(field, units)
        kind = _kind(field, hint, unit)
        if choice.needs(field):
            fields[field.name] = (kind, Field(description=_meaning(field, unit)))
        else:
            fields[field.name] = (kind | None, None)
    model = create_model(choice.cls.__name__, __base__=Table, **fields)
    model.choice = choice
    return model


def document() -> type[Table]:
    """The model of a whole file, with the friction laws that are known now."""
    return _document(tuple(friction_laws().items()))


@functools.cache
def _document(laws: tuple[tuple[str, type], ...]) -> type[Table]:
    rows = BeforeValidator(read_tables)
    point: Any = table_of(TableChoice(OperatingPoint))
    stage, phase = table_of(TableChoice(Stage)), table_of(TableChoice(DutyCycle))
    stages: Any = Annotated[list[stage], rows]
    phases: Any = Annotated[list[phase], rows]
    fields: dict[str, Any] = {
        "title": (Annotated[str, checked(read_text)], ""),
        "operating_point": (point | None, None),
        "stage": (stages, Field(description="stages, as [[stage]]")),
        "duty_cycle": (phases | None, None),
        "optimise": (OptimiseTable | None, None),
        # Read by `_scenario_table`: units there depend on the place of a profile.
        "scenario": (Any, None),
    }
    return create_model("Document", __base__=Table, **fields)


def module_of(table: Table) -> eqx.Module:
    """The part of the mechanism that a validated table describes.

    **Raises:** `ValueError` if the class of the mechanism refuses the values.
    """
    assert table.choice is not None
    cls, law = table.choice.cls, table.choice.law
    values = {}
    for name in table.model_fields_set - {"law"}:
        value = getattr(table, name)
        if isinstance(value, list):
            values[name] = tuple(module_of(row) for row in value)
        else:
            values[name] = module_of(value) if isinstance(value, Table) else value
    if law is not None:
        of_law = {field.name for field in dataclasses.fields(law)} & values.keys()
        values["law"] = law(**{name: values.pop(name) for name in of_law})
    return cls(**values)
