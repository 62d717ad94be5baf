"""Limits of quantities: those of the design problem, and those given as an argument."""

import math
from collections.abc import Mapping
from typing import Any

from ..mechanism import DesignProblem
from ..quantities import quantity_names

Limits = dict[str, tuple[float, float]]


def limits_of(problem: DesignProblem | None, given: Mapping[Any, Any] | None) -> Limits:
    """Lower and upper limit of each quantity [SI], infinite where there is none.

    Limits in the argument replace those of the same quantity in the design problem. An equality
    constraint gives no limits, because no quantity with scatter can satisfy it.

    **Raises:** `ValueError` for limits that are not a pair, or in the wrong order.
    """
    limits: Limits = {}
    for one in () if problem is None else problem.constraints:
        if one.equal is None:
            limits[one.quantity] = _pair(one.quantity, (one.lower, one.upper))
    for name, pair in zip(quantity_names(given or ()), (given or {}).values(), strict=True):
        limits[name] = _pair(name, pair)
    return limits


def _pair(name: str, pair) -> tuple[float, float]:
    try:
        lower, upper = pair
    except (TypeError, ValueError):
        raise ValueError(
            f"limits of {name!r} are {pair!r}; give (lower, upper), with None for no limit"
        ) from None
    low = -math.inf if lower is None else float(lower)
    high = math.inf if upper is None else float(upper)
    if not low < high:
        raise ValueError(f"limits of {name!r}: lower {low:g} is not below upper {high:g}")
    return low, high
