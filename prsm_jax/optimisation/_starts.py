"""Starting points of the searches."""

import numpy as np


def starting_positions(present: np.ndarray, count: int, seed: int) -> np.ndarray:
    """The present design moved into the unit box, then a Latin hypercube.

    **Arguments:**

    - `present`: the present design in units of the box; may lie outside.
    - `count`: total number of starts.
    - `seed`: of the hypercube.

    **Returns:** positions, one row per start.
    """
    first = np.clip(present, 0.0, 1.0)[None]
    if count == 1:
        return first
    random = np.random.default_rng(seed)
    others, dimensions = count - 1, len(present)
    cells = np.stack([random.permutation(others) for _ in range(dimensions)], axis=1)
    return np.concatenate([first, (cells + random.random((others, dimensions))) / others])
