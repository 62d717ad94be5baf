"""Writing: a mechanism to TOML text that reads back to exactly the same mechanism."""

import json
import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import equinox as eqx
import numpy as np

from .._errors import FileError, UnknownNameError, missing_extra
from ..fields import Declared, declared, values_of
from ..friction import FrictionLaw
from ..mechanism import (
    Choice,
    DampingLaw,
    DesignProblem,
    DutyCycle,
    Mechanism,
    Objective,
    Tolerance,
    find_parameters,
    of_one_known_design,
)
from ..process import whole_file
from ._read import loads
from .numbers import bare_number, table_choices, tag_of, takes_numbers, write_number
from .tables import NUMBER


def _string(text: str) -> str:
    # JSON's escapes are valid in TOML; one control character must be escaped only in TOML.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _batch(key: str, value: Any) -> FileError:
    return FileError(
        f"{key} has shape {np.shape(value)}; a batch of mechanisms is written one by one"
    )


def _number(value, unit: str, key: str) -> str:
    if np.ndim(value) != 0:
        raise _batch(key, value)
    number = float(value)
    if not math.isfinite(number):
        raise FileError(f"{key} is {number}; a file holds finite numbers only")
    return bare_number(number) if unit == "1" else write_number(number, unit)


def _module(module: eqx.Module, header: str, unit: str = "1") -> Iterator[str]:
    """The lines of a table: its own keys first, as TOML requires, then its tables.

    `unit` is that of the values of a function.
    """
    inner: list[str] = []
    for one, value in values_of(module, unit):
        key, own = f"{header}.{one.name}", one.unit or unit
        if value is None or (one.implied and value == one.default):
            continue
        if isinstance(value, tuple):
            for row in value:
                inner.extend(("", f"[[{key}]]", *_part(one.element, row, key, own)))
        elif one.registered:
            yield f"{one.name} = {_string(_word(one, value, key))}"
        elif isinstance(value, eqx.Module) or callable(value):
            inner.extend(_inner_table(one, value, key, own))
        elif one.is_list:
            if np.ndim(value) != 1:
                raise _batch(key, value)
            numbers = ", ".join(_number(number, own, key) for number in np.asarray(value))
            yield f"{one.name} = [{numbers}]"
        elif one.unit is not None:
            yield f"{one.name} = {_number(value, own, key)}"
        elif isinstance(value, bool):
            yield f"{one.name} = {str(value).lower()}"
        else:
            yield f"{one.name} = {_string(value) if isinstance(value, str) else value}"
    yield from inner


def _part(hint: Any, value: Any, header: str, unit: str) -> Iterator[str]:
    """The lines of a part, with the key that names its class if several are possible."""
    choices, tag = table_choices(hint, unit), tag_of(hint)
    name = next((name for name, choice in choices.items() if choice.holds(value)), None)
    if name is not None:
        if name:
            yield f"{tag} = {_string(name)}"
        yield from _module(value, header, unit)
    elif takes_numbers(hint) and not callable(value):
        yield from (f"{tag} = {_string(NUMBER)}", f"value = {_number(value, unit, header)}")
    elif tag == "kind" or isinstance(value, DampingLaw):
        raise FileError(
            f"{header} is a {type(value).__name__}, which a file cannot hold; use one of "
            f"{', '.join(choices)}"
        )
    else:
        raise FileError(
            f"{header} is of the class {_class_of(value)}, which files do not know; name the class "
            "with the decorator prsm_jax.friction_law"
        )


def _word(one: Declared, value: Any, key: str) -> str:
    word = one.word_of(value)
    if word is None:
        name = getattr(value, "__qualname__", type(value).__qualname__)
        raise FileError(
            f"{key} is {name}, which files do not know; name it with the decorator "
            "prsm_jax.contact.contact_approximation"
        )
    return word


def _inner_table(one: Declared, value: Any, header: str, unit: str) -> list[str]:
    lines = list(_part(one.hint, value, header, unit))
    if not lines:
        # A body without data means the same as no body, if the field's default is a body.
        return [] if isinstance(one.default, eqx.Module) else ["", f"[{header}]"]
    has_keys = lines[0] != ""
    return ["", f"[{header}]", *lines] if has_keys else lines


def _class_of(value: object) -> str:
    law = getattr(value, "law", None)
    return type(law if isinstance(law, FrictionLaw) else value).__name__


def _duty_cycle(duty_cycle: DutyCycle) -> Iterator[str]:
    fields = declared(type(duty_cycle))
    columns = [np.asarray(getattr(duty_cycle, one.name)) for one in fields]
    if any(column.ndim != 1 or len(column) != len(columns[0]) for column in columns):
        raise FileError("duty_cycle has columns of different lengths, or a batch of them")
    for row in zip(*columns, strict=True):
        yield from ("", "[[duty_cycle]]")
        for one, value in zip(fields, row, strict=True):
            yield f"{one.name} = {_number(value, one.unit or '1', 'duty_cycle')}"


def _choice(one: Choice, mechanism: Mechanism) -> str:
    parameter = find_parameters(mechanism, one.name)[0]
    if parameter.static:
        values = [str(int(value)) for value in one.values]
    else:
        values = [_number(value, parameter.unit, one.name) for value in one.values]
    name = one.name if one.name.isidentifier() else _string(one.name)
    return f"{name} = [{', '.join(values)}]"


