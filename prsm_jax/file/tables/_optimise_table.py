"""The `[optimise]` table: variables with bounds, objectives, constraints, search effort."""

import math
from typing import Any

from ..._errors import UnknownNameError
from ...fields import ANY, POSITIVE, Declared, declared
from ...mechanism import (
    DUTY_CYCLE,
    Constraint,
    DesignProblem,
    Mechanism,
    Objective,
    OperatingCase,
    Variable,
    find_parameters,
)
from ..numbers import Misplaced, Place, read_integer, read_number
from ._choices_of_optimise import choice_of, read_choices
from ._operating_points import operating_points_of, read_range
from ._table import Key, plain, read_boolean, read_choice, read_keys, read_name, read_rows


def _key(one: Declared) -> Key:
    if one.words:
        read = plain(read_choice, one.words)
    elif one.whole:
        read = plain(read_integer, one.limit)
    elif one.hint is str:
        read = plain(read_name)
    else:
        # The unit of a limit depends on its quantity, which this room does not know: any, in SI.
        read = plain(read_number, None, ANY)
    return Key(read, one.description if one.required else None)


_VARIABLE, _OBJECTIVE, _CONSTRAINT, _PROBLEM = (
    {one.name: _key(one) for one in declared(cls)}
    for cls in (Variable, Objective, Constraint, DesignProblem)
)
# Bounds are read when the parameter's unit is known.
for _side in ("lower", "upper"):
    _VARIABLE[_side] = _VARIABLE[_side]._replace(read=lambda v, _: v)
_SENSE = next(one for one in declared(Objective) if one.name == "sense")
_OBJECTIVE["sense"] = _OBJECTIVE["sense"]._replace(meaning=_SENSE.description)
_NAME = Key(plain(read_name))


def _rows(keys: dict[str, Key], text: str | None = None) -> Key:
    return Key(lambda v, at: read_rows(v, at, lambda row, p: read_keys(row, p, keys)), text)


def _read_method(value: object) -> str:
    """A word such as `multi-start`; the search knows which there are."""
    read_name(value.replace("-", "_") if isinstance(value, str) else value)
    return str(value)


_PROBLEM["method"] = Key(plain(_read_method))
_PROBLEM["nut_speed"] = Key(plain(read_number, "m/s", POSITIVE))
# The range is checked with the others of the problem.
_PROBLEM["tolerance_sigmas"] = Key(plain(read_number, "1", POSITIVE))
_PROBLEM["avoid_warnings"] = Key(plain(read_boolean))
_CASE = {one.name: _key(one) for one in declared(OperatingCase)}
for _name, _unit, _limit in (("speed", "rad/s", ANY), ("load", "N", ANY), ("share", "1", POSITIVE)):
    _CASE[_name] = _CASE[_name]._replace(read=plain(read_number, _unit, _limit))
_EFFORT = (
    *("starts", "seed", "method", "points", "nut_speed", "tolerance_sigmas"),
    "avoid_warnings",
)


def _options(value: Any, place: Place) -> tuple[tuple[str, float | int], ...]:
    """Options of the search method, which knows their names."""
    if not isinstance(value, dict):
        words = "must be a table of options of the method, such as { max_iterations = 100 }"
        raise Misplaced((place, words))
    for name, one in value.items():
        if not (name.isascii() and name.isidentifier()):
            raise Misplaced(((*place, name), "must be a name of letters, digits and _"))
        # A whole number stays one: it may count iterations.
        if isinstance(one, bool) or not isinstance(one, int | float) or not math.isfinite(one):
            raise Misplaced(((*place, name), "must be a number without a unit"))
    return tuple(value.items())


_KEYS = {
    **dict.fromkeys(_SENSE.words, _NAME),
    "objective": _rows(_OBJECTIVE),
    "variable": _rows(_VARIABLE, "variables, as [[optimise.variable]]"),
    "constraint": _rows(_CONSTRAINT),
    "operating_point": _rows(_CASE),
    "operating_points": Key(plain(read_choice, (DUTY_CYCLE,))),
    "operating_range": Key(read_range),
    # The units of a list depend on its parameter, as those of bounds.
    "choices": Key(read_choices),
    "method_options": Key(_options),
    **{name: _PROBLEM[name] for name in _EFFORT},
}


def read_optimise(data: Any, place: Place) -> dict[str, Any]:
    """The keys of the table; its variables are not yet looked up.

    **Raises:** `Misplaced` with the places of all errors.
    """
    return read_keys(data, place, _KEYS)


def _objectives(table: dict[str, Any]) -> tuple[Objective, ...]:
    keys = [name for name in (*_SENSE.words, "objective") if name in table]
    if len(keys) != 1:
        text = " and ".join(keys) if keys else "none"
        message = f"needs one of maximise, minimise and [[optimise.objective]]; found {text}"
        raise Misplaced((("optimise",), message))
    if "objective" in table:
        return tuple(Objective(**row) for row in table["objective"])
    return (Objective(table[keys[0]], keys[0]),)  # type: ignore[arg-type]


def _variable(
    row: dict[str, Any], place: Place, mechanism: Mechanism, taken: dict[str, str]
) -> Variable:
    name, at = row["name"], (*place, "name")
    try:
        parameters = find_parameters(mechanism, name)
    except UnknownNameError as error:
        raise Misplaced((at, str(error))) from error
    for parameter in parameters:
        if parameter.static:
            raise Misplaced((at, "a whole number cannot be varied; sweep over it instead"))
        if parameter.path in taken:
            raise Misplaced((at, f"moves the same number as {taken[parameter.path]!r}"))
        taken[parameter.path] = name
    first = parameters[0]
    read = Key(plain(read_number, first.unit, first.limit))
    sides = {side: row[side] for side in ("lower", "upper")}
    bounds = read_keys(sides, place, dict.fromkeys(sides, read))
    if not bounds["lower"] < bounds["upper"]:
        raise Misplaced(((*place, "lower"), "must be below upper; swap or widen the bounds"))
    return Variable(name, **bounds)


def design_problem(table: dict[str, Any], mechanism: Mechanism) -> DesignProblem:
    """The design problem of an `[optimise]` table.

    **Arguments:**

    - `table`: its keys, as `read_optimise` returns them.
    - `mechanism`: the mechanism whose parameters the variables name.

    **Raises:** `Misplaced` for a name, bound or limit that makes no sense, with its place.
    """
    taken: dict[str, str] = {}
    variables = tuple(
        _variable(row, ("optimise", "variable", index), mechanism, taken)
        for index, row in enumerate(table["variable"])
    )
    constraints = []
    for index, row in enumerate(table.get("constraint", ())):
        try:
            constraints.append(Constraint(**row))
        except ValueError as error:
            raise Misplaced((("optimise", "constraint", index), str(error))) from error
    rows = table.get("choices", {}).items()
    choices = tuple(
        choice_of(name, values, mechanism, taken, ("optimise", "choices", name))
        for name, values in rows
    )
    cases = operating_points_of(table, mechanism)
    effort = {name: table[name] for name in (*_EFFORT, "method_options") if name in table}
    try:
        return DesignProblem(
            variables,
            _objectives(table),
            tuple(constraints),
            choices=choices,
            operating_points=cases,
            **effort,
        )
    except ValueError as error:
        # Keys have been checked one by one: what is left is the number of standard deviations.
        raise Misplaced((("optimise", "tolerance_sigmas"), str(error))) from error
