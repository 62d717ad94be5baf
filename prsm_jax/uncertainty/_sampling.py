"""Monte Carlo with scrambled Sobol points, and standard errors from independent scramblings."""

from collections.abc import Callable
from typing import Any, TypeAlias

import jax.numpy as jnp
import numpy as np

from ..fields import Scalar
from ..numerics import sobol_points
from ..quantities import Quantity, component_names
from ._inputs import Inputs
from ._programs import evaluate_designs

#: Number of independent scramblings; the scatter of their results gives the standard errors.
SCRAMBLINGS = 8
#: Approximate number of designs in a compiled call.
CHUNK = 1024
Progress: TypeAlias = Callable[[int, int], None] | None


def points(inputs: Inputs, samples: int, seed: int) -> np.ndarray:
    """Standardised deviations: scramblings × points × tolerances.

    The number of points of each scrambling is rounded up to a power of 2, on which Sobol points
    are balanced.
    """
    power = max(int(np.ceil(np.log2(samples / SCRAMBLINGS))), 0)
    generators = np.random.default_rng(seed).spawn(SCRAMBLINGS)
    sets = [sobol_points(len(inputs.tolerances), power, one) for one in generators]
    return inputs.standardised(np.stack(sets))


def by_component(values: dict[str, np.ndarray], lead: int) -> dict[str, np.ndarray]:
    """Arrays of single numbers by their labels; the first `lead` axes are designs."""
    parts: dict[str, np.ndarray] = {}
    for name, array in values.items():
        shape = array.shape[lead:]
        flat = array.reshape(*array.shape[:lead], -1)
        for index, label in enumerate(component_names(name, shape)):
            parts[label] = flat[..., index]
    return parts


def evaluate_points(
    inputs: Inputs,
    deviations: np.ndarray,
    selected: tuple[Quantity, ...],
    speed: Scalar | None,
    load: Scalar | None,
    sources: tuple[Callable[..., Any], ...] | None,
    progress: Progress = None,
) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
    """Quantities (single numbers by label) at standardised deviations (designs × tolerances).

    **Returns:** values, NaN for designs that fail; codes; places of the first error of `check`.
    """
    values = inputs.values(deviations)
    total = len(values)
    # Chunks of equal size: the ends of the zones then need no further chunk of their own.
    size = -(-total // max(round(total / CHUNK), 1))
    parts: dict[str, list[np.ndarray]] = {}
    codes, errors = [], []
    for start in range(0, total, size):
        chunk = values[start : start + size]
        count = len(chunk)
        # The last chunk is filled up, so that all chunks use the same program.
        filled = np.concatenate([chunk, np.repeat(chunk[-1:], size - count, axis=0)])
        outputs, code, error = evaluate_designs(
            inputs.mechanism, inputs.paths, jnp.asarray(filled), selected, speed, load, sources
        )
        for one in selected:
            parts.setdefault(one.name, []).append(np.asarray(outputs[one.name])[:count])
        codes.append(np.asarray(code)[:count])
        errors.append(np.asarray(error)[:count])
        if progress is not None:
            progress(start + count, total)
    joined = {name: np.concatenate(arrays) for name, arrays in parts.items()}
    return by_component(joined, 1), np.concatenate(codes), np.concatenate(errors)


def standard_error(of_scramblings: np.ndarray) -> np.ndarray:
    """Standard error of the mean of independent estimates (first axis)."""
    return np.asarray(np.std(of_scramblings, axis=0, ddof=1) / np.sqrt(len(of_scramblings)))
