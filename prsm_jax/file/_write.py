"""Writing: a mechanism to TOML text that reads back to exactly the same mechanism."""

import dataclasses
import json
import math
import os
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import equinox as eqx
import numpy as np

from .._errors import FileError, UnknownNameError, missing_extra
from ..friction import FrictionLaw
from ..mechanism import DesignProblem, DutyCycle, Mechanism, find_parameters
from ..process import whole_file
from ._read import loads
from ._scenario_lines import scenario_lines
from .numbers import bare_number, is_law_field, row_class, table_choices, unit_of, write_number


def _string(text: str) -> str:
    # JSON's escapes are valid in TOML; one control character must be escaped only in TOML.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _number(value, unit: str, key: str) -> str:
    if np.ndim(value) != 0:
        raise FileError(
            f"{key} has shape {np.shape(value)}; a batch of mechanisms is written one by one"
        )
    number = float(value)
    if not math.isfinite(number):
        raise FileError(f"{key} is {number}; a file holds finite numbers only")
    return bare_number(number) if unit == "1" else write_number(number, unit)


def _module(module: eqx.Module, header: str, units: Mapping[str, str] | None = None):
    """The lines of a table: its own keys first, as TOML requires, then its tables."""
    hints = typing.get_type_hints(type(module))
    inner: list[str] = []
    for field in dataclasses.fields(module):
        value, unit = getattr(module, field.name), unit_of(field, dict(units or {}))
        if value is None:
            continue
        if is_law_field(field):
            yield from _module(value, header, field.metadata["units"])
        elif row_class(hints[field.name]) is not None:
            for row in value:
                inner.extend(("", f"[[{header}.{field.name}]]", *_module(row, header)))
        elif isinstance(value, eqx.Module):
            inner.extend(_inner_table(field, value, hints[field.name], f"{header}.{field.name}"))
        elif field.metadata.get("list"):
            if np.ndim(value) != 1:
                raise FileError(
                    f"{header}.{field.name} has shape {np.shape(value)}; a batch of mechanisms is "
                    "written one by one"
                )
            key = f"{header}.{field.name}"
            numbers = ", ".join(_number(one, unit or "1", key) for one in np.asarray(value))
            yield f"{field.name} = [{numbers}]"
        elif unit is not None:
            yield f"{field.name} = {_number(value, unit, f'{header}.{field.name}')}"
        elif isinstance(value, str):
            if not (field.metadata.get("implied") and value == field.default):
                yield f"{field.name} = {_string(value)}"
        elif isinstance(value, bool):
            if value != field.default:
                yield f"{field.name} = {str(value).lower()}"
        else:
            yield f"{field.name} = {value}"
    yield from inner


def _inner_table(field: dataclasses.Field[Any], value: eqx.Module, hint, header: str) -> list[str]:
    choices = table_choices(hint)
    law = next((name for name, choice in choices.items() if choice.holds(value)), None)
    if law is None:
        raise FileError(
            f"{header} is of the class {_class_of(value)}, which files do not know; name the class "
            "with the decorator prsm_jax.friction_law"
        )
    lines = [f"law = {_string(law)}"] if law else []
    lines += list(_module(value, header))
    if not lines:
        # A body without data means the same as no body, if the field's default is a body.
        return [] if isinstance(field.default, eqx.Module) else ["", f"[{header}]"]
    has_keys = lines[0] != ""
    return ["", f"[{header}]", *lines] if has_keys else lines


def _class_of(value: eqx.Module) -> str:
    law = getattr(value, "law", None)
    return type(law if isinstance(law, FrictionLaw) else value).__name__


def _duty_cycle(duty_cycle: DutyCycle) -> Iterator[str]:
    fields = dataclasses.fields(duty_cycle)
    columns = [np.asarray(getattr(duty_cycle, field.name)) for field in fields]
    if any(column.ndim != 1 or len(column) != len(columns[0]) for column in columns):
        raise FileError("duty_cycle has columns of different lengths, or a batch of them")
    for row in zip(*columns, strict=True):
        yield from ("", "[[duty_cycle]]")
        for field, value in zip(fields, row, strict=True):
            yield f"{field.name} = {_number(value, field.metadata['unit'], 'duty_cycle')}"


