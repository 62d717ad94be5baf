"""The `[optimise]` table: variables with bounds, objectives, constraints, search effort."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from ..._errors import UnknownNameError
from ...fields import ANY, Limit
from ...mechanism import Constraint, DesignProblem, Mechanism, Objective, Variable, find_parameters
from ..numbers import Misplaced, read_integer, read_number
from ._table import Table, checked, read_choice, read_name, read_tables

_Name = Annotated[str, checked(read_name)]
# The unit of a limit depends on its quantity, which this room does not know: any unit, in SI.
_Limit = Annotated[float, checked(read_number, None, ANY)]
_Rows = BeforeValidator(read_tables)
_STARTS = Limit(1.0, 10_000.0, "a whole number from 1 to 10000")
_SEED = Limit(0.0, 2.0**32 - 1, "a whole number from 0 to 4294967295")
_SENSES = ("maximise", "minimise")


class VariableTable(Table):
    """`[[optimise.variable]]`; the bounds are read when the parameter's unit is known."""

    name: _Name = Field(description="name of a parameter")
    lower: Any = Field(description="lower bound")
    upper: Any = Field(description="upper bound")


class ObjectiveTable(Table):
    """`[[optimise.objective]]`: one term of a weighted sum."""

    quantity: _Name = Field(description="name of a quantity")
    sense: Annotated[str, checked(read_choice, _SENSES)] = Field(
        description='direction: "maximise" or "minimise"'
    )
    weight: _Limit = 1.0


class ConstraintTable(Table):
    """`[[optimise.constraint]]`: limits on one quantity."""

    quantity: _Name = Field(description="name of a quantity")
    lower: _Limit | None = None
    upper: _Limit | None = None
    equal: _Limit | None = None


class OptimiseTable(Table):
    """`[optimise]`: one quantity to maximise or minimise, or a weighted list of objectives."""

    maximise: _Name | None = None
    minimise: _Name | None = None
    objective: Annotated[list[ObjectiveTable], _Rows] | None = None
    variable: Annotated[list[VariableTable], _Rows] = Field(
        description="variables, as [[optimise.variable]]"
    )
    constraint: Annotated[list[ConstraintTable], _Rows] | None = None
    starts: Annotated[int, checked(read_integer, _STARTS)] = 1
    seed: Annotated[int, checked(read_integer, _SEED)] = 0
    method: _Name = "auto"


def _objectives(table: OptimiseTable) -> tuple[Objective, ...]:
    keys = [name for name in (*_SENSES, "objective") if getattr(table, name) is not None]
    if len(keys) != 1:
        text = " and ".join(keys) if keys else "none"
        raise Misplaced(
            ("optimise",),
            f"needs one of maximise, minimise and [[optimise.objective]]; found {text}",
        )
    if table.objective is not None:
        return tuple(
            Objective(o.quantity, o.sense, o.weight)  # type: ignore[arg-type]
            for o in table.objective
        )
    sense = keys[0]
    return (Objective(getattr(table, sense), sense),)  # type: ignore[arg-type]


def _variable(table: VariableTable, mechanism: Mechanism, taken: dict[str, str]) -> Variable:
    try:
        parameters = find_parameters(mechanism, table.name)
    except UnknownNameError as error:
        raise Misplaced(("name",), str(error)) from error
    for parameter in parameters:
        if parameter.static:
            raise Misplaced(("name",), "a whole number cannot be varied; sweep over it instead")
        if parameter.path in taken:
            raise Misplaced(("name",), f"moves the same number as {taken[parameter.path]!r}")
        taken[parameter.path] = table.name
    first = parameters[0]
    bounds = {}
    for side in ("lower", "upper"):
        try:
            bounds[side] = read_number(getattr(table, side), first.unit, first.limit)
        except ValueError as error:
            raise Misplaced((side,), str(error)) from error
    if not bounds["lower"] < bounds["upper"]:
        raise Misplaced(("lower",), "must be below upper; swap or widen the bounds")
    return Variable(table.name, bounds["lower"], bounds["upper"])


def design_problem(table: OptimiseTable, mechanism: Mechanism) -> DesignProblem:
    """The design problem of a validated `[optimise]` table.

    **Arguments:**

    - `table`: the table.
    - `mechanism`: the mechanism whose parameters the variables name.

    **Raises:** `Misplaced` for a name, bound or limit that makes no sense, with its place.
    """
    variables: list[Variable] = []
    taken: dict[str, str] = {}
    for index, row in enumerate(table.variable):
        try:
            variables.append(_variable(row, mechanism, taken))
        except Misplaced as error:
            raise Misplaced(("optimise", "variable", index, *error.place), error.message) from None
    constraints = []
    for index, row in enumerate(table.constraint or ()):
        try:
            constraints.append(Constraint(row.quantity, row.lower, row.upper, row.equal))
        except ValueError as error:
            raise Misplaced(("optimise", "constraint", index), str(error)) from error
    return DesignProblem(
        tuple(variables),
        _objectives(table),
        tuple(constraints),
        table.starts,
        table.seed,
        table.method,
    )
