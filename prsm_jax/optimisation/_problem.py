"""The design problem: that of the mechanism, or one from arguments."""

import dataclasses
import operator
from collections.abc import Iterable, Mapping
from typing import Any, Literal, cast

import jax.numpy as jnp
import numpy as np

from ..fields import Scalar, check_number
from ..mechanism import (
    DUTY_CYCLE,
    Constraint,
    DesignProblem,
    Mechanism,
    Objective,
    OperatingCase,
    Variable,
    check_independent,
    find_parameters,
)
from ..quantities import QuantityLike, find_quantity, quantity_name, quantity_names


def problem_of(
    mechanism: Mechanism,
    problem: DesignProblem | None,
    variables: Any,
    maximise: QuantityLike | Mapping[Any, float | int] | None,
    minimise: QuantityLike | Mapping[Any, float | int] | None,
    constraints: Any,
    objectives: tuple[Objective, ...] | None = None,
) -> DesignProblem:
    """The design problem: each part from its argument, or else from `problem` or the mechanism.

    `objectives` replaces `maximise` and `minimise`.

    **Raises:** `ValueError` where a part is missing or wrong; `UnknownNameError` for unknown names.
    """
    if problem is None:
        problem = mechanism.design_problem
    new_variables = _variables(variables) if variables is not None else None
    new_objectives = objectives
    if maximise is not None or minimise is not None:
        new_objectives = (*_objectives(maximise, "maximise"), *_objectives(minimise, "minimise"))
    new_constraints = constraints_of(constraints) if constraints is not None else None
    if problem is None:
        if new_variables is None or new_objectives is None:
            raise ValueError(
                "the mechanism has no design problem; give variables and maximise or minimise "
                "(objectives for a front), or an [optimise] table in its file"
            )
        problem = DesignProblem(new_variables, new_objectives, new_constraints or ())
    else:
        problem = dataclasses.replace(
            problem,
            variables=problem.variables if new_variables is None else new_variables,
            objectives=problem.objectives if new_objectives is None else new_objectives,
            constraints=problem.constraints if new_constraints is None else new_constraints,
        )
    if not problem.variables:
        raise ValueError("the design problem has no variables; give at least one")
    if not problem.objectives:
        raise ValueError("the design problem has no objective; give maximise or minimise")
    return _with_names(problem)


def _with_names(problem: DesignProblem) -> DesignProblem:
    """A problem in which two functions of the same name have numbers.

    **Raises:** `UnknownNameError` for an unknown quantity.
    """
    terms = (*problem.objectives, *problem.constraints)
    named: list[Any] = []
    for term, name in zip(terms, quantity_names(one.quantity for one in terms), strict=True):
        find_quantity(name)
        named.append(dataclasses.replace(term, quantity=name))
    count = len(problem.objectives)
    return dataclasses.replace(
        problem, objectives=tuple(named[:count]), constraints=tuple(named[count:])
    )


def _variables(variables) -> tuple[Variable, ...]:
    if isinstance(variables, Mapping):
        rows = []
        for name, bounds in variables.items():
            try:
                lower, upper = bounds
            except (TypeError, ValueError):
                raise ValueError(
                    f"variable {name!r} has the bounds {bounds!r}; give (lower, upper)"
                ) from None
            rows.append(Variable(name, float(lower), float(upper)))
        return tuple(rows)
    return tuple(variables)


def _objectives(
    terms: QuantityLike | Mapping[Any, float | int] | None,
    sense: Literal["maximise", "minimise"],
) -> tuple[Objective, ...]:
    if terms is None:
        return ()
    if isinstance(terms, str) or callable(terms):
        return (Objective(quantity_name(terms), sense),)
    if isinstance(terms, Mapping):
        return tuple(
            Objective(quantity_name(one), sense, float(weight)) for one, weight in terms.items()
        )
    raise ValueError(f"{sense} is {terms!r}; give a quantity, or a dictionary of weights")


