"""An improvement in the background: its way, its end, and how it is stopped."""

import dataclasses
import threading
from collections.abc import Callable
from typing import Literal

from .._errors import PrsmError
from ..mechanism import Mechanism
from ..optimisation import Design, optimise
from ..text import short_heading


@dataclasses.dataclass(frozen=True)
class Step:
    """One design on the way of a search.

    - `start`, `starts`: number of the start (from 1) and of all; `iteration`: from 0.
    - `variables`: values [SI]; `objective`: of the problem [SI]; `violation`: the largest one of a
      limit, relative to it; `usable`: whether the design could be evaluated.
    """

    start: int
    starts: int
    iteration: int
    variables: dict[str, float]
    objective: float
    violation: float
    usable: bool

    @property
    def keeps_limits(self) -> bool:
        """Whether the design keeps all limits, to the tolerance of the search."""
        return self.usable and self.violation <= _TOLERANCE


#: Tolerance of `optimise`.
_TOLERANCE = 1e-6
State = Literal["running", "stopping", "stopped", "finished", "failed"]


class _Stopped(Exception):
    """Raised inside the search to end it."""


class Improvement:
    """The search of a file's `[optimise]` table, in a thread of its own; its choices stay.

    **Arguments:**

    - `mechanism`: the mechanism to start from.
    - `told`: called in that thread after every step and at the end.

    **Raises:** `PrsmError` for a file without an `[optimise]` table.
    """

    def __init__(self, mechanism: Mechanism, told: Callable[[], None] | None = None):
        problem = mechanism.design_problem
        if problem is None:
            raise PrsmError("the file has no [optimise] table; write one to improve the design")
        objectives = problem.objectives
        self._problem = problem
        #: Whether a larger objective is better, as in the report of `optimise`.
        self.maximised: bool = all(one.sense == "maximise" for one in objectives)
        self.steps: tuple[Step, ...] = ()
        self.state: State = "running"
        self.message: str = "compiling; the first step takes longest"
        self._end: dict[str, float] | None = None
        self._mechanism, self._told = mechanism, told
        self._stop = threading.Event()
        # A search that ends between a test of the state and its change would never stop.
        self._changing = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="improve", daemon=True)
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether the search still computes."""
        return self.state in ("running", "stopping")

    @property
    def best(self) -> dict[str, float] | None:
        """Variables [SI] of the best design that keeps all limits; `None` if there is none yet."""
        if self._end is not None:
            return self._end
        good = [one for one in self.steps if one.keeps_limits]
        if not good:
            return None
        sign = -1 if self.maximised else 1
        return min(good, key=lambda one: sign * one.objective).variables

    def stop(self) -> None:
        """End the search at its next step."""
        self._stop.set()
        with self._changing:
            if self.state == "running":
                self.state, self.message = "stopping", "stopping at the next step"

    def wait(self, seconds: float | int | None = None) -> bool:
        """Wait for the end; false if it has not come after so many seconds."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def _watch(self, start: int, starts: int, iteration: int, design: Design) -> None:
        if self._stop.is_set():
            raise _Stopped
        step = Step(
            start,
            starts,
            iteration,
            dict(design.variables),
            design.objective,
            design.violation,
            design.usable,
        )
        self.steps = (*self.steps, step)
        with self._changing:
            if self.state == "running":
                self.message = f"start {start} of {starts}, iteration {iteration}"
        self._tell()

    def _run(self) -> None:
        try:
            # The page moves variables alone: choices (numbers of rollers) stay as they are.
            problem = dataclasses.replace(self._problem, choices=())
            best = optimise(self._mechanism, problem=problem, watch=self._watch)
        except _Stopped:
            self._end_with("stopped", f"after {len(self.steps)} steps")
        except Exception as error:
            # A fault of the search must not end the page, which shows the message.
            words = short_heading(str(error)) or type(error).__name__
            self._end_with("failed", words)
        else:
            if best.feasible:
                self._end = dict(best.optimum.variables)
            self._end_with("finished", best.message)
        self._tell()

    def _end_with(self, state: State, message: str) -> None:
        with self._changing:
            self.state, self.message = state, message

    def _tell(self) -> None:
        if self._told is not None:
            self._told()
