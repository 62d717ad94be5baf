"""Optimised variables with as few digits as the quantities need."""

from collections.abc import Callable

import numpy as np

from ...mechanism import Mechanism
from ..search import Evaluator
from ._optimum import Optimum

_MOST_DIGITS = 17


def rounded_variables(
    mechanism: Mechanism,
    best: Optimum,
    rounding: Callable[[float, str, int], float],
    *,
    digits: int = 6,
    tolerance: float = 1e-6,
) -> dict[str, float]:
    """Values of the variables at the optimum [SI], rounded as a person would write them.

    Each has `digits` significant digits, or more where an objective or a constraint would
    otherwise change by more than `tolerance`, relative.

    **Arguments:**

    - `mechanism`: the mechanism that was optimised.
    - `best`: the optimum.
    - `rounding`: rounds a value with an SI unit to a number of digits in the unit of the file.
    - `digits`: significant digits to begin with.
    - `tolerance`: permitted change of objective and constraints, relative.
    """
    evaluator = Evaluator(mechanism, best.problem, None, None)
    exact = dict(best.optimum.variables)
    values = _values(evaluator, exact)

    def change(variables: dict[str, float]) -> float:
        changed = _values(evaluator, variables)
        known = np.isfinite(values)
        scale = np.where(values[known] == 0, 1.0, np.abs(values[known]))
        return float(np.max(np.abs(changed[known] - values[known]) / scale, initial=0.0))

    rounded = {}
    for name, value in exact.items():
        unit = best.variable_units[name]
        for count in range(digits, _MOST_DIGITS + 1):
            rounded[name] = rounding(value, unit, count)
            # Equal shares for all variables, so that their sum stays within the tolerance.
            if change(exact | {name: rounded[name]}) <= tolerance / len(exact):
                break
    return rounded if change(rounded) <= tolerance else exact


def _values(evaluator: Evaluator, variables: dict[str, float]) -> np.ndarray:
    position = (np.array(list(variables.values())) - evaluator.lower) / evaluator.width
    return evaluator.point(position).values
