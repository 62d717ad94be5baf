"""All searches of a front: the best of each objective, then the reference points between."""

from collections import deque
from collections.abc import Callable

import numpy as np

from ...mechanism import DesignProblem
from ..results import against_limit, constraint_reports
from ..search import Evaluator
from ._dominance import non_dominated
from ._lattice import divisions, neighbours, reference
from ._result import senses
from ._scalarised import AUGMENTATION, Goals, Solved, solve

Index = tuple[int, ...]
#: Tolerance of the searches for one objective, relative to that of the other searches. Where the
#: one objective does not determine the design, the small weight of the other objectives does.
_ALONE = 1e-2
#: Two designs whose scaled objectives differ by less count as one.
SAME = 1e-6


class FrontSearch:
    """Finds the points of a front and keeps the end of every search."""

    def __init__(
        self,
        evaluator: Evaluator,
        problem: DesignProblem,
        tolerance: float,
        progress: Callable[[int, int], None] | None = None,
    ):
        signs = senses(problem.objectives)
        matrix = np.zeros((len(signs), len(evaluator.rows.weights)))
        for row, (one, sign) in enumerate(zip(problem.objectives, signs, strict=True)):
            matrix[row] = sign * evaluator.rows.mean_of(one)
        self.goals: Goals = Goals(evaluator, matrix)
        self.tolerance = tolerance
        self.ends: list[Solved] = []
        #: Why there is no front, if there is none.
        self.message: str = ""
        #: Whether the best of each objective was found.
        self.complete: bool = True
        self._names = [one.quantity for one in problem.objectives]
        self._points = problem.points
        self._progress = progress
        self._finished = self._expected = 0
        self._at: dict[Index, Solved] = {}

    def run(self, positions: np.ndarray) -> None:
        """Find the front; `positions` are the starts for the best of each objective."""
        evaluator, goals = self.goals.evaluator, self.goals
        good = [one for one in positions if evaluator.point(one).good]
        if not good:
            self.message = (
                f"none of {len(positions)} starts is a usable design: no meshing, a pulling "
                "contact, or a value that is not finite"
            )
            return
        self._scale_from(good[0])
        count = len(goals.matrix)
        self._expected = 3 * count * len(good)
        ends_of_each = [self._alone(objective, good) for objective in range(count)]
        differ = np.zeros(count, dtype=bool)
        feasible = [
            one.point.position for ends in ends_of_each for one in ends if self.feasible(one)
        ]
        for place, ends in enumerate(ends_of_each):
            # If all searches ended at violated limits: again from designs that satisfy the limits.
            if not any(map(self.feasible, ends)):
                ends += self._alone(place, feasible)
        # The second time the scales are nearly those of the front.
        for _ in range(2):
            best = [
                min(
                    filter(self.feasible, ends), key=lambda one: one.objectives[place], default=None
                )
                for place, ends in enumerate(ends_of_each)
            ]
            raw = np.array([goals.raw(one.point) for one in best if one is not None])
            if len(raw) < count:
                self.ends = [end for ends in ends_of_each for end in ends]
                self.message = self._infeasible(self.ends)
                return
            ideal, nadir = raw.min(axis=0), raw.max(axis=0)
            differ = nadir - ideal > SAME * np.maximum(np.abs(ideal), np.abs(nadir))
            goals.offset, goals.scale = ideal, np.where(differ, nadir - ideal, goals.scale)
            ends_of_each = [
                self._alone(place, [one.point.position for one in filter(self.feasible, ends)])
                for place, ends in enumerate(ends_of_each)
            ]
        self.ends = [end for ends in ends_of_each for end in ends]
        missed = [
            name
            for name, ends in zip(self._names, ends_of_each, strict=True)
            if not any(map(self.converged, ends))
        ]
        if missed:
            self.complete = False
            self.message = (
                f"no optimum of {', '.join(missed)} was found: the front may extend beyond these "
                "points; give more starts"
            )
        if not differ.any():
            self.message = (
                self.message
                or "the objectives do not conflict: one design is the best in all of them"
            )
            return
        self._between(divisions(count, self._points))

    def feasible(self, one: Solved) -> bool:
        """Whether a design keeps all constraints and margins."""
        evaluator = self.goals.evaluator
        return not evaluator.margins.fixed and evaluator.violation(one.point) <= self.tolerance

    def converged(self, one: Solved) -> bool:
        """Whether a design is feasible and satisfies the optimality conditions."""
        return self.feasible(one) and one.conditions.residual <= self.tolerance

    def _infeasible(self, ends: list[Solved]) -> str:
        evaluator = self.goals.evaluator
        fixed = ", ".join(dict.fromkeys(row.label for row, _ in evaluator.margins.fixed))
        if fixed:
            return f"no feasible design found: none of the variables changes the error {fixed}"
        if not ends:
            return "no feasible design found: every search ended at designs that fail"
        nearest = min((one.point for one in ends), key=evaluator.violation)
        rows = constraint_reports(evaluator, 1.0, nearest, None, self.tolerance)
        # Values of margins, such as 1 − load/capacity, are not those that their names say.
        margins = {row.label for row in evaluator.margins.smooth}
        broken = "; ".join(
            ("margin of " if row.name in margins else "")
            + against_limit(row.name, row.unit, row.value, row.limit)
            for row in rows
            if not row.satisfied
        )
        return f"no feasible design found; the design of least violation has {broken}"

    def _scale_from(self, position: np.ndarray) -> None:
        """Typical magnitudes of the objectives, until their ranges are known."""
        evaluator, goals = self.goals.evaluator, self.goals
        evaluator.scale_from(position)
        values, slopes = goals.raw(evaluator.point(position)), goals.jacobian(position)
        size = np.maximum(np.abs(values), np.max(np.abs(slopes), axis=1))
        goals.scale = np.where(size > 0, size, 1.0)

    def _alone(self, objective: int, positions: list[np.ndarray]) -> list[Solved]:
        """Designs that are the best in one objective; the other objectives have a small weight."""
        weights = np.full(len(self.goals.matrix), AUGMENTATION)
        weights[objective] = 1.0
        weights /= weights.sum()
        solutions = []
        for position in positions:
            solutions.append(solve(self.goals, position, weights, None, _ALONE * self.tolerance))
            self._tell()
        return [one for one in solutions if one is not None]

    def _tell(self) -> None:
        self._finished += 1
        if self._progress is not None:
            self._progress(self._finished, max(self._expected, self._finished))

    def _between(self, count: int) -> None:
        """Search from one reference point to the next, as far as new designs appear."""
        objectives = len(self.goals.matrix)
        # From the middle outwards; two objectives have their ends already.
        third = count // objectives
        first: Index = (third,) * (objectives - 1) + (count - third * (objectives - 1),)
        waiting: deque[tuple[Index, Index | None]] = deque([(first, None)])
        known: set[Index] = {first}
        while waiting:
            index, parent = waiting.popleft()
            self._expected = max(self._expected, self._finished + len(waiting) + 1)
            end = self._toward(index, parent, count)
            self._tell()
            if end is None:
                continue
            repeated = parent in self._at and self._same(end, self._at[parent])
            self._at[index] = end
            # Beyond the edge of a surface every search ends on its edge.
            if repeated and objectives > 2:
                continue
            for other in neighbours(index, count):
                if other not in known and (objectives > 2 or min(other) > 0):
                    known.add(other)
                    waiting.append((other, index))
        # If a later search found a better design: again from the best design known now.
        values = np.array([one.objectives for one in self._at.values()])
        best = non_dominated(np.round(values / SAME)) if len(values) else []
        for (index, end), good in zip(list(self._at.items()), best, strict=True):
            target = reference(index, count)
            better = any(
                np.max(one.objectives - target) < np.max(end.objectives - target) - SAME
                for one in self.ends
            )
            if not self.converged(end) or (not good and better):
                again = self._toward(index, None, count)
                if again is not None:
                    self._at[index] = again
        self.ends += self._at.values()

    def _same(self, one: Solved, other: Solved) -> bool:
        return bool(np.max(np.abs(one.objectives - other.objectives)) <= SAME)

    def _toward(self, index: Index, parent: Index | None, count: int) -> Solved | None:
        """Search along the line through a reference point, from a design near it."""
        target = reference(index, count)
        weights = np.full(len(target), AUGMENTATION / len(target))
        known = [one for one in (*self.ends, *self._at.values()) if self.feasible(one)]
        if not known:
            return None
        nearest = min(known, key=lambda one: float(np.max(one.objectives - target)))
        start = nearest.point.position
        if parent in self._at and self._at[parent] is nearest:
            before = tuple(2 * p - i for p, i in zip(parent, index, strict=True))
            if before in self._at:
                ahead = np.clip(2 * start - self._at[before].point.position, 0.0, 1.0)
                if self.goals.evaluator.point(ahead).good:
                    start = ahead
        return solve(self.goals, start, weights, target, self.tolerance)
