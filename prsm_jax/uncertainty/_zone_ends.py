"""Quantities with one number at an end of its tolerance zone, and all others nominal."""

import dataclasses

import numpy as np

from ._inputs import Inputs


@dataclasses.dataclass(frozen=True)
class ZoneEnds:
    """One quantity at the ends of all tolerance zones [SI].

    - `nominal`: with all numbers nominal.
    - `lower`, `upper`: with the number of one tolerance at the lower and at the upper end of its
      zone, one value for each tolerance; NaN for a design that fails.
    """

    nominal: float
    lower: np.ndarray
    upper: np.ndarray


def zone_points(inputs: Inputs) -> np.ndarray:
    """Standardised deviations of the nominal design, then of all lower and of all upper ends.

    **Returns:** (1 + 2 tolerances) × tolerances.
    """
    count = len(inputs.tolerances)
    deviations = np.zeros((1 + 2 * count, count))
    for index, one in enumerate(inputs.tolerances):
        deviations[1 + index, index] = one.lower
        deviations[1 + count + index, index] = one.upper
    middle = np.array([one.middle for one in inputs.tolerances])
    spread = np.array([one.standard_deviation for one in inputs.tolerances])
    return (deviations - middle) / spread


def zone_ends(values: dict[str, np.ndarray]) -> dict[str, ZoneEnds]:
    """Values of each quantity at the points of `zone_points`: nominal, lower and upper ends."""
    by_label: dict[str, ZoneEnds] = {}
    for label, array in values.items():
        lower, upper = np.split(array[1:], 2)
        by_label[label] = ZoneEnds(float(array[0]), lower, upper)
    return by_label
