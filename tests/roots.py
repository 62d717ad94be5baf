"""Roots of one number: SciPy's search, whose result has no known type."""

from collections.abc import Callable
from typing import Any

import scipy.optimize


def root_between(function: Callable[..., Any], low: Any, high: Any, **limits: Any) -> float:
    """Root of `function` between `low` and `high`, by Brent's method.

    **Arguments:**

    - `function`: of one number; its signs at the ends differ.
    - `low`, `high`: the ends.
    - `limits`: `args`, `xtol`, `rtol`, `maxiter` of `scipy.optimize.brentq`.
    """
    found: Any = scipy.optimize.brentq(function, low, high, **limits)
    return float(found)