def _optimise(
    problem: DesignProblem, mechanism: Mechanism, quantity_units: Mapping[str, str]
) -> Iterator[str]:
    yield from ("", "[optimise]")
    first = problem.objectives[0] if len(problem.objectives) == 1 else None
    short = first is not None and first.weight == 1.0 and first.over == Objective.over
    if first is not None and short:
        yield f"{first.sense} = {_string(first.quantity)}"
    for key in ("starts", "seed"):
        yield f"{key} = {getattr(problem, key)}"
    yield f"method = {_string(problem.method)}"
    if problem.method_options:
        options = (f"{name} = {_number(one, '1', name)}" for name, one in problem.method_options)
        yield f"method_options = {{ {', '.join(options)} }}"
    if problem.points != DesignProblem.points:
        yield f"points = {problem.points}"
    if problem.nut_speed is not None:
        yield f"nut_speed = {_number(problem.nut_speed, 'm/s', 'nut_speed')}"
    cases = problem.operating_points
    if isinstance(cases, str):
        yield f"operating_points = {_string(cases)}"
        cases = ()
    if problem.tolerance_sigmas is not None:
        yield f"tolerance_sigmas = {_number(problem.tolerance_sigmas, '1', 'tolerance_sigmas')}"
    if problem.avoid_warnings:
        yield "avoid_warnings = true"
    if problem.choices:
        yield f"choices = {{ {', '.join(_choice(one, mechanism) for one in problem.choices)} }}"
    for objective in () if short else problem.objectives:
        yield from ("", "[[optimise.objective]]")
        yield f"quantity = {_string(objective.quantity)}"
        yield f"sense = {_string(objective.sense)}"
        yield f"weight = {_number(objective.weight, '1', 'weight')}"
        if objective.over != Objective.over:
            yield f"over = {_string(objective.over)}"
    for case in cases:
        yield from ("", "[[optimise.operating_point]]")
        for name, unit in (("speed", "rad/s"), ("load", "N"), ("share", "1")):
            yield f"{name} = {_number(getattr(case, name), unit, name)}"
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


def _tolerances(tolerances: tuple[Tolerance, ...], mechanism: Mechanism) -> Iterator[str]:
    yield from ("", "[tolerances]")
    for one in tolerances:
        # A name with dots would be a table within a table.
        key = _string(one.name) if "." in one.name else one.name
        unit = find_parameters(mechanism, one.name)[0].unit
        usual = one == Tolerance(one.name, one.lower, one.upper, cost=one.cost)
        if usual and one.lower == -one.upper:
            half = _number(one.upper, unit, one.name)
            yield f"{key} = " + (f'"±{half[1:]}' if half.startswith('"') else half)
            continue
        words = [
            f"{side} = {_number(getattr(one, side), unit, key)}" for side in ("lower", "upper")
        ]
        words.append(f"distribution = {_string(one.distribution)}")
        if one.distribution == "normal":
            words.append(f"sigmas = {_number(one.sigmas, '1', key)}")
        yield f"{key} = {{ {', '.join(words)} }}"
    if any(one.cost != 1.0 for one in tolerances):
        yield from ("", "[tolerances.cost]")
        for one in tolerances:
            key = _string(one.name) if "." in one.name else one.name
            yield f"{key} = {_number(one.cost, '1', key)}"


def _lines(mechanism: Mechanism, quantity_units: Mapping[str, str]) -> Iterator[str]:
    yield f"title = {_string(mechanism.title)}"
    for name in ("author", "revision"):
        if getattr(mechanism, name):
            yield f"{name} = {_string(getattr(mechanism, name))}"
    if mechanism.operating_point is not None:
        yield from ("", "[operating_point]")
        yield from _module(mechanism.operating_point, "operating_point")
    for stage in mechanism.stages:
        yield from ("", "[[stage]]")
        yield from _module(stage, "stage")
    if mechanism.axis is not None:
        yield from ("", "[axis]", *_module(mechanism.axis, "axis"))
    if mechanism.duty_cycle is not None:
        yield from _duty_cycle(mechanism.duty_cycle)
    if mechanism.scenario is not None:
        yield from ("", "[scenario]", *_module(mechanism.scenario, "scenario"))
    if mechanism.design_problem is not None:
        yield from _optimise(mechanism.design_problem, mechanism, quantity_units)
    if mechanism.tolerances is not None:
        yield from _tolerances(mechanism.tolerances, mechanism)


@of_one_known_design
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
    is negative; `MissingExtraError` if pint is not installed.
    """
    text = unread_text(mechanism, quantity_units)
    loads(text, name="the mechanism to write")
    return text


def unread_text(mechanism: Mechanism, quantity_units: Mapping[str, str] | None = None) -> str:
    """The text of `dumps`, without reading it back; for a mechanism that was read from a file.

    **Raises:** `FileError` if a table cannot be written; `MissingExtraError` if pint is not
    installed.
    """
    try:
        import pint  # noqa: F401
    except ModuleNotFoundError as error:
        raise missing_extra("file", "writing mechanism files", error) from error
    try:
        return "\n".join(_lines(mechanism, quantity_units or {})) + "\n"
    except UnknownNameError as error:
        raise FileError(
            f"the [optimise] or [tolerances] table cannot be written: {error}"
        ) from error


@of_one_known_design
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
