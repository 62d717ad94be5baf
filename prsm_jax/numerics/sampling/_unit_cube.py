"""Latin hypercubes and Sobol's sequence of SciPy, whose argument for the seed has two names."""

from typing import Any

import numpy as np


def latin_hypercube(dimensions: int, count: int, seed: int | np.random.Generator) -> np.ndarray:
    """A Latin hypercube, points × dimensions: one point in each of `count` parts of every axis."""
    from scipy.stats import qmc

    return _seeded(qmc.LatinHypercube, dimensions, seed).random(count)


def sobol_points(dimensions: int, power: int, seed: int | np.random.Generator) -> np.ndarray:
    """The first 2^`power` points of Sobol's scrambled sequence, points × dimensions."""
    from scipy.stats import qmc

    return _seeded(qmc.Sobol, dimensions, seed).random_base2(power)


def _seeded(sampler: Any, dimensions: int, seed: int | np.random.Generator) -> Any:
    try:
        return sampler(dimensions, rng=seed)
    except TypeError:  # SciPy before 1.15
        return sampler(dimensions, seed=seed)
