"""Kinks: where the derivatives below and above the present value of a parameter differ.

At a tie of two branches (`max` of operating and duty load) automatic differentiation gives one
number, which is neither derivative. Exact derivatives at a millionth of the parameter to either
side show both: where the quantity is smooth, they agree to about this millionth.
"""

from collections.abc import Callable, Sequence

import numpy as np

#: Shift to either side, relative to the parameter; for a parameter of 0 in SI units.
_STEP = 1e-6
_STEP_AT_ZERO = 1e-9
#: Relative difference of the two derivatives that a smooth quantity does not reach.
_DIFFERENCE = 1e-3
#: Elasticities below this count as zero: their digits are due to rounding.
_SMALL = 1e-7


def one_sided(
    gradient_at: Callable[[np.ndarray], np.ndarray], values: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives just below and just above each parameter.

    **Arguments:**

    - `gradient_at`: derivatives (quantities × parameters) for shifts of all single numbers [SI].
    - `values`: present values of the numbers behind each parameter, which move together.

    **Returns:** the derivatives below and above, quantities × parameters.
    """
    sizes = [len(group) for group in values]
    first = np.concatenate([[0], np.cumsum(sizes)])
    sides = []
    for sign in (-1.0, 1.0):
        columns = []
        for column, group in enumerate(values):
            shifts = np.zeros(first[-1])
            shifts[first[column] : first[column + 1]] = sign * np.where(
                group == 0, _STEP_AT_ZERO, _STEP * np.abs(group)
            )
            columns.append(gradient_at(shifts)[:, column])
        sides.append(np.stack(columns, axis=1))
    return sides[0], sides[1]


def differ(
    left: np.ndarray, right: np.ndarray, values: np.ndarray, parameters: Sequence[np.ndarray]
) -> np.ndarray:
    """Which derivatives have a kink (quantities × parameters).

    **Arguments:**

    - `left`, `right`: from `one_sided`.
    - `values`: of the quantities.
    - `parameters`: present values of the numbers behind each parameter.
    """
    size = np.array([np.max(np.abs(group)) for group in parameters])
    with np.errstate(invalid="ignore", divide="ignore"):
        small = _SMALL * np.abs(values)[:, None] / np.where(size > 0, size, 1.0)[None, :]
        largest = np.maximum(np.abs(left), np.abs(right))
        return np.abs(right - left) > _DIFFERENCE * largest + small
