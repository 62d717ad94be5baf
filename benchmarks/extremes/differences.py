"""Derivatives along a direction by extrapolated differences, with an estimate of their own error.

Neville's scheme on central differences at steps h, h/4, h/16, … (Ridders 1982), whose own error
is the smallest disagreement in the table, with the rounding of the function added. One-sided
differences tell a kink, where a derivative is any number between the two.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

#: Relative steps.
STEPS = tuple(4e-3 / 4**k for k in range(8))
_SMALL = 1e-300

Values = dict[str, np.ndarray]


@dataclass(frozen=True)
class Slope:
    """A derivative by differences, the estimate of its error, and whether there is a kink."""

    value: np.ndarray
    error: np.ndarray
    #: Half the jump of the derivative; 0 where it is smooth.
    jump: np.ndarray


def _neville(slopes: list[np.ndarray], noises: list[np.ndarray]):
    """The best entry of the table of extrapolations, and its error."""
    best, error = slopes[0], np.full_like(slopes[0], np.inf)
    previous = [slopes[0]]
    for k in range(1, len(slopes)):
        row = [slopes[k]]
        factor = 1.0
        for j in range(1, k + 1):
            factor *= 16.0
            row.append(row[j - 1] + (row[j - 1] - previous[j - 1]) / (factor - 1))
            disagreement = np.maximum(abs(row[j] - row[j - 1]), abs(row[j] - previous[j - 1]))
            own = disagreement + noises[k]
            better = own < error
            best, error = np.where(better, row[j], best), np.where(better, own, error)
        previous = row
    return best, error


def slopes(
    function: Callable[[float], tuple[Values, dict[str, bool]]],
    centre: Values,
    wobble: Values,
    steps: tuple[float, ...] = STEPS,
) -> dict[str, Slope | None]:
    """Derivatives of every value of `function(h)` at h = 0.

    **Arguments:**

    - `function`: values and whether each can be used, at a step along the direction.
    - `centre`: values at 0.
    - `wobble`: how far rounding of the inputs moves each value.
    - `steps`: descending by factors of 4.

    **Returns:** for each value its derivative, or `None` where too few steps can be used.
    """
    up, down = [function(h) for h in steps], [function(-h) for h in steps]
    found: dict[str, Slope | None] = {}
    for name, middle in centre.items():
        usable = [
            k
            for k in range(len(steps))
            if all(side[k][1][name] and np.isfinite(side[k][0][name]).all() for side in (up, down))
        ]
        # A stretch without gaps that ends at the smallest step.
        run = [k for k in usable if all(later in usable for later in range(k, len(steps)))]
        if len(run) < 3:
            found[name] = None
            continue
        central, noises, halves = [], [], []
        for k in run:
            h, high, low = steps[k], up[k][0][name], down[k][0][name]
            central.append((high - low) / (2 * h))
            rounding = 4e-16 * np.maximum(abs(high), abs(low)) + wobble[name]
            noises.append(rounding / h)
            halves.append((high - 2 * middle + low) / h)
        value, error = _neville(central, noises)
        found[name] = Slope(value, error, _jump(halves, noises))
    return found


def _jump(halves: list[np.ndarray], noises: list[np.ndarray]) -> np.ndarray:
    """Half the jump of the derivative, where second differences over h do not fall with h."""
    jump = np.zeros_like(halves[0])
    for k in range(1, len(halves)):
        before, after = abs(halves[k - 1]), abs(halves[k])
        stays = (after > 0.6 * before) & (after > 8 * noises[k]) & (before > _SMALL)
        jump = np.where(stays, np.maximum(jump, 0.5 * after), jump)
    return jump
