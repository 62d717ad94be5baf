"""The best designs of all sizes in one batch: SLSQP in step, by gradients of the whole chain."""

import dataclasses
import time
from collections.abc import Sequence

import numpy as np

from .lockstep import searched_together
from .problem import UPPER, Size
from .search import Found, rank, search
from .tasks import Task, evaluation_of, tasks_of

#: A number of rollers nearer to a whole one than this is whole.
_WHOLE = 1e-6


@dataclasses.dataclass(frozen=True)
class Batch:
    """All searches of one problem."""

    #: For each size, the best end for each number of starts.
    found: dict[str, list[Found]]
    #: Measures of the sizes' own designs (sizes × measures).
    starts: np.ndarray
    #: Evaluations, each with its derivatives, and compiled calls.
    evaluations: int
    calls: int
    #: Run times: of all searches, and before them of building the mechanisms [s].
    seconds: float
    building_s: float

    def best(self, size: Size, starts: int | None = None) -> Found:
        """The best feasible design of a size; with `starts`, that of this number of starts."""
        ends = [one for one in self.found[size.name] if starts in (None, one.task.starts)]
        return max(ends, key=rank)


def solve(sizes: Sequence[Size], loss: float, flattest: float = UPPER[1]) -> Batch:
    """The best designs of all sizes.

    **Arguments:**

    - `sizes`: the sizes.
    - `loss`: allowed loss of efficiency.
    - `flattest`: upper bound of the ratio of profile radii.
    """
    begin = time.perf_counter()
    tasks, starts = tasks_of(sizes, loss, flattest)
    built = time.perf_counter()
    ends, evaluations, calls = _ends(tasks)
    divided = [
        one.task.with_rollers(count)
        for one in ends
        if abs(one.variables[3] - round(one.variables[3])) > _WHOLE
        for count in (np.floor(one.variables[3]), np.ceil(one.variables[3]))
    ]
    # A relaxed number of rollers is replaced by the whole ones beside it.
    ends = [one for one in ends if abs(one.variables[3] - round(one.variables[3])) <= _WHOLE]
    if divided:
        more, again, further = _ends(divided)
        ends, evaluations, calls = ends + more, evaluations + again, calls + further
    found: dict[str, list[Found]] = {size.name: [] for size in sizes}
    for one in ends:
        found[one.task.size.name].append(one)
    seconds = time.perf_counter() - built
    return Batch(found, starts, evaluations + len(sizes), calls, seconds, built - begin)


def _ends(tasks: Sequence[Task]) -> tuple[list[Found], int, int]:
    starts = np.stack([task.unit(task.own) for task in tasks])
    ends, shared = searched_together(
        lambda index, ask: search(tasks[index], ask), evaluation_of(tasks), starts
    )
    return ends, shared.questions, shared.calls
