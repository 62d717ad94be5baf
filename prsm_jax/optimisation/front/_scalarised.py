"""One point of a front: a search for the design nearest to the ideal one along a given line."""

import dataclasses

import numpy as np

from ..results import Optimality, optimality, worst_case_optimality
from ..search import Evaluator, Point

#: Weight of the sum of the objectives in every search. Without it a point could be dominated where
#: one objective is constant. It moves a point along the front, never away from it.
AUGMENTATION = 1e-4
#: Searches with a fresh Hessian, and iterations of each.
_RESTARTS, _ITERATIONS = 3, 100
#: Cost decrease below which SciPy ends a search.
_COST_TOLERANCE = 1e-15


class Goals:
    """Objectives, to be minimised, as scaled linear combinations of the evaluated quantities."""

    def __init__(self, evaluator: Evaluator, matrix: np.ndarray):
        self.evaluator = evaluator
        #: Objectives × quantities, with the sign of the sense.
        self.matrix = matrix
        self.offset: np.ndarray = np.zeros(len(matrix))
        self.scale: np.ndarray = np.ones(len(matrix))

    def raw(self, point: Point) -> np.ndarray:
        """Objectives [SI], negative where they are to be maximised."""
        used = np.any(self.matrix != 0, axis=0)
        return self.matrix[:, used] @ point.values[used]

    def values(self, point: Point) -> np.ndarray:
        """Scaled objectives."""
        return (self.raw(point) - self.offset) / self.scale

    def jacobian(self, position: np.ndarray) -> np.ndarray:
        """Derivatives of the scaled objectives, objectives × variables."""
        return self.matrix @ self.evaluator.jacobian(position) / self.scale[:, None]


@dataclasses.dataclass(frozen=True)
class Solved:
    """The end of a search: a design and its optimality.

    `weights` are the multipliers of the objectives, which sum to 1: the design minimises the sum
    of the objectives with these weights to first order, and `conditions` are of that sum.
    """

    point: Point
    objectives: np.ndarray
    weights: np.ndarray
    conditions: Optimality
    #: Largest residual of the conditions of the search itself, which fixes the place on the front.
    residual: float
    message: str
    failures: int


class _Finished(Exception):
    """The search meets its tolerance."""


class _Search:
    """Cost, constraints and derivatives over the position and, with a target, the distance t.

    With a target a: least t with f_i(x) − a_i ≤ t; else the weighted sum of objectives.
    """

    def __init__(
        self, goals: Goals, weights: np.ndarray, target: np.ndarray | None, tolerance: float
    ):
        self.goals, self.weights, self.target = goals, weights, target
        self.tolerance = tolerance
        self.failures = 0
        #: Whether the best iterate breaks a limit, its residual, and its position.
        self.best: tuple[bool, float, np.ndarray] | None = None
        self._last_good: Point | None = None
        evaluator = goals.evaluator
        self.lower, self.upper = evaluator.scaled_limits
        equal = evaluator.rows.equality
        self.equal = equal
        self.has_lower = ~equal & np.isfinite(self.lower)
        self.has_upper = ~equal & np.isfinite(self.upper)
        self._count = evaluator.variables

    def _point(self, joint: np.ndarray) -> tuple[Point, bool]:
        position = np.clip(joint[: self._count], 0.0, 1.0)
        point = self.goals.evaluator.point(position)
        if point.good:
            self._last_good = point
            return point, True
        self.failures += 1
        return self._last_good or point, False

    def cost(self, joint: np.ndarray) -> float:
        point, good = self._point(joint)
        # A design that fails costs more than the last usable design: the search steps back.
        values = self.goals.values(point) + (0.0 if good else 10.0)
        distance = 0.0 if self.target is None else joint[-1]
        return float(self.weights @ values + distance)

    def gradient(self, joint: np.ndarray) -> np.ndarray:
        slope = self.weights @ self.goals.jacobian(np.clip(joint[: self._count], 0.0, 1.0))
        return slope if self.target is None else np.append(slope, 1.0)

    def inequalities(self, joint: np.ndarray) -> np.ndarray:
        point, good = self._point(joint)
        values = self.goals.evaluator.constraint_values(point)
        rows = [(values - self.lower)[self.has_lower], (self.upper - values)[self.has_upper]]
        if self.target is not None:
            objectives = self.goals.values(point) + (0.0 if good else 10.0)
            rows.append(self.target + joint[-1] - objectives)
        return np.concatenate(rows)

    def inequality_slopes(self, joint: np.ndarray) -> np.ndarray:
        position = np.clip(joint[: self._count], 0.0, 1.0)
        slopes = self.goals.evaluator.constraint_jacobian(position)
        rows = np.concatenate([slopes[self.has_lower], -slopes[self.has_upper]])
        if self.target is None:
            return rows
        objectives = -self.goals.jacobian(position)
        last = np.append(np.zeros(len(rows)), np.ones(len(objectives)))
        return np.concatenate([np.concatenate([rows, objectives]), last[:, None]], axis=1)

    def equalities(self, joint: np.ndarray) -> np.ndarray:
        point, _ = self._point(joint)
        return (self.goals.evaluator.constraint_values(point) - self.lower)[self.equal]

    def equality_slopes(self, joint: np.ndarray) -> np.ndarray:
        position = np.clip(joint[: self._count], 0.0, 1.0)
        slopes = self.goals.evaluator.constraint_jacobian(position)[self.equal]
        if self.target is None:
            return slopes
        return np.concatenate([slopes, np.zeros((len(slopes), 1))], axis=1)

    def conditions(self, position: np.ndarray) -> tuple[float, np.ndarray]:
        """Residual of this search at a position, and weights of the objectives there."""
        evaluator = self.goals.evaluator
        point = evaluator.point(position)
        objectives, slopes = self.goals.values(point), self.goals.jacobian(position)
        rows, row_slopes = (
            evaluator.constraint_values(point),
            evaluator.constraint_jacobian(position),
        )
        active = max(self.tolerance, 1e-9)
        if self.target is None:
            judged = optimality(
                position,
                self.weights @ slopes,
                rows,
                row_slopes,
                self.lower,
                self.upper,
                active_tolerance=active,
            )
            return judged.residual, self.weights
        judged, multipliers = worst_case_optimality(
            position,
            self.weights @ slopes,
            rows,
            row_slopes,
            self.lower,
            self.upper,
            [(objectives - self.target, slopes)],
            active_tolerance=active,
        )
        return judged.residual, self.weights - multipliers

    def look(self, joint: np.ndarray) -> None:
        """Check an iterate, and end the search if the iterate meets the tolerance."""
        position = np.clip(joint[: self._count], 0.0, 1.0)
        evaluator = self.goals.evaluator
        # A design whose derivatives are not finite fails, too.
        evaluator.jacobian(position)
        point = evaluator.point(position)
        if not point.good:
            return
        residual, _ = self.conditions(position)
        rank = evaluator.violation(point) > self.tolerance, residual
        if self.best is None or rank < self.best[:2]:
            self.best = *rank, position
        if residual <= self.tolerance:
            raise _Finished