def front_objectives(
    objectives: Mapping[Any, str] | Iterable[Objective],
) -> tuple[Objective, ...]:
    """The objectives of a front, from their senses by quantity or from `Objective` objects.

    **Raises:** `ValueError` for a quantity without a sense, or an unknown sense.
    """
    if not isinstance(objectives, Mapping):
        given = tuple(objectives)
        if not all(isinstance(one, Objective) for one in given):
            raise ValueError(
                f"objectives are {objectives!r}; give the sense of each, such as "
                '{"efficiency": "maximise", "mass": "minimise"}'
            )
        return given
    rows: list[Objective] = []
    for quantity, sense in cast("Mapping[QuantityLike, str]", objectives).items():
        name = quantity_name(quantity)
        if sense not in ("maximise", "minimise"):
            raise ValueError(
                f'objective {name!r} has the sense {sense!r}; write "maximise" or "minimise"'
            )
        rows.append(Objective(name, sense))
    return tuple(rows)


def cases_of(points: Iterable[tuple[float, ...]]) -> tuple[OperatingCase, ...]:
    """Operating points from (speed, load) or (speed, load, share) [rad/s, N, 1].

    **Raises:** `ValueError` for anything else, or without any.
    """
    rows: list[OperatingCase] = []
    for one in points:
        try:
            numbers = [float(value) for value in one]
        except (TypeError, ValueError):
            numbers = []
        if len(numbers) not in (2, 3):
            raise ValueError(
                f"operating point {one!r} is not valid; give (speed, load) or (speed, load, share) "
                "in rad/s and N"
            )
        rows.append(OperatingCase(*numbers))
    if not rows:
        raise ValueError("operating_points is empty; give at least one, or leave it out")
    return tuple(rows)


def robust(
    mechanism: Mechanism,
    problem: DesignProblem,
    operating_points: Iterable[tuple[float, ...]] | str | None,
    worst_case: bool | None,
    tolerance_sigmas: float | None,
) -> DesignProblem:
    """A problem with its operating points as a list; arguments replace its own settings.

    **Raises:** `ValueError` for operating points that are not valid, or a missing duty cycle.
    """
    points = problem.operating_points if operating_points is None else operating_points
    if isinstance(points, str):
        if points != DUTY_CYCLE:
            raise ValueError(
                f'operating_points is {points!r}; write "{DUTY_CYCLE}", or give '
                "(speed, load, share) for each"
            )
        points = _phases(mechanism)
    if not isinstance(points, tuple) or not all(isinstance(one, OperatingCase) for one in points):
        points = cases_of(cast("Iterable[tuple[float, ...]]", points))
    problem = dataclasses.replace(
        problem,
        operating_points=points,
        tolerance_sigmas=problem.tolerance_sigmas if tolerance_sigmas is None else tolerance_sigmas,
    )
    if worst_case is None:
        return problem
    over = "worst" if worst_case else "mean"
    terms = tuple(dataclasses.replace(one, over=over) for one in problem.objectives)
    return dataclasses.replace(problem, objectives=terms)


def avoiding(problem: DesignProblem, warnings: bool | None, respected: bool) -> DesignProblem:
    """A problem whose search avoids warnings of `check`, or does not; `None` leaves it.

    Where findings are not `respected`, warnings are not either.

    **Raises:** `ValueError` where warnings are to be avoided, and findings not respected.
    """
    if warnings is None:
        warnings = problem.avoid_warnings and respected
    if warnings and not respected:
        raise ValueError(
            "avoid_warnings is True and respect_findings False; leave out one of them: limits of "
            "check are constraints, or they are not"
        )
    return dataclasses.replace(problem, avoid_warnings=warnings)


def _phases(mechanism: Mechanism) -> tuple[OperatingCase, ...]:
    """The phases of the duty cycle, with their durations as shares."""
    cycle = mechanism.duty_cycle
    if cycle is None:
        raise ValueError(
            f'operating_points is "{DUTY_CYCLE}", and the mechanism has none; give [[duty_cycle]] '
            "phases in its file, or (speed, load, share) for each"
        )
    columns = (np.asarray(one, float).tolist() for one in (cycle.speed, cycle.load, cycle.duration))
    return tuple(OperatingCase(*row) for row in zip(*columns, strict=True))


