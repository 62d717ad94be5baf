"""What every search method is given and gives back, and which methods there are."""

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


def find_search(method: str, constrained: bool) -> tuple[str, Search]:
    """The search of a name; `"auto"` is SLSQP with constraints and L-BFGS without.

    **Raises:** `ValueError` for an unknown method, or one that cannot take constraints.
    """
    from ._box import adam, lbfgs
    from ._constrained import slsqp, trust_constr

    searches: dict[str, Search] = {
        "adam": adam,
        "lbfgs": lbfgs,
        "slsqp": slsqp,
        "trust-constr": trust_constr,
    }
    if method == "auto":
        method = "slsqp" if constrained else "lbfgs"
    if method not in searches:
        raise ValueError(f"method is {method!r}; choose one of auto, {', '.join(searches)}")
    if constrained and method in ("adam", "lbfgs"):
        raise ValueError(
            f"method {method!r} takes bounds only; with constraints choose slsqp or trust-constr"
        )
    return method, searches[method]
