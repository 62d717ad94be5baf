"""Fronts of two or three objectives, by exact gradients."""

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal

from ..fields import Scalar
from ..mechanism import (
    Constraint,
    DesignProblem,
    Mechanism,
    Objective,
    Variable,
    of_one_known_design,
)
from ._problem import avoiding, front_objectives, number, present_design, problem_of, robust
from ._starts import starting_positions
from .front import FrontSearch, ParetoFront, front_of
from .results import Reporter
from .search import Evaluator


@of_one_known_design
def pareto(
    mechanism: Mechanism,
    objectives: Mapping[Any, str] | Iterable[Objective] | None = None,
    variables: Mapping[str, tuple[Any, ...]] | Iterable[Variable] | None = None,
    constraints: Mapping[Any, Any] | Iterable[Constraint] | None = None,
    *,
    points: int | None = None,
    problem: DesignProblem | None = None,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    nut_speed: float | None = None,
    operating_points: Iterable[tuple[float, ...]] | Literal["duty_cycle"] | None = None,
    tolerance_sigmas: float | None = None,
    starts: int | None = None,
    seed: int | None = None,
    tolerance: float = 1e-6,
    progress: Callable[[int, int], None] | None = None,
    respect_findings: bool = True,
    avoid_warnings: bool | None = None,
) -> ParetoFront:
    r"""Find the front of two or three objectives within bounds and constraints.

    Each objective is first minimised alone; its range over these designs is its scale. From
    reference points $a$ on the plane where the scaled objectives sum to 1, evenly spaced, lines
    along (1, …, 1) then lead to the front: the least $t$ with $f_i - a_i \le t$ (Pascoletti and
    Serafini 1984; normal boundary intersection with inequalities), by SLSQP on exact gradients from
    the best design known so far. All searches share two compiled programs.

    Every point is judged by the Karush–Kuhn–Tucker conditions of the weighted sum that it
    minimises. Dominated and repeated designs are dropped, and listed.

    **Arguments:**

    - `mechanism`: the mechanism; the first start is its present design, moved into the bounds.
    - `objectives`: two or three quantities, or functions of a mechanism, with `"maximise"` or
      `"minimise"`, or `Objective` objects; their weights do not matter. Default those of the
      problem.
    - `variables`, `constraints`, `problem`: as for `optimise`.
    - `speed`, `load`, `nut_speed`, `operating_points`, `tolerance_sigmas`: as for `optimise`. A
      front takes means over operating points.
    - `points`: of the front, ends included, 3 to 1000; with three objectives about so many.
      Default that of the problem.
    - `starts`, `seed`: starts of the searches for the best of each objective, as for `optimise`.
    - `tolerance`: for the Karush–Kuhn–Tucker residual and for constraints, in scaled units.
    - `progress`: called with the number of finished searches and the number known so far.
    - `respect_findings`, `avoid_warnings`: whether errors and warnings of `check` are constraints,
      as for `optimise`.

    **Returns:** a `ParetoFront`. It has no points if no feasible design was found.

    **Raises:** `UnknownNameError` for unknown names; `ValueError` for an invalid problem, other
    numbers of objectives, or a number that must be whole and depends on the variables;
    `MissingDataError` where the mechanism lacks data.
    """
    given = None if objectives is None else front_objectives(objectives)
    problem = problem_of(mechanism, problem, variables, None, None, constraints, given)
    count = len(problem.objectives)
    names = [one.quantity for one in problem.objectives]
    if count not in (2, 3) or len(set(names)) < count:
        raise ValueError(
            f"a front has two or three different objectives, and the problem has {count} "
            f"({', '.join(names)}); give objectives, or [[optimise.objective]] rows in the file"
        )
    if problem.choices:
        listed = ", ".join(one.name for one in problem.choices)
        raise ValueError(
            f"a front needs one value of each number, but the problem has choices of {listed}; "
            "set these numbers, and remove the choices from the problem or from [optimise]"
        )
    problem = dataclasses.replace(
        problem,
        # A quantity of weight 0 would not be checked for numbers that are not finite.
        objectives=tuple(dataclasses.replace(one, weight=1.0) for one in problem.objectives),
        starts=problem.starts if starts is None else starts,
        seed=problem.seed if seed is None else seed,
        points=problem.points if points is None else points,
        nut_speed=problem.nut_speed if nut_speed is None else nut_speed,
    )
    problem = robust(mechanism, problem, operating_points, None, tolerance_sigmas)
    problem = avoiding(problem, avoid_warnings, respect_findings)
    for one in problem.objectives:
        if one.over == "worst":
            raise ValueError(
                f'objective {one.quantity!r} has over = "worst", and a front takes means over '
                "operating points; remove it, and limit the quantity: limits hold at every point"
            )
    if not 0 < tolerance < 1:
        raise ValueError(f"tolerance is {tolerance}; it must be between 0 and 1")
    present = present_design(mechanism, problem.variables)
    evaluator = Evaluator(
        mechanism,
        problem,
        number(speed, "speed"),
        number(load, "load"),
        margins=respect_findings,
    )
    whole = ", ".join(row.label for row in evaluator.margins.integer)
    if whole:
        raise ValueError(
            f"{whole}: this number must be whole and depends on the variables; remove the variable "
            "that changes it, and find a front for each whole number"
        )
    initial = (present - evaluator.lower) / evaluator.width
    search = FrontSearch(evaluator, problem, tolerance, progress)
    search.run(starting_positions(initial, problem.starts, problem.seed))
    return front_of(mechanism, problem, evaluator, Reporter(evaluator, problem), search, initial)