def solve(
    goals: Goals,
    start: np.ndarray,
    weights: np.ndarray,
    target: np.ndarray | None,
    tolerance: float,
) -> Solved | None:
    """Search one point of the front by SLSQP from a usable design.

    **Arguments:**

    - `goals`: the objectives.
    - `start`: a position in the unit box (variables).
    - `weights`: of the objectives in the cost; small ones with a target.
    - `target`: a point of scaled objectives, from which the line along (1, …, 1) leads to the
      design; `None` to minimise the weighted sum itself.
    - `tolerance`: for the Karush–Kuhn–Tucker residual, in scaled units.

    **Returns:** the end, or `None` if the start or all designs fail.
    """
    from scipy.optimize import minimize

    search = _Search(goals, weights, target, tolerance)
    evaluator = goals.evaluator
    position, message = np.clip(start, 0.0, 1.0), ""
    if not evaluator.point(position).good:
        return None
    constraints = []
    if search.has_lower.any() or search.has_upper.any() or target is not None:
        constraints.append(
            {"type": "ineq", "fun": search.inequalities, "jac": search.inequality_slopes}
        )
    if search.equal.any():
        constraints.append({"type": "eq", "fun": search.equalities, "jac": search.equality_slopes})
    bounds: list[tuple[float | None, float | None]] = [(0.0, 1.0)] * evaluator.variables
    if target is not None:
        bounds.append((None, None))
    try:
        search.look(position)
        for _ in range(1 + _RESTARTS):
            joint = position
            if target is not None:
                distance = np.max(goals.values(evaluator.point(position)) - target)
                joint = np.append(position, distance)
            result = minimize(
                search.cost,
                joint,
                jac=search.gradient,
                method="SLSQP",
                bounds=bounds,
                constraints=constraints,
                callback=search.look,
                options={"maxiter": _ITERATIONS, "ftol": _COST_TOLERANCE},
            )
            message = str(result.message)
            search.look(result.x)
            moved = np.clip(result.x[: evaluator.variables], 0.0, 1.0)
            if np.max(np.abs(moved - position)) <= tolerance or result.status == 4:
                break
            if not evaluator.point(moved).good:
                break
            position = moved
    except _Finished:
        message = "KKT residual below tolerance"
    if search.best is None:
        return None
    return _judged(search, message)


def _judged(search: _Search, message: str) -> Solved:
    assert search.best is not None
    goals, position = search.goals, search.best[2]
    evaluator = goals.evaluator
    residual, weights = search.conditions(position)
    weights = weights / np.sum(weights)
    point = evaluator.point(position)
    conditions = optimality(
        position,
        weights @ goals.jacobian(position),
        evaluator.constraint_values(point),
        evaluator.constraint_jacobian(position),
        *evaluator.scaled_limits,
        active_tolerance=max(search.tolerance, 1e-9),
    )
    return Solved(
        point, goals.values(point), weights, conditions, residual, message, search.failures
    )
