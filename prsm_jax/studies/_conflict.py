"""Where two quantities conflict: the angle between their elasticities."""

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._map import DriverMap
from ._problem import Sense, StudyProblem

#: A quantity that changes by less than this [% per %] does not depend on the drivers.
_NOTHING = 1e-9


@dataclass(frozen=True)
class Conflict:
    """Agreement or conflict of two quantities over the drivers.

    The cosine is that of the angle between their elasticities, each with the sign of its sense. It
    is 1 where the same change of the drivers is the best for both quantities, and −1 where the best
    change for one is the worst for the other. Below 0 the quantities conflict: the best small
    change for either of them worsens the other. The cosine refers to relative changes of the
    drivers. It is NaN for a design that fails, or where one of the two quantities does not change.

    - `cosine`: over the grid of the map.
    - `present`: cosine of the present design.
    - `share`: share of conflicts among the designs with a cosine; NaN if there are none.
    - `share_allowed`: share of conflicts among the designs that satisfy all limits.
    - `by_driver`: for each driver, the share of designs in which an increase of the driver improves
      one quantity and worsens the other.
    - `most`, `least`: drivers [SI] of the designs with the lowest and the highest cosine.
    - `limit`: whether the second quantity belongs to a limit.
    """

    first: str
    second: str
    senses: tuple[Sense, Sense]
    limit: bool
    cosine: np.ndarray
    present: float
    share: float
    share_allowed: float
    by_driver: dict[str, float]
    most: dict[str, float]
    least: dict[str, float]

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest cosine; NaN if there is none."""
        known = self.cosine[np.isfinite(self.cosine)]
        return (float(known.min()), float(known.max())) if known.size else (math.nan, math.nan)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON; `None` where one is not finite."""
        lowest, highest = self.range
        return {
            "first": self.first,
            "second": self.second,
            "senses": list(self.senses),
            "second_is_limit": self.limit,
            "cosine_present": plain(self.present),
            "cosine_lowest": plain(lowest),
            "cosine_highest": plain(highest),
            "share": plain(self.share),
            "share_allowed": plain(self.share_allowed),
            "share_by_driver": {name: plain(value) for name, value in self.by_driver.items()},
            "lowest_at": dict(self.most),
            "highest_at": dict(self.least),
        }


def cosine(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Cosine of the angle between vectors along the last axis; NaN where one is zero."""
    sizes = np.linalg.norm(first, axis=-1), np.linalg.norm(second, axis=-1)
    known = (sizes[0] > _NOTHING) & (sizes[1] > _NOTHING)
    product = np.where(known, sizes[0] * sizes[1], np.nan)
    return np.clip(np.sum(first * second, axis=-1) / product, -1.0, 1.0)


def conflicts_of(
    problem: StudyProblem, grid: DriverMap, present: DriverMap
) -> tuple[Conflict, ...]:
    """All pairs of quantities, and each quantity with each limited one.

    **Arguments:**

    - `problem`: the problem of the study.
    - `grid`: its map.
    - `present`: a list of designs; the first is the present one.
    """
    pairs = [
        *itertools.combinations(problem.senses, 2),
        *itertools.product(problem.senses, problem.limited),
    ]
    return tuple(_conflict(problem, grid, present, *pair) for pair in pairs)


def _conflict(
    problem: StudyProblem, grid: DriverMap, present: DriverMap, first: str, second: str
) -> Conflict:
    senses = problem.sense(first), problem.sense(second)
    signs = [1.0 if sense == "maximise" else -1.0 for sense in senses]

    def both(one: DriverMap) -> tuple[np.ndarray, np.ndarray]:
        return signs[0] * one.elasticities[first], signs[1] * one.elasticities[second]

    vectors = both(grid)
    angles = cosine(*vectors)
    known = np.isfinite(angles)
    opposite = vectors[0] * vectors[1] < 0
    most, least = {}, {}
    if known.any():
        places = [
            np.unravel_index(pick(angles), angles.shape) for pick in (np.nanargmin, np.nanargmax)
        ]
        most, least = (grid.design(tuple(map(int, place))) for place in places)
    return Conflict(
        first=first,
        second=second,
        senses=senses,
        limit=second in problem.limited,
        cosine=angles,
        present=float(cosine(*both(present))[0]),
        share=_share(angles < 0, known),
        share_allowed=_share(angles < 0, known & grid.allowed),
        by_driver={
            one.name: _share(opposite[..., index], known)
            for index, one in enumerate(problem.drivers)
        },
        most=most,
        least=least,
    )


def _share(where: np.ndarray, among: np.ndarray) -> float:
    return float(np.sum(where & among) / np.sum(among)) if among.any() else math.nan


def plain(value: float) -> float | None:
    """A number for JSON."""
    return float(value) if math.isfinite(value) else None
