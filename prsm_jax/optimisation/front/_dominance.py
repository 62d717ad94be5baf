"""Points that no other point dominates, and the volume that they dominate."""

import numpy as np


def non_dominated(objectives: np.ndarray) -> np.ndarray:
    """Which points no other point dominates; of equal points the first one counts.

    A point dominates another if it is worse in no objective and better in at least one.

    **Arguments:**

    - `objectives`: to be minimised, points × objectives.

    **Returns:** true for the points of the front (points).
    """
    objectives = np.asarray(objectives, dtype=float)
    keep = np.ones(len(objectives), dtype=bool)
    for index, point in enumerate(objectives):
        no_worse = np.all(objectives <= point, axis=1)
        better = np.any(objectives < point, axis=1)
        equal_before = no_worse & ~better & (np.arange(len(objectives)) < index)
        keep[index] = not np.any((no_worse & better) | equal_before)
    return keep


def hypervolume(objectives: np.ndarray, reference: np.ndarray) -> float:
    """The area or volume between points and a reference point (Zitzler and Thiele 1998), exact.

    **Arguments:**

    - `objectives`: to be minimised, points × objectives; 1, 2 or 3 objectives.
    - `reference`: a point that is worse than the others (objectives); points that are not better
      in every objective add nothing.

    **Raises:** `ValueError` for more than three objectives.
    """
    reference = np.asarray(reference, dtype=float)
    count = len(reference)
    if not 1 <= count <= 3:
        raise ValueError(f"there are {count} objectives; the volume is computed for at most 3")
    points = np.asarray(objectives, dtype=float).reshape(-1, count)
    points = points[np.all(points < reference, axis=1)]
    if not len(points):
        return 0.0
    if count == 1:
        return float(reference[0] - points.min())
    # Slices between neighbouring values of the last objective.
    points = points[np.argsort(points[:, -1])]
    upper = np.append(points[1:, -1], reference[-1])
    return float(
        sum(
            (above - point[-1]) * hypervolume(points[: index + 1, :-1], reference[:-1])
            for index, (point, above) in enumerate(zip(points, upper, strict=True))
            if above > point[-1]
        )
    )
