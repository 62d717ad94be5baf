"""Optimisation over choices: one search for every combination of listed values."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping
from typing import Any

from ..fields import FEWEST_TRACED
from ..mechanism import (
    Choice,
    DesignProblem,
    Mechanism,
    check_independent,
    find_parameters,
    set_parameters,
    stages_of_count,
)
from .results import Optimum, Trial

#: Largest number of combinations: each needs a search.
MOST_COMBINATIONS = 1000


def choices_of(choices: Mapping[str, Any]) -> tuple[Choice, ...]:
    """Choices from lists of values by the name of a parameter.

    **Raises:** `ValueError` where the values are not a list of numbers.
    """
    rows = []
    for name, values in choices.items():
        try:
            if isinstance(values, str):
                raise TypeError
            numbers = tuple(float(value) for value in values)
        except (TypeError, ValueError):
            raise ValueError(
                f"choice {name!r} has the values {values!r}; give a list of numbers [SI]"
            ) from None
        rows.append(Choice(name, numbers))
    return tuple(rows)


def best_of_choices(
    mechanism: Mechanism,
    problem: DesignProblem,
    search: Callable[[Mechanism, DesignProblem, dict[str, float]], Optimum],
) -> Optimum:
    """The best optimum of all combinations of choices, with every combination tried.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `problem`: the design problem with its choices.
    - `search`: optimises a mechanism of fixed choices; its last argument is the number of rollers
      by name, where a program can take it as a number and so be shared by several choices.

    **Raises:** `ValueError` for a choice that is a variable too, or too many combinations, or if no
    combination can be built.
    """
    _check(mechanism, problem)
    names = [one.name for one in problem.choices]
    inner = dataclasses.replace(problem, choices=())
    counts = _shared_counts(mechanism, problem)
    outcomes: list[tuple[dict[str, float], Optimum | None, str]] = []
    for values in itertools.product(*(one.values for one in problem.choices)):
        chosen = dict(zip(names, values, strict=True))
        numbers = {name: _whole(mechanism, name, value) for name, value in chosen.items()}
        try:
            moved = set_parameters(mechanism, numbers)
        except ValueError as error:
            outcomes.append((chosen, None, str(error)))
        else:
            shared = {n: v for n, v in chosen.items() if n in counts and v >= FEWEST_TRACED}
            outcomes.append((chosen, search(moved, inner, shared), ""))
    maximised = all(one.sense == "maximise" for one in problem.objectives)
    sign = -1.0 if maximised else 1.0

    def rank(place: int) -> tuple[bool, float]:
        best = outcomes[place][1]
        if best is None:
            return True, math.inf
        value = sign * best.optimum.objective if best.feasible else best.optimum.violation
        return not best.feasible, value if math.isfinite(value) else math.inf

    built = [place for place, (_, best, _) in enumerate(outcomes) if best is not None]
    if not built:
        raise ValueError(f"none of the {len(outcomes)} choices can be built: {outcomes[0][2]}")
    first = min(built, key=rank)
    winner = outcomes[first][1]
    assert winner is not None
    trials = tuple(
        _trial(chosen, best, message, place == first, winner)
        for place, (chosen, best, message) in enumerate(outcomes)
    )
    tried = [best for _, best, _ in outcomes if best is not None]
    return dataclasses.replace(
        winner,
        problem=problem,
        choices=trials,
        evaluations=sum(one.evaluations for one in tried),
        derivative_evaluations=sum(one.derivative_evaluations for one in tried),
    )


def _shared_counts(mechanism: Mechanism, problem: DesignProblem) -> set[str]:
    """Choices among several numbers of rollers that one program can take as numbers."""
    return {
        one.name
        for one in problem.choices
        if sum(value >= FEWEST_TRACED for value in one.values) > 1
        and stages_of_count(mechanism, one.name)
    }


def _check(mechanism: Mechanism, problem: DesignProblem) -> None:
    count = math.prod(len(one.values) for one in problem.choices)
    if count > MOST_COMBINATIONS:
        raise ValueError(
            f"the choices have {count} combinations, and each needs a search; give at most "
            f"{MOST_COMBINATIONS}"
        )
    for one in problem.choices:
        for parameter in find_parameters(mechanism, one.name):
            for value in one.values:
                if parameter.static and value != round(value):
                    raise ValueError(
                        f"choice {one.name!r} is {value:g}; it must be a whole number: round it or "
                        "leave it out"
                    )
    # The search sets its variables in a mechanism whose choices are made.
    check_independent(
        mechanism,
        [one.name for one in problem.choices],
        [one.name for one in problem.variables],
    )


def _whole(mechanism: Mechanism, name: str, value: float) -> float | int:
    return int(value) if find_parameters(mechanism, name)[0].static else value


def _trial(
    chosen: dict[str, float], best: Optimum | None, message: str, wins: bool, winner: Optimum
) -> Trial:
    """Result of one combination, and the reason why it was dropped."""
    if best is None:
        return Trial(chosen, None, None, "cannot be built", message, math.inf)
    value = best.optimum.objective
    if not best.feasible:
        status, words = "infeasible", best.message
    elif wins:
        status, words = "best", best.message
    else:
        status = "worse"
        words = f"objective {value:.6g}, against {winner.optimum.objective:.6g} of the best"
        if not best.converged:
            words += f"; not converged: {best.message}"
    return Trial(chosen, dict(best.optimum.variables), value, status, words, best.kkt_residual)
