"""Searches in step: whatever all of them ask for is answered by one call."""

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

#: Answers for all positions (searches × variables), as arrays with the searches along axis 0.
Answer = Callable[[np.ndarray], tuple[np.ndarray, ...]]


class LockStep:
    """Answers the questions of many threads together, as soon as every running one has asked."""

    def __init__(self, answer: Answer, positions: np.ndarray):
        self._answer = answer
        self._positions = np.array(positions, dtype=float)
        self._condition = threading.Condition()
        self._running: int = len(positions)
        self._asked: int = 0
        self._results: tuple[np.ndarray, ...] = ()
        self._failure: BaseException | None = None
        #: Number of calls, and of questions.
        self.calls: int = 0
        self.questions: int = 0

    def ask(self, index: int, position: np.ndarray) -> tuple[np.ndarray, ...]:
        """What the answer says of one position; waits for the other searches."""
        with self._condition:
            self._end_if_failed()
            self._positions[index] = position
            self._asked += 1
            call = self.calls
            self._answer_when_all_asked()
            # The next call waits for this search, so the results stay until they are read.
            self._condition.wait_for(lambda: self.calls > call)
            self._end_if_failed()
            return tuple(np.array(result[index]) for result in self._results)

    def _end_if_failed(self) -> None:
        if self._failure is not None:
            raise RuntimeError("the common evaluation or another search failed") from self._failure

    def leave(self, failure: BaseException | None = None) -> None:
        """A search has ended: the others no longer wait for it, and end too if it failed."""
        with self._condition:
            self._running -= 1
            self._failure = self._failure or failure
            self._answer_when_all_asked()

    def _answer_when_all_asked(self) -> None:
        if self._asked == 0 or self._asked < self._running:
            return
        try:
            self._results = self._answer(self._positions)
        except BaseException as error:
            self._failure = error
        self.questions += self._asked
        self._asked = 0
        self.calls += 1
        self._condition.notify_all()


def searched_together(
    search: Callable[[int, Callable[[np.ndarray], tuple[np.ndarray, ...]]], Any],
    answer: Answer,
    positions: np.ndarray,
) -> tuple[list[Any], LockStep]:
    """Results of one search for each row of `positions`, all in step.

    **Arguments:**

    - `search`: gets the number of the search, and a function that answers for one position.
    - `answer`: answers for all positions.
    - `positions`: where they start (searches × variables).
    """
    shared = LockStep(answer, positions)

    def run(index: int) -> Any:
        try:
            found = search(index, lambda position: shared.ask(index, position))
        except BaseException as error:
            shared.leave(error)
            raise
        shared.leave()
        return found

    with ThreadPoolExecutor(max_workers=len(positions)) as pool:
        # `pool.map` would cancel searches that have not begun when one fails; the others would then
        # wait for them for ever.
        searches = [pool.submit(run, index) for index in range(len(positions))]
    return [one.result() for one in searches], shared
