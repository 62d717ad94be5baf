"""The gradients at the points of a front, in numbers and in words."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..optimisation import FrontPoint, ParetoFront
from ..text import number
from ._conflict import plain
from ._map import DriverMap
from ._problem import StudyProblem

#: A quantity "hardly changes" if its elasticity is below this [% per %].
_LITTLE = 5e-4
#: A weight up to this marks an end of the front, where one objective has no influence: the search
#: for the other objective gives it a weight of 1e-4.
_END = 1e-3


@dataclass(frozen=True)
class FrontGradient:
    """The gradient at one point of a front.

    - `elasticities`: per cent of a quantity per per cent of a driver, by quantity and driver.
    - `exchange`: relative change of the first objective for a relative change of the second along
      the front [% per %]; NaN with three objectives, or at an end.
    - `sentence`: the same in words.
    """

    elasticities: dict[str, dict[str, float]]
    exchange: float
    sentence: str

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON; `None` where one is not finite."""
        return {
            "elasticities": {
                name: {by: plain(value) for by, value in row.items()}
                for name, row in self.elasticities.items()
            },
            "exchange": plain(self.exchange),
            "sentence": self.sentence,
        }


def gradients_at(problem: StudyProblem, designs: DriverMap, index: int) -> dict[str, Any]:
    """Elasticities of all quantities at a design of a list, by quantity and driver."""
    return {
        name: {
            one.name: float(rows[index, place]) for place, one in enumerate(problem.drivers)
        }
        for name, rows in designs.elasticities.items()
    }  # fmt: skip


def front_gradients(
    problem: StudyProblem, front: ParetoFront, designs: DriverMap, first: int
) -> tuple[FrontGradient, ...]:
    """The gradient at each point of a front.

    **Arguments:**

    - `problem`: the problem of the study.
    - `front`: the front.
    - `designs`: a list of designs, with those of the front from the place `first`.
    """
    gradients = []
    for index, point in enumerate(front.points):
        elasticities = gradients_at(problem, designs, first + index)
        exchange = _exchange(front, point)
        gradients.append(
            FrontGradient(elasticities, exchange, _sentence(problem, point, elasticities, exchange))
        )
    return tuple(gradients)


def _exchange(front: ParetoFront, point: FrontPoint) -> float:
    """Relative change of the first objective by that of the second, from the weights."""
    if len(front.objectives) != 2 or len(front.points) < 2:
        return math.nan
    (first, second), values = front.objectives, front.values
    weights = [point.weights[one.quantity] for one in (first, second)]
    if min(weights) <= _END:
        return math.nan
    ranges = np.ptp(values, axis=0)
    sign = -1.0 if first.sense == second.sense else 1.0
    slope = sign * (weights[1] / ranges[1]) / (weights[0] / ranges[0])
    values_here = [point.objectives[one.quantity] for one in (first, second)]
    return float(slope * values_here[1] / values_here[0]) if values_here[0] else math.nan


def words(name: str) -> str:
    """A name of the code as words."""
    return name.replace("_", " ")


def change_in_words(driver: str, elasticities: Mapping[str, Mapping[str, float]]) -> str:
    """A clause on the change of quantities for 1 % more of a driver.

    **Arguments:**

    - `driver`: its name.
    - `elasticities`: of the quantities that the clause names, by quantity and driver.
    """
    parts: dict[str, list[str]] = {"raises": [], "lowers": []}
    same = []
    for name, row in elasticities.items():
        value = row[driver]
        if not math.isfinite(value):
            continue
        if abs(value) < _LITTLE:
            same.append(words(name))
        else:
            verb = "raises" if value > 0 else "lowers"
            parts[verb].append(f"{words(name)} by {number(abs(value), 2)} %")
    clauses = [f"{verb} {_listed(some)}" for verb, some in parts.items() if some]
    if same:
        clauses.append(f"hardly changes {_listed(same)}")
    return f"1 % more {words(driver)} " + (_listed(clauses) or "changes nothing")


def _listed(parts: list[str]) -> str:
    if len(parts) < 2:
        return "".join(parts)
    return f"{', '.join(parts[:-1])} and {parts[-1]}"


def _sentence(
    problem: StudyProblem,
    point: FrontPoint,
    elasticities: dict[str, dict[str, float]],
    exchange: float,
) -> str:
    of_front = {name: elasticities[name] for name in problem.objectives}
    clauses = [change_in_words(one.name, of_front) for one in problem.drivers]
    text = "; ".join(clauses) + "."
    better = [_better(problem, one.name, of_front) for one in problem.drivers]
    active = _listed([words(name) for name in point.active])
    improving = _listed([one for one in better if one])
    if improving and active:
        text += f" {improving[0].upper()}{improving[1:]} would improve all objectives, but "
        text += f"violate active limits: {active}."
    elif active:
        text += f" Active limits: {active}."
    if math.isfinite(exchange):
        first, second = problem.objectives
        verb = "lowers" if exchange < 0 else "raises"
        text += (
            f" Along the front, 1 % more {words(second)} {verb} {words(first)} by "
            f"{number(abs(exchange), 2)} %."
        )
    return text


def _better(problem: StudyProblem, driver: str, of_front: dict[str, dict[str, float]]) -> str:
    """Which change of a driver improves all objectives, in words; empty if none does."""
    gains = [
        of_front[name][driver] * (1 if problem.senses[name] == "maximise" else -1)
        for name in problem.objectives
    ]
    if min(gains) >= _LITTLE:
        return f"more {words(driver)}"
    return f"less {words(driver)}" if max(gains) <= -_LITTLE else ""
