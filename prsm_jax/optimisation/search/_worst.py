"""Searches for the least worst case: they lower a level that no operating point may exceed."""

import numpy as np

from ._evaluator import Evaluator
from ._functions import SearchFunctions

#: Half of the range of a level about the worst case at the start, in units of the scaled cost.
_REACH = 2.0
#: A level nearer than this to the end of its range stops the search.
_EDGE = 1e-6


class WorstCaseFunctions(SearchFunctions):
    """Cost, constraints and derivatives with one more coordinate for each worst-case objective.

    The worst of several operating points has a kink wherever two of them tie, which is where a
    search usually ends. Here the cost is a level t for each such objective, and each operating
    point k a constraint f_k(x) - t <= 0, all of which are smooth. A level is scaled to [0, 1] about
    the worst case at the start, as the variables are by their bounds.
    """

    def __init__(self, evaluator: Evaluator, start: np.ndarray):
        super().__init__(evaluator)
        self._count = evaluator.variables
        self._parts = evaluator.worst_parts(evaluator.point(start))
        self._middle = np.array([np.max(part) for part in self._parts])

    def joined(self, position: np.ndarray) -> np.ndarray:
        """A position with its levels at the worst case there, the middle of their ranges."""
        parts = self._evaluator.worst_parts(self._evaluator.point(position))
        self._middle = np.array([np.max(part) for part in parts])
        return np.append(position, np.full(len(parts), 0.5))

    def at_edge(self, joint: np.ndarray) -> bool:
        """Whether a level ends at the limit of its range."""
        shares = joint[self._count :]
        return bool(np.any((shares <= _EDGE) | (shares >= 1 - _EDGE)))

    def position(self, joint: np.ndarray) -> np.ndarray:
        """The position of the design, without the levels."""
        return joint[: self._count]

    def _levels(self, joint: np.ndarray) -> np.ndarray:
        return self._middle + _REACH * (2 * joint[self._count :] - 1)

    def usable(self, position: np.ndarray) -> bool:
        return super().usable(self.position(position))

    def cost(self, position: np.ndarray) -> float:
        point = self._look(self.position(position))
        levels = float(np.sum(self._levels(position)))
        if point.good:
            return self._evaluator.mean_cost(point) + levels
        # A design that fails does not limit a level, so the levels alone would lower the cost.
        return super().cost(self.position(position))

    def gradient(self, position: np.ndarray) -> np.ndarray:
        self._look(self.position(position))
        slope = self._evaluator.mean_cost_gradient(self.position(position))
        return np.append(slope, np.full(len(self._middle), 2 * _REACH))

    @property
    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        lower, upper = super().limits
        more = sum(map(len, self._parts))
        return np.append(lower, np.full(more, -np.inf)), np.append(upper, np.zeros(more))

    @property
    def equality(self) -> np.ndarray:
        return np.append(super().equality, np.zeros(sum(map(len, self._parts)), dtype=bool))

    def constraint_values(self, position: np.ndarray) -> np.ndarray:
        rows = super().constraint_values(self.position(position))
        point = self._evaluator.point(self.position(position))
        if point.good:
            self._parts = self._evaluator.worst_parts(point)
        pairs = zip(self._parts, self._levels(position), strict=True)
        return np.concatenate([rows, *(part - level for part, level in pairs)])

    def constraint_jacobian(self, position: np.ndarray) -> np.ndarray:
        design = self.position(position)
        rows = super().constraint_jacobian(design)
        levels = len(self._middle)
        blocks = [np.concatenate([rows, np.zeros((len(rows), levels))], axis=1)]
        for place, slopes in enumerate(self._evaluator.worst_slopes(design)):
            columns = np.zeros((len(slopes), levels))
            columns[:, place] = -2 * _REACH
            blocks.append(np.concatenate([slopes, columns], axis=1))
        return np.concatenate(blocks)
