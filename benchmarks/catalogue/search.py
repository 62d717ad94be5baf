"""One search: SLSQP of SciPy, and whether its end is an optimum.

The smallest of three gains has kinks. With one more variable t the problem is smooth: maximise t,
with every gain at least t.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from .problem import MEASURES, OBJECTIVES, SIGNS, VARIABLES
from .tasks import Task

#: Searches begin at the task's first values, and in the unit box here, with one roller less.
_SECOND_START = (0.4, 0.2, 0.8)
#: Tolerance of SLSQP, for t and for the sum of violated constraints.
_TOLERANCE = 1e-9
#: Largest KKT residual of an optimum.
_OPTIMAL = 1e-6
#: Where a search that is not at one starts again: so far from its end towards the second start.
_ASIDE = (1e-3, 1e-2, 0.1, 0.5)
#: Largest violation of a limit, as the logarithm of a ratio, and slack of an active one.
FEASIBLE = 1e-7


@dataclasses.dataclass(frozen=True)
class Found:
    """The end of a search."""

    task: Task
    variables: np.ndarray
    measures: np.ndarray
    objective: float
    violation: float
    kkt_residual: float
    #: Names of active limits and bounds.
    active: tuple[str, ...]


#: Share of t in each gain.
_OF_T = np.array([1.0 if name in OBJECTIVES else 0.0 for name in MEASURES])


def search(task: Task, ask: Callable[[np.ndarray], tuple[np.ndarray, ...]]) -> Found:
    """The best end of SLSQP from two starts, repeated from there until it is an optimum."""
    from scipy.optimize import minimize

    last: dict[str, Any] = {"at": None}

    def at(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if last["at"] is None or not np.array_equal(last["at"], x[:-1]):
            # SLSQP writes into its vector.
            last.update(at=x[:-1].copy(), of=ask(x[:-1]))
        return last["of"]

    count = len(VARIABLES)
    upwards = np.append(np.zeros(count), -1.0)
    margins = {
        "type": "ineq",
        "fun": lambda x: at(x)[0] - _OF_T * x[-1],
        "jac": lambda x: np.concatenate([at(x)[1], -_OF_T[:, None]], axis=1),
    }
    box = np.where(task.upper > task.lower, 1.0, 0.0)
    bounds = [(0.0, end) for end in box] + [(-5.0, 5.0)]
    fewer = box[3] * max(0.0, 1 - 1 / max(task.upper[3] - task.lower[3], 1.0))

    def ended(start: np.ndarray) -> Found:
        first = at(np.append(start, 0.0))[0]
        found = minimize(
            lambda x: -x[-1],
            np.append(start, np.min(first[: len(OBJECTIVES)])),
            jac=lambda _: upwards,
            bounds=bounds,
            constraints=[margins],
            method="SLSQP",
            options={"ftol": _TOLERANCE, "maxiter": 40},
        )
        return _judged(task, found.x[:-1], at(found.x), box)

    starts = task.unit(task.first) * box, np.append(_SECOND_START, fewer)
    best = max((ended(start) for start in starts), key=rank)
    for aside in _ASIDE:
        # In a corner of many limits SLSQP may stop early. It starts again a little beside its end,
        # with a new estimate of the Hessian.
        if best.kkt_residual <= _OPTIMAL:
            break
        end = task.unit(best.variables) * box
        best = max(best, ended(end + aside * (starts[1] - end)), key=_rank_of_optima)
    return best


def rank(found: Found) -> tuple[bool, float]:
    """Feasible before better."""
    return found.violation <= FEASIBLE, found.objective


def _rank_of_optima(found: Found) -> tuple[bool, bool, float]:
    """Feasible before optimal before better."""
    return found.violation <= FEASIBLE, found.kkt_residual <= _OPTIMAL, found.objective


def _judged(
    task: Task, position: np.ndarray, at: tuple[np.ndarray, np.ndarray], box: np.ndarray
) -> Found:
    """The end of a search, with the residual of the conditions of Karush, Kuhn and Tucker.

    The residual is the largest component of the gradient of the Lagrangian by t and the unit box,
    with the best multipliers of active limits and bounds.
    """
    from scipy.optimize import nnls

    gain, slope = at
    objective = float(np.min(gain[: len(OBJECTIVES)]))
    columns, names = [], []
    for name, value, row, share in zip(MEASURES, gain, slope, _OF_T, strict=True):
        if value - share * objective < FEASIBLE:
            columns.append(np.append(row, -share))
            names.append(name)
    for i, variable in enumerate(VARIABLES):
        for end, sign in ((0.0, 1.0), (1.0, -1.0)):
            # A fixed variable is at both of its bounds.
            if abs(position[i] - end * box[i]) < FEASIBLE:
                columns.append(sign * np.eye(len(VARIABLES) + 1)[i])
                names.append(f"{variable} {'lower' if sign > 0 else 'upper'}")
    upwards = np.append(np.zeros(len(VARIABLES)), -1.0)
    matrix = np.array(columns).T
    residual = np.max(np.abs(matrix @ nnls(matrix, upwards)[0] - upwards))
    measures = task.limits * np.exp(SIGNS * gain)
    return Found(
        task,
        task.physical(position),
        measures,
        objective,
        float(max(0.0, -np.min(gain[len(OBJECTIVES) :]))),
        float(residual),
        tuple(names),
    )