def number(value: float | Scalar | None, name: str) -> Scalar | None:
    """An operating speed or load as an array.

    A Python number would be a constant of the program: another speed would compile again.

    **Raises:** `ValueError` for a number that is not finite.
    """
    if value is None:
        return None
    if not np.isfinite(np.asarray(value, float)):
        unit = "N" if name == "load" else "rad/s"
        raise ValueError(f"{name} is {value}; give a finite number in {unit}")
    return jnp.asarray(value, jnp.result_type(float))


def whole_number(value: Any, name: str, least: int) -> int:
    """A whole number among the settings of a search.

    **Raises:** `ValueError` for any other.
    """
    try:
        whole = operator.index(value)
    except TypeError:
        whole = least - 1
    if whole < least or isinstance(value, bool):
        raise ValueError(f"{name} is {value}; give a whole number of {least} or more")
    return whole


def refuse_opposed(problem: DesignProblem) -> None:
    """**Raises:** `ValueError` for a quantity that is maximised and minimised in one sum."""
    senses: dict[tuple[str, str], str] = {}
    for one in problem.objectives:
        if senses.setdefault((one.quantity, one.over), one.sense) != one.sense:
            raise ValueError(
                f"{one.quantity!r} is both maximised and minimised, and the terms cancel; keep one "
                "of them"
            )


def constraints_of(
    constraints: Mapping[Any, Any] | Iterable[Constraint],
) -> tuple[Constraint, ...]:
    """Constraints from limits by quantity: (lower, upper) [SI], or one number for an equality.

    **Arguments:**

    - `constraints`: the limits, `None` for no limit on a side; or `Constraint` objects, which are
      returned as they are.

    **Raises:** `ValueError` for limits that are not a pair, or in the wrong order.
    """
    if not isinstance(constraints, Mapping):
        return tuple(constraints)
    rows: list[Constraint] = []
    for quantity, limits in cast("Mapping[QuantityLike, Any]", constraints).items():
        name = quantity_name(quantity)
        if isinstance(limits, int | float):
            rows.append(Constraint(name, equal=float(limits)))
            continue
        try:
            lower, upper = limits
        except (TypeError, ValueError):
            raise ValueError(
                f"constraint on {name!r} has the limits {limits!r}; give (lower, upper), with "
                "None for no limit, or one number for an equality"
            ) from None
        rows.append(
            Constraint(
                name,
                None if lower is None else float(lower),
                None if upper is None else float(upper),
            )
        )
    return tuple(rows)


def present_design(mechanism: Mechanism, variables: tuple[Variable, ...]) -> np.ndarray:
    """Present values of the variables [SI].

    **Raises:** `ValueError` for a static variable, bounds that are not finite or outside of the
    parameter's limit, two variables that move the same number, or stages with different values.
    """
    values = []
    for variable in variables:
        if not (np.isfinite(variable.lower) and np.isfinite(variable.upper)):
            raise ValueError(
                f"variable {variable.name!r} has the bounds ({variable.lower}, {variable.upper}); "
                "both must be finite"
            )
        parameters = find_parameters(mechanism, variable.name)
        if any(parameter.static for parameter in parameters):
            raise ValueError(
                f"variable {variable.name!r} is a whole number and cannot be varied smoothly; "
                "sweep over it instead"
            )
        for side in ("lower", "upper"):
            owner = f"variable {variable.name!r}: "
            for one in parameters:
                bound = getattr(variable, side)
                check_number(owner, f"{side} bound", one.unit, bound, one.limit)
        present = [float(parameter.get(mechanism)) for parameter in parameters]
        if not np.allclose(present, present[0], rtol=1e-12, atol=0.0):
            listed = ", ".join(f"{value:g}" for value in present)
            paths = " or ".join(parameter.path for parameter in parameters)
            raise ValueError(
                f"variable {variable.name!r} differs between the stages ({listed}), so there is "
                f"no common start; name the stage: {paths}"
            )
        values.append(present[0])
    check_independent(mechanism, [variable.name for variable in variables])
    return np.array(values)
