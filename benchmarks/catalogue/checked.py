"""Designs evaluated again, one by one: built by public functions, with `compute` and `check`."""

from typing import Any

import jax.numpy as jnp
import numpy as np

import prsm_jax as prsm

from .problem import MEASURES, OBJECTIVES, Size, built, dimensioned, gains
from .search import Found

#: Further quantities that are compared with those of the size's own design.
_OTHERS = ("buckling_load", "critical_speed", "max_pressure", "nut_outer_diameter")


def design_of(found: Found) -> Any:
    """The mechanism of a result."""
    angle, profile_ratio, length_ratio, count = (float(one) for one in found.variables)
    task = found.task
    return built(task.size, task.starts, angle, profile_ratio, length_ratio, round(count))


def _numbers(mechanism: Any) -> np.ndarray:
    names = (*MEASURES, *_OTHERS)
    values = prsm.compute(mechanism, names)
    return np.array([float(jnp.max(values[name])) for name in names])


def checked(size: Size, found: Found) -> dict[str, Any]:
    """What an independent evaluation of one result says.

    **Returns:** the largest relative difference of the measures to those of the batch, the smallest
    gains, the errors of `check`, and further quantities over those of the size's own design.
    """
    design = design_of(found)
    own, numbers = _numbers(dimensioned(size, size.starts)), _numbers(design)
    measures = numbers[: len(MEASURES)]
    gained = gains(measures, found.task.limits)
    return {
        "difference": float(np.max(np.abs(measures / found.measures - 1))),
        "smallest_gain": float(np.min(gained[: len(OBJECTIVES)])),
        "smallest_slack": float(np.min(gained[len(OBJECTIVES) :])),
        "errors": [one.name for one in prsm.check(design) if one.severity == "error"],
        "over_own": dict(zip(_OTHERS, map(float, (numbers / own)[len(MEASURES) :]), strict=True)),
    }
