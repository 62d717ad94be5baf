"""Combinations of parameters that the data do not determine: small singular values, in words."""

import numpy as np

from ..text import trimmed
from ._result import Undetermined
from ._statistics import Statistics

#: Smaller parts of a direction are not named.
_PART = 0.1


def undetermined(
    names: tuple[str, ...],
    units: tuple[str, ...],
    magnitudes: np.ndarray,
    statistics: Statistics,
    limit: float,
) -> tuple[Undetermined, ...]:
    """Directions whose relative standard deviation exceeds a limit.

    **Arguments:**

    - `names`, `units`, `magnitudes`: of the free parameters.
    - `statistics`: of the fit.
    - `limit`: relative standard deviation, such as 0.5.
    """
    combinations = []
    deviations = statistics.direction_deviations
    for direction, deviation in zip(statistics.directions, deviations, strict=True):
        if deviation <= limit:
            continue
        largest = np.abs(direction).max()
        parts = [i for i in range(len(names)) if abs(direction[i]) > _PART * largest]
        sign = 1.0 if direction[parts[0]] > 0 else -1.0
        changes = tuple(float(sign * direction[i]) for i in parts)
        chosen = tuple(names[i] for i in parts)
        sentence = _sentence(
            chosen, tuple(units[i] for i in parts), magnitudes[parts], changes, float(deviation)
        )
        combinations.append(Undetermined(chosen, changes, float(deviation), sentence))
    return tuple(combinations)


def _sentence(
    names: tuple[str, ...],
    units: tuple[str, ...],
    magnitudes: np.ndarray,
    changes: tuple[float, ...],
    deviation: float,
) -> str:
    if len(names) == 1:
        reason = f"standard deviation {trimmed(100 * deviation, 0)} %"
        if not np.isfinite(deviation):
            reason = "it has no influence on the measured quantities"
        return f"The data do not determine {names[0]} ({reason})."
    if len(names) == 2 and units[0] == units[1]:
        # Along the direction a + k b stays the same.
        factor = -changes[0] * magnitudes[0] / (changes[1] * magnitudes[1])
        sign = "+" if factor > 0 else "-"
        return (
            f"The data determine {names[0]} {sign} {abs(factor):.3g} × {names[1]}, not each alone "
            f"({_together(deviation)})."
        )
    largest = max(np.abs(changes))
    listed = [
        f"{name} by {change / largest:+.2g} %" for name, change in zip(names, changes, strict=True)
    ]
    return (
        f"The data determine only combinations of {', '.join(names[:-1])} and {names[-1]}: "
        f"a change of {', '.join(listed[:-1])} and {listed[-1]} together "
        f"cannot be distinguished from the scatter ({_together(deviation)})."
    )


def _together(deviation: float) -> str:
    if not np.isfinite(deviation):
        return "such a change has no influence on the measured quantities"
    return f"standard deviation of the common change: {100 * deviation:.3g} %"
