"""What every search method is given and gives back."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ._evaluator import Guarded


@dataclass(frozen=True)
class SearchResult:
    """Where a search ended and what it says about it."""

    position: np.ndarray
    message: str
    iterations: int


#: (functions, start, tolerance, maximum iterations, what to call with every iterate).
Search = Callable[[Guarded, np.ndarray, float, int, Callable[[np.ndarray], None]], SearchResult]