def _optimise(
    problem: DesignProblem, mechanism: Mechanism, quantity_units: Mapping[str, str]
) -> Iterator[str]:
    yield from ("", "[optimise]")
    first = problem.objectives[0] if len(problem.objectives) == 1 else None
    short = first is not None and first.weight == 1.0
    if first is not None and short:
        yield f"{first.sense} = {_string(first.quantity)}"
    for key in ("starts", "seed"):
        yield f"{key} = {getattr(problem, key)}"
    yield f"method = {_string(problem.method)}"
    for objective in () if short else problem.objectives:
        yield from ("", "[[optimise.objective]]")
        yield f"quantity = {_string(objective.quantity)}"
        yield f"sense = {_string(objective.sense)}"
        yield f"weight = {_number(objective.weight, '1', 'weight')}"
    for variable in problem.variables:
        yield from ("", "[[optimise.variable]]", f"name = {_string(variable.name)}")
        unit = find_parameters(mechanism, variable.name)[0].unit
        for side in ("lower", "upper"):
            yield f"{side} = {_number(getattr(variable, side), unit, variable.name)}"
    for constraint in problem.constraints:
        yield from ("", "[[optimise.constraint]]", f"quantity = {_string(constraint.quantity)}")
        for side in ("lower", "upper", "equal"):
            limit = getattr(constraint, side)
            if limit is not None:
                unit = quantity_units.get(constraint.quantity, "1")
                yield f"{side} = {_number(limit, unit, constraint.quantity)}"


def _lines(mechanism: Mechanism, quantity_units: Mapping[str, str]) -> Iterator[str]:
    yield f"title = {_string(mechanism.title)}"
    if mechanism.operating_point is not None:
        yield from ("", "[operating_point]")
        yield from _module(mechanism.operating_point, "operating_point")
    for stage in mechanism.stages:
        yield from ("", "[[stage]]")
        yield from _module(stage, "stage")
    if mechanism.duty_cycle is not None:
        yield from _duty_cycle(mechanism.duty_cycle)
    if mechanism.scenario is not None:
        yield from scenario_lines(mechanism.scenario, _number, _string)
    if mechanism.design_problem is not None:
        yield from _optimise(mechanism.design_problem, mechanism, quantity_units)


def dumps(mechanism: Mechanism, quantity_units: Mapping[str, str] | None = None) -> str:
    """A mechanism as TOML text with units.

    Every number is written in the engineering unit that needs the fewest digits and reads back
    to the same double, so `loads(dumps(m))` is exactly `m`.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers (not traced, not a batch).
    - `quantity_units`: SI units of the quantities that constraints limit; the limits of others are
        written as bare SI numbers.

    **Returns:** the text.

    **Raises:** `FileError` if the mechanism could not be read back, for example because a length
    is negative; `MissingExtraError` if pydantic or pint is not installed.
    """
    try:
        import pint  # noqa: F401
        import pydantic  # noqa: F401
    except ModuleNotFoundError as error:
        raise missing_extra("file", "writing mechanism files", error) from error
    try:
        text = "\n".join(_lines(mechanism, quantity_units or {})) + "\n"
    except UnknownNameError as error:
        raise FileError(f"the [optimise] table cannot be written: {error}") from error
    loads(text, name="the mechanism to write")
    return text


def dump(
    mechanism: Mechanism,
    path: str | Path,
    quantity_units: Mapping[str, str] | None = None,
) -> None:
    """Write a mechanism to a TOML file, completely or not at all.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    - `path`: the file; an existing one is replaced.
    - `quantity_units`: as for `dumps`.

    **Raises:** `FileError` if the mechanism cannot be written or the file cannot be made; an
    existing file is then unchanged.
    """
    text = dumps(mechanism, quantity_units)
    target = Path(path)
    try:
        with (
            whole_file(target) as partial,
            partial.open("x", encoding="utf-8", newline="\n") as file,
        ):
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise FileError(f"{target}: cannot be written: {error.strerror or error}") from error
