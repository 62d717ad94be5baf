"""The searches of one optimisation: from all starts, then with whole numbers, and their best."""

import itertools
import math
from collections.abc import Callable, Iterable

import numpy as np

from .results import Optimality, Reporter, Run, optimality, run_report
from .search import Evaluator, Guarded, MarginRow, Point, Search

#: At most this many numbers have to be whole at once: each doubles the searches.
_MOST_WHOLE = 4


class Searches:
    """Runs searches, and keeps their reports and where they ended."""

    def __init__(self, evaluator: Evaluator, report: Reporter, tolerance: float, count: int):
        self._evaluator, self._report, self._tolerance = evaluator, report, tolerance
        #: Told the number of the start (from 1), how many there are, and the iteration.
        self.tell: Callable[[int, int, int], None] | None = None
        self._count = count
        self.runs: list[Run] = []
        self._ends: list[tuple[Point, Optimality] | None] = []
        #: Runs whose numbers are whole where they have to be; all, if none has to be.
        self._final = 0

    def clear(self) -> None:
        """Forget all runs."""
        self.runs, self._ends = [], []

    def run_all(self, search: Search, positions: Iterable[np.ndarray], iterations: int) -> None:
        """One search from each position."""
        for position in positions:
            number = len(self.runs) + 1

            def step(iteration: int, number: int = number) -> None:
                if self.tell is not None:
                    self.tell(number, max(self._count, number), iteration)

            run, end = _run(
                self._evaluator, self._report, search, position, self._tolerance, iterations, step
            )
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

    def make_whole(self, search: Search, iterations: int) -> None:
        """Search again from the best end, with the whole numbers on either side of its own.

        What has to be whole is held there as an equality; the runs before do not count any more.
        """
        end = self._ends[self._best()]
        if end is None:
            return
        rows = self._evaluator.margins.whole[:_MOST_WHOLE]
        values = [end[0].values[self._evaluator.rows.first_margin + row.place] for row in rows]
        self._final = len(self.runs)
        for choice in itertools.product(*map(_either_side, rows, values)):
            for row, number in zip(rows, choice, strict=True):
                self._evaluator.rows.fix(row.label, number, row.lower)
            self._evaluator.guard(False)
            self.run_all(search, [end[0].position], iterations)
        chosen = self._ends[self._best()]
        if chosen is not None:
            for row in rows:
                place = self._evaluator.rows.first_margin + row.place
                number = float(round(chosen[0].values[place]))
                self._evaluator.rows.fix(row.label, number, row.lower)

    def best(self, initial: np.ndarray) -> tuple[int, Point, Optimality | None]:
        """Number, end and optimality of the best run.

        With no usable design at all, the design as it was is shown beside the message.
        """
        index = self._best()
        found = self._ends[index]
        if found is None:
            return index, self._evaluator.point(initial), None
        return index, *found

    def _best(self) -> int:
        """The feasible run of least cost; of those as good as it, the first that converged."""
        evaluator, tolerance = self._evaluator, self._tolerance
        ends = self._ends
        usable = [i for i, end in enumerate(ends) if end is not None and i >= self._final]
        if not usable:
            return 0 if self._final == 0 else self._final

        def violation(index: int) -> float:
            # As that run saw it: what is held at a whole number differs from run to run.
            found = self.runs[index].end
            return math.inf if found is None else found.violation

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
        level = [i for i in feasible if cost(i) <= least + tolerance]
        # The first start is the present design: its history is the one that a reader understands.
        return min(level, key=lambda i: (residual(i), i))


def _either_side(row: MarginRow, value: float) -> list[float]:
    """The whole numbers on either side of a value that the margin allows."""
    below = math.floor(value + 1e-9)
    numbers = {below, below + 1} if value - below > 1e-9 else {below}
    return [float(number) for number in sorted(numbers) if number >= row.lower]


def _conditions(evaluator: Evaluator, point: Point, tolerance: float) -> Optimality:
    return optimality(
        point.position,
        evaluator.cost_gradient(point.position),
        evaluator.constraint_values(point),
        evaluator.constraint_jacobian(point.position),
        *evaluator.scaled_limits,
        active_tolerance=max(tolerance, 1e-9),
    )


def _run(
    evaluator: Evaluator,
    report: Reporter,
    search: Search,
    start: np.ndarray,
    tolerance: float,
    iterations: int,
    step: Callable[[int], None],
) -> tuple[Run, tuple[Point, Optimality] | None]:
    """One search, and where it ended with the optimality there; `None` if nothing was usable."""
    first = evaluator.point(start)
    history = [first]
    step(0)

    def note(position: np.ndarray) -> None:
        history.append(evaluator.point(position))
        step(len(history) - 1)

    if not first.good:
        message = "the start fails: no meshing, a pulling contact, or a value that is not finite"
        return run_report(report, first, None, history, None, 0, 0, message), None
    functions = Guarded(evaluator)
    # The searches go a little further than the check asks for.
    result = search(functions, start, tolerance / 10, iterations, note)
    end = functions.best(result.position, tolerance)
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
