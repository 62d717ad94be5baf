"""The best designs of all sizes in one batch: SLSQP in step, by gradients of the whole chain."""

import dataclasses
import time
from collections.abc import Sequence

import numpy as np

from .lockstep import searched_together
from .problem import UPPER, Size
from .search import Found, rank, search
from .tasks import Task, evaluation_of, tasks_of

#: A number of rollers this near to a whole one differs from it by the rounding of the unit box.
_WHOLE = 1e-12
#: One this near is an end of SLSQP at its bound. It is searched again with the whole number: the
#: measures of 13.9999999 rollers are not those of 14.
_NEARLY_WHOLE = 1e-6


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
    # A relaxed number of rollers is replaced by the whole ones beside it.
    divided = [
        one.task.with_rollers(count, one.variables)
        for one in ends
        for count in whole_beside(one.variables[3])
    ]
    ends = [one for one in ends if not whole_beside(one.variables[3])]
    if divided:
        more, again, further = _ends(divided)
        ends, evaluations, calls = ends + more, evaluations + again, calls + further
    found: dict[str, list[Found]] = {size.name: [] for size in sizes}
    for one in ends:
        found[one.task.size.name].append(one)
    seconds = time.perf_counter() - built
    return Batch(found, starts, evaluations + len(sizes), calls, seconds, built - begin)


def whole_beside(count: float) -> tuple[float, ...]:
    """Whole numbers of rollers to search again with; none where a number is whole itself."""
    nearest = float(np.round(count))
    if abs(count - nearest) <= _WHOLE:
        return ()
    if abs(count - nearest) <= _NEARLY_WHOLE:
        return (nearest,)
    return float(np.floor(count)), float(np.ceil(count))


def _ends(tasks: Sequence[Task]) -> tuple[list[Found], int, int]:
    starts = np.stack([task.unit(task.first) for task in tasks])
    ends, shared = searched_together(
        lambda index, ask: search(tasks[index], ask), evaluation_of(tasks), starts
    )
    return ends, shared.questions, shared.calls
