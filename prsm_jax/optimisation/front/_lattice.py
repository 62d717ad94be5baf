"""Reference points of a front: a lattice on the plane where the scaled objectives sum to 1.

A reference point is a tuple of whole numbers whose sum is the number of divisions m; divided by m
it is a point of the plane. A line along (1, …, 1) through it meets the front at most once.
"""

import math

import numpy as np


def divisions(objectives: int, points: int) -> int:
    """Number of divisions of the unit simplex that gives about as many reference points.

    **Arguments:**

    - `objectives`: 2 or 3.
    - `points`: how many points the front should have.
    """
    if objectives == 2:
        return points - 1
    # A triangle with m divisions has (m + 1)(m + 2)/2 points.
    return max(2, round((math.sqrt(8 * points + 1) - 3) / 2))


def reference(index: tuple[int, ...], count: int) -> np.ndarray:
    """The scaled objectives of a reference point, for `count` divisions."""
    return np.asarray(index, dtype=float) / count


def neighbours(index: tuple[int, ...], count: int) -> list[tuple[int, ...]]:
    """The reference points next to one, within the projection of the unit cube onto the plane."""
    weights = []
    for up in range(len(index)):
        for down in range(len(index)):
            if up != down:
                step = list(index)
                step[up] += 1
                step[down] -= 1
                if max(step) - min(step) <= count:
                    weights.append(tuple(step))
    return weights
