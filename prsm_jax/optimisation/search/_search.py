"""Arguments and result of every search method."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ._evaluator import Guarded


@dataclass(frozen=True)
class SearchResult:
    """End point, message and number of iterations of a search."""

    position: np.ndarray
    message: str
    iterations: int


#: (functions, start, tolerance, maximum iterations, callback with every iterate).
Search = Callable[[Guarded, np.ndarray, float, int, Callable[[np.ndarray], None]], SearchResult]
