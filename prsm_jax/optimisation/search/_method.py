"""What every search method has, and how options that it does not take are refused."""

import abc
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias, TypeVar

import numpy as np

from ...fields import refuse_options
from ._evaluator import Evaluator
from ._functions import SearchFunctions

_Method = TypeVar("_Method", bound="WithOptions")

#: Called with the position of every iterate.
Report: TypeAlias = Callable[[np.ndarray], None]


@dataclass(frozen=True)
class SearchResult:
    """End point in the unit box, message and number of iterations of a search."""

    position: np.ndarray
    message: str
    iterations: int


class SearchMethod(abc.ABC):
    """A method that improves a design from one start; its fields are its options.

    Derive from this class, as a frozen dataclass, for a method of your own.

    **Declarations:**

    - `accepts_constraints`: whether `search` keeps `functions.limits`. A method that does not is
      refused where the problem has constraints; a design with an error of `check` then counts as
      one that fails.
    - `chooses_starts`: whether `chosen` replaces the starts of the problem before the searches.
    """

    accepts_constraints: bool = False
    chooses_starts: ClassVar[bool] = False
    #: The word that stands for the method with its default options; empty if there is none.
    word: ClassVar[str] = ""

    @property
    def name(self) -> str:
        """The name in results: the word, or the name of the class."""
        return self.word or type(self).__name__

    def chosen(self, evaluator: Evaluator, positions: np.ndarray) -> list[np.ndarray]:
        """Starts in place of those of the problem, of a method that declares `chooses_starts`.

        **Arguments:**

        - `evaluator`: the design problem, with its scales.
        - `positions`: the starts of the problem in the unit box, starts × variables.
        """
        return list(positions)

    @abc.abstractmethod
    def search(
        self, functions: SearchFunctions, start: np.ndarray, tolerance: float, report: Report
    ) -> SearchResult:
        """Search from one start.

        **Arguments:**

        - `functions`: cost, constraints and derivatives at a position.
        - `start`: a position in the unit box (variables) where the design is usable.
        - `tolerance`: for the derivatives of cost and for constraints at the end. The result is
          judged by the Karush–Kuhn–Tucker residual, at ten times this tolerance.
        - `report`: to be called with the position of every iterate, for history and progress.

        **Returns:** a `SearchResult`. If its position is unusable or infeasible, the best design
        that was evaluated counts instead.
        """


class WithOptions(SearchMethod):
    """Base of the package's methods: an option that is not one of the fields is refused."""

    def __new__(cls: type[_Method], *_values: Any, **options: Any) -> _Method:
        known = inspect.signature(cls.__init__).parameters.values()
        if all(one.kind is not inspect.Parameter.VAR_KEYWORD for one in known):
            refuse_options(cls.__name__, options, [one.name for one in known][1:])
        return object.__new__(cls)


def check_at_least(least: int, **options: Any) -> None:
    """**Raises:** `ValueError` for an option that is not a whole number of at least `least`."""
    for name, value in options.items():
        if isinstance(value, bool) or not isinstance(value, int | np.integer):
            raise ValueError(f"{name} is {value!r}; it must be a whole number")
        if value < least:
            raise ValueError(f"{name} is {value}; it must be at least {least}")
