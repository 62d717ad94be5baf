"""The `[optimise]` table: variables with bounds, objectives, constraints, search effort."""

from typing import Any

from ..._errors import UnknownNameError
from ...fields import ANY, POSITIVE, Declared, declared
from ...mechanism import (
    DUTY_CYCLE,
    Choice,
    Constraint,
    DesignProblem,
    Mechanism,
    Objective,
    OperatingCase,
    Variable,
    find_parameters,
)
from ..numbers import Misplaced, Place, read_integer, read_number
from ._table import Key, plain, read_choice, read_keys, read_name, read_rows


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


_PROBLEM["nut_speed"] = Key(plain(read_number, "m/s", POSITIVE))
# The range is checked with the others of the problem.
_PROBLEM["tolerance_sigmas"] = Key(plain(read_number, "1", POSITIVE))
_CASE = {one.name: _key(one) for one in declared(OperatingCase)}
for _name, _unit, _limit in (("speed", "rad/s", ANY), ("load", "N", ANY), ("share", "1", POSITIVE)):
    _CASE[_name] = _CASE[_name]._replace(read=plain(read_number, _unit, _limit))
_EFFORT = ("starts", "seed", "method", "points", "nut_speed", "tolerance_sigmas")
_KEYS = {
    **dict.fromkeys(_SENSE.words, _NAME),
    "objective": _rows(_OBJECTIVE),
    "variable": _rows(_VARIABLE, "variables, as [[optimise.variable]]"),
    "constraint": _rows(_CONSTRAINT),
    "operating_point": _rows(_CASE),
    "operating_points": Key(plain(read_choice, (DUTY_CYCLE,))),
    # The units of a list depend on its parameter, as those of bounds.
    "choices": Key(lambda v, at: _lists(v, at)),
    **{name: _PROBLEM[name] for name in _EFFORT},
}


def _lists(value: Any, place: Place) -> dict[str, list[Any]]:
    if not isinstance(value, dict) or not value:
        words = "must be a table of lists, such as { roller_count = [8, 9, 10] }"
        raise Misplaced((place, words))
    for name, one in value.items():
        if not isinstance(one, list) or not one:
            raise Misplaced(((*place, name), "must be a list of values"))
    return value


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


def _choice(name: str, values: list[Any], mechanism: Mechanism, taken: dict[str, str]) -> Choice:
    at = ("optimise", "choices", name)
    try:
        parameters = find_parameters(mechanism, name)
    except UnknownNameError as error:
        raise Misplaced((at, str(error))) from error
    for parameter in parameters:
        if parameter.path in taken:
            raise Misplaced((at, f"moves the same number as {taken[parameter.path]!r}"))
        taken[parameter.path] = name
    first, numbers = parameters[0], []
    for value in values:
        try:
            if first.static:
                numbers.append(float(read_integer(value, first.limit)))
            else:
                numbers.append(read_number(value, first.unit, first.limit))
        except ValueError as error:
            raise Misplaced((at, str(error))) from error
    try:
        return Choice(name, tuple(numbers))
    except ValueError as error:
        raise Misplaced((at, str(error))) from error


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
    choices = tuple(_choice(name, values, mechanism, taken) for name, values in rows)
    cases = _cases(table, mechanism)
    effort = {name: table[name] for name in _EFFORT if name in table}
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


def _cases(table: dict[str, Any], mechanism: Mechanism) -> Any:
    """The operating points of the table, or the word for those of the duty cycle."""
    cases = tuple(OperatingCase(**row) for row in table.get("operating_point", ()))
    word = table.get("operating_points")
    keys = [key for key in ("operating_point", "operating_points") if table.get(key)]
    if len(keys) == 2:
        message = "is given beside [[optimise.operating_point]]; give one of them"
        raise Misplaced((("optimise", "operating_points"), message))
    if keys and "nut_speed" in table:
        message = "both set the speed of the screw; give nut_speed or operating points"
        raise Misplaced((("optimise", keys[0]), message))
    if word is not None and mechanism.duty_cycle is None:
        message = 'is "duty_cycle", and the file has no [[duty_cycle]]; give its phases'
        raise Misplaced((("optimise", "operating_points"), message))
    return cases if word is None else word
