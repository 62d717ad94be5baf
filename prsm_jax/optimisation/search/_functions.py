"""What a search evaluates: cost, constraints and derivatives, also where a design fails."""

from collections.abc import Sequence

import numpy as np

from ._evaluator import Evaluator, Point


class SearchFunctions:
    """Cost, constraints and derivatives at a position in the unit box, for one search.

    Variables are scaled by their bounds to [0, 1]. The cost is minimised; cost and constraints
    have an order of magnitude of 1. A design that fails has a higher cost than the last usable
    design, so that a search steps back from it and never gets a number that is not finite. All
    usable designs are recorded: a search with an unusable or infeasible end returns its best one.
    """

    def __init__(self, evaluator: Evaluator):
        self._evaluator = evaluator
        self.failures: int = 0
        self._good: list[Point] = []
        self._previous: Point | None = None

    def _look(self, position: np.ndarray) -> Point:
        point = self._evaluator.point(position)
        if point is self._previous:
            return point
        self._previous = point
        if point.good:
            # Rounding may move a position out of the box; a design outside of bounds is no result.
            if np.all((point.position >= 0) & (point.position <= 1)):
                self._good.append(point)
        else:
            self.failures += 1
        return point

    def usable(self, position: np.ndarray) -> bool:
        """Whether the design at a position does not fail."""
        return self._evaluator.point(position).good

    def cost(self, position: np.ndarray) -> float:
        """Cost, to be minimised."""
        point = self._look(position)
        if point.good:
            return self._evaluator.cost(point)
        return 10.0 + max((abs(self._evaluator.cost(p)) for p in self._good[-1:]), default=0.0)

    def gradient(self, position: np.ndarray) -> np.ndarray:
        """Derivatives of the cost (variables); 0 where not finite."""
        self._look(position)
        return self._evaluator.cost_gradient(position)

    @property
    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper limits of the constraints (constraints); infinite where there is none.

        Error limits of `check` are among them. Both are equal for an equality.
        """
        return self._evaluator.scaled_limits

    @property
    def equality(self) -> np.ndarray:
        """Which constraints are equalities (constraints)."""
        return self._evaluator.rows.equality

    def constraint_values(self, position: np.ndarray) -> np.ndarray:
        """Values of the constraints (constraints)."""
        point = self._look(position)
        if point.good:
            return self._evaluator.constraint_values(point)
        if self._good:
            return self._evaluator.constraint_values(self._good[-1])
        return np.zeros(len(self._evaluator.rows.names))

    def constraint_jacobian(self, position: np.ndarray) -> np.ndarray:
        """Derivatives of the constraints (constraints × variables); 0 where not finite."""
        self._look(position)
        return self._evaluator.constraint_jacobian(position)

    def best(self, position: np.ndarray, tolerance: float) -> Point | None:
        """The end of a search, or the best design seen if the end is unusable or infeasible."""
        end = self._evaluator.point(position)
        if end.good and self._evaluator.violation(end) <= tolerance:
            return end
        candidates: Sequence[Point] = [*self._good, end] if end.good else self._good
        if not candidates:
            return None

        def rank(point: Point):
            violation = self._evaluator.violation(point)
            feasible = violation <= tolerance
            return (not feasible, self._evaluator.cost(point) if feasible else violation)

        return min(candidates, key=rank)
