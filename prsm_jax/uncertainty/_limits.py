"""Limits of quantities: those of the design problem, and those given as an argument."""

import math
from collections.abc import Mapping
from typing import Any

import equinox as eqx

from .._errors import UnknownNameError
from ..fields import Scalar
from ..mechanism import DesignProblem, Mechanism
from ..quantities import (
    Analysis,
    component_names,
    evaluate,
    is_function,
    quantity_names,
    quantity_of,
)

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


def check_components(
    mechanism: Mechanism, limits: Limits, speed: Scalar | None, load: Scalar | None
) -> None:
    """Refuse a limit on a component that its quantity does not have.

    **Arguments:**

    - `mechanism`: the mechanism, on which the number of components depends.
    - `limits`: from `limits_of`.
    - `speed`, `load`: operating point [rad/s, N], or `None` for that of the mechanism.

    **Raises:** `UnknownNameError` with the components that there are.
    """
    numbered = [one for one in limits if "[" in one and not is_function(one)]
    if not numbered:
        return
    names = tuple(dict.fromkeys(quantity_of(label).name for label in numbered))
    shapes = eqx.filter_eval_shape(
        lambda *at: evaluate(Analysis(*at), names), mechanism, speed, load
    )
    for label in numbered:
        name = quantity_of(label).name
        known = component_names(name, shapes[name].shape)
        if label not in known:
            listed = known if len(known) < 4 else [known[0], "…", known[-1]]
            raise UnknownNameError(
                f"limits of {label!r}: the quantity has no such component; give limits of "
                f"{', '.join(dict.fromkeys([name, *listed]))}"
            )


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
