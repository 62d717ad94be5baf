"""The searches of one optimisation, from all starts and with whole numbers, and the best one."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterable

import numpy as np

from .results import Design, Optimality, Reporter, Run, run_report, worst_case_optimality
from .search import (
    Evaluator,
    MarginRow,
    Point,
    SearchFunctions,
    SearchMethod,
    SearchResult,
    WorstCaseFunctions,
)

#: At most this many numbers are made whole: each doubles the number of searches.
_MOST_WHOLE = 4
#: Largest number of new ranges for the level of a worst case.
_MOST_RANGES = 10


class Searches:
    """Runs searches and records their reports and end points."""

    def __init__(self, evaluator: Evaluator, report: Reporter, tolerance: float, count: int):
        self._evaluator, self._report, self._tolerance = evaluator, report, tolerance
        #: Called with the number of the start (from 1), the number of starts, and the iteration.
        self.tell: Callable[[int, int, int], None] | None = None
        #: Called with the same numbers and the design of the iteration.
        self.watch: Callable[[int, int, int, Design], None] | None = None
        self._count = count
        self.runs: list[Run] = []
        self._ends: list[tuple[Point, Optimality] | None] = []
        #: Index of the first run with whole numbers where required; 0 if none are required.
        self._final = 0

    def clear(self) -> None:
        """Remove all runs."""
        self.runs, self._ends = [], []

    def run_all(self, method: SearchMethod, positions: Iterable[np.ndarray]) -> None:
        """One search from each position."""
        for position in positions:
            number = len(self.runs) + 1

            def step(iteration: int, point: Point, number: int = number) -> None:
                count = max(self._count, number)
                if self.tell is not None:
                    self.tell(number, count, iteration)
                if self.watch is not None:
                    self.watch(number, count, iteration, self._report.design(point))

            run, end = _run(self._evaluator, self._report, method, position, self._tolerance, step)
            self.runs.append(run)
            self._ends.append(end)

    @property
    def converged(self) -> bool:
        """Whether the best end so far is feasible and optimal."""
        end = self._ends[self._best()]
        if end is None:
            return False
        violation = self._evaluator.violation(end[0])
        return max(violation, end[1].residual) <= self._tolerance

    def make_whole(self, method: SearchMethod) -> None:
        """Search again from the best end, with the whole numbers on either side of its values.

        The whole numbers are equality constraints; earlier runs no longer count.
        """
        end = self._ends[self._best()]
        if end is None:
            return
        rows = self._evaluator.margins.integer[:_MOST_WHOLE]
        values = [end[0].values[self._evaluator.rows.first_margin + row.place] for row in rows]
        self._final = len(self.runs)
        for choice in itertools.product(*map(_either_side, rows, values)):
            for row, number in zip(rows, choice, strict=True):
                self._evaluator.rows.fix(row.label, number, row.lower)
            self._evaluator.guard(False)
            self.run_all(method, [end[0].position])
        chosen = self._ends[self._best()]
        if chosen is not None:
            for row in rows:
                place = self._evaluator.rows.first_margin + row.place
                number = float(round(chosen[0].values[place]))
                self._evaluator.rows.fix(row.label, number, row.lower)

    def best(self, initial: np.ndarray) -> tuple[int, Point, Optimality | None]:
        """Index, end and optimality of the best run.

        If no design is usable, the end is the present design, without optimality.
        """
        index = self._best()
        outcome = self._ends[index]
        if outcome is None:
            return index, self._evaluator.point(initial), None
        return index, *outcome

    def _best(self) -> int:
        """The feasible run of least cost; among equally good runs, the first that converged."""
        evaluator, tolerance = self._evaluator, self._tolerance
        ends = self._ends
        usable = [i for i, end in enumerate(ends) if end is not None and i >= self._final]
        if not usable:
            return 0 if self._final == 0 else self._final

        def violation(index: int) -> float:
            # With the whole numbers of that run: they differ from run to run.
            outcome = self.runs[index].end
            return math.inf if outcome is None else outcome.violation

        def cost(index: int) -> float:
            end = ends[index]
            assert end is not None
            return evaluator.cost(end[0])

        def residual(index: int) -> float:
            end = ends[index]
            assert end is not None
            return max(end[1].residual, tolerance)

        feasible = [i for i in usable if violation(i) <= tolerance]
        if not feasible:
            return min(usable, key=violation)
        least = min(map(cost, feasible))
        ties = [i for i in feasible if cost(i) <= least + tolerance]
        # The first start is the present design: its history is the easiest to understand.
        return min(ties, key=lambda i: (residual(i), i))


def _either_side(row: MarginRow, value: float) -> list[float]:
    """The whole numbers on either side of a value that the margin allows."""
    below = math.floor(value + 1e-9)
    numbers = {below, below + 1} if value - below > 1e-9 else {below}
    return [float(number) for number in sorted(numbers) if number >= row.lower]


def _conditions(evaluator: Evaluator, point: Point, tolerance: float) -> Optimality:
    parts = zip(evaluator.worst_parts(point), evaluator.worst_slopes(point.position), strict=True)
    conditions, _ = worst_case_optimality(
        point.position,
        evaluator.mean_cost_gradient(point.position),
        evaluator.constraint_values(point),
        evaluator.constraint_jacobian(point.position),
        *evaluator.scaled_limits,
        list(parts),
        active_tolerance=max(tolerance, 1e-9),
    )
    if evaluator.point(point.position).good:
        return conditions
    # Derivatives that are not finite count as 0 above, and would look like an optimum.
    return dataclasses.replace(conditions, stationarity=math.inf)


def _searched(
    evaluator: Evaluator,
    method: SearchMethod,
    start: np.ndarray,
    tolerance: float,
    note: Callable[[np.ndarray], None],
) -> tuple[SearchFunctions, SearchResult]:
    """The end of a method from one start, with or without worst cases."""
    # The search has a tighter tolerance than the optimality check.
    tight = tolerance / 10
    if not evaluator.rows.worst:
        functions = SearchFunctions(evaluator)
        return functions, method.search(functions, start, tight, note)
    functions = WorstCaseFunctions(evaluator, start)

    def note_design(joint: np.ndarray) -> None:
        note(functions.position(joint))

    position, iterations, message = start, 0, ""
    for _ in range(_MOST_RANGES):
        if not evaluator.point(position).good:
            break
        result = method.search(functions, functions.joined(position), tight, note_design)
        position = np.clip(functions.position(result.position), 0.0, 1.0)
        iterations, message = iterations + result.iterations, result.message
        if not functions.at_edge(result.position):
            break
    return functions, SearchResult(position, message, iterations)


def _run(
    evaluator: Evaluator,
    report: Reporter,
    method: SearchMethod,
    start: np.ndarray,
    tolerance: float,
    step: Callable[[int, Point], None],
) -> tuple[Run, tuple[Point, Optimality] | None]:
    """One search, with its end and the optimality there; `None` if no design was usable."""
    first = evaluator.point(start)
    history = [first]
    step(0, first)

    def note(position: np.ndarray) -> None:
        history.append(evaluator.point(position))
        step(len(history) - 1, history[-1])

    if not first.good:
        message = "the start fails: no meshing, a pulling contact, or a value that is not finite"
        return run_report(report, first, None, history, None, 0, 0, message), None
    functions, result = _searched(evaluator, method, start, tolerance, note)
    # Only a user's own search may end outside of the box.
    end = functions.best(np.clip(result.position, 0.0, 1.0), tolerance)
    if end is None:
        failed = run_report(
            report,
            first,
            None,
            history,
            None,
            functions.failures,
            result.iterations,
            result.message,
        )
        return failed, None
    conditions = _conditions(evaluator, end, tolerance)
    if not np.array_equal(history[-1].position, end.position):
        history.append(end)
    run = run_report(
        report,
        first,
        end,
        history,
        conditions,
        functions.failures,
        result.iterations,
        result.message,
    )
    return run, (end, conditions)
