"""Changes of the results when a part of the physics is left out."""

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._errors import PrsmError, UnknownNameError, closest
from ..explanation import Place, places, without
from ..fields import listed_names
from ..mechanism import Mechanism
from ..optimisation import ParetoFront, hypervolume
from ..quantities import available_quantities
from ._conflict import plain
from ._map import DriverMap, at_designs
from ._problem import StudyProblem

#: Parts that are left out where none are named and the mechanism has them.
DEFAULT_PARTS = ("spin", "rolling_hysteresis", "load_sharing")


@dataclass(frozen=True)
class Variant:
    """The same mechanism without one part of its physics.

    - `name`: of the part, such as `spin`; `parts`: its places, such as `stage.1.friction.spin`.
    - `misses`: effects that the results lack without it, in words.
    - `values`: quantities without the part (not those of limits), of the present design and then of
      the points of the complete front.
    - `changes`: relative changes of these values from the complete physics.
    - `turned`: signs of elasticities that differ from those of the complete physics, as quantity,
      driver, and the number of these designs.
    - `without_data`: limits that need the part, and so cannot apply to its front.
    - `front`: the front found without the part; `None` if there is none.
    - `complete`: quantities of its points with complete physics.
    - `allowed`: which of its points satisfy all limits with complete physics.
    - `violations`: largest violation of each limit at its points with complete physics, relative.
    - `volume`: volume that its allowed points dominate with complete physics, relative to that of
      the complete front. NaN where there is no front.
    - `error`: why the quantities cannot be computed without the part; empty if they can.
    """

    name: str
    parts: tuple[str, ...]
    misses: str
    values: dict[str, np.ndarray] = field(default_factory=dict)
    changes: dict[str, np.ndarray] = field(default_factory=dict)
    turned: tuple[tuple[str, str, int], ...] = ()
    without_data: tuple[str, ...] = ()
    front: ParetoFront | None = None
    complete: dict[str, np.ndarray] = field(default_factory=dict)
    allowed: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    violations: dict[str, float] = field(default_factory=dict)
    volume: float = math.nan
    error: str = ""

    def best(self, objective: str) -> dict[str, float]:
        """Drivers [SI] of the point that is best in an objective; empty without a front."""
        return {} if self.front is None else best_of(self.front, objective)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON; `None` where one is not finite."""

        def lists(arrays: dict[str, np.ndarray]) -> dict[str, list[float | None]]:
            return {name: [plain(float(v)) for v in array] for name, array in arrays.items()}

        front = self.front
        return {
            "name": self.name,
            "parts": list(self.parts),
            "misses": self.misses,
            "values": lists(self.values),
            "changes": lists(self.changes),
            "turned": [{"quantity": q, "driver": d, "designs": n} for q, d, n in self.turned],
            "limits_without_data": list(self.without_data),
            "front": None if front is None else front.to_dict(),
            "best": {}
            if front is None
            else {one.quantity: self.best(one.quantity) for one in front.objectives},
            "values_complete": lists(self.complete),
            "allowed_complete": list(map(bool, self.allowed)),
            "violations_complete": {name: plain(v) for name, v in self.violations.items()},
            "volume_complete": plain(self.volume),
            "error": self.error or None,
        }


def best_of(front: ParetoFront, objective: str) -> dict[str, float]:
    """Drivers [SI] of the point of a front that is best in an objective; empty without points."""
    sense = next(one.sense for one in front.objectives if one.quantity == objective)
    pick = max if sense == "maximise" else min
    if not front.points:
        return {}
    return dict(pick(front.points, key=lambda one: one.objectives[objective]).variables)


def parts_of(mechanism: Mechanism, names: Iterable[str] | None) -> dict[str, tuple[Place, ...]]:
    """Places of the parts to be left out, by their names.

    A name is the end of the name of a place, such as `spin`, and stands for all stages.

    **Raises:** `UnknownNameError` where the mechanism has no such part.
    """
    present = [one for one in places(mechanism) if one.present and one.kind in ("table", "list")]

    def named(name: str) -> tuple[Place, ...]:
        return tuple(p for p in present if p.name == name or p.name.endswith(f".{name}"))

    if names is None:
        named_parts = {name: named(name) for name in DEFAULT_PARTS}
        return {name: some for name, some in named_parts.items() if some}
    chosen = {name: named(name) for name in listed_names(names, "without")}
    for name, some in chosen.items():
        if not some:
            hint = closest(name, {p.name.rpartition(".")[2] for p in present})
            raise UnknownNameError(
                f"without names {name!r}, a part that the mechanism does not have; {hint}"
            )
    return chosen


def variant_of(
    mechanism: Mechanism,
    problem: StudyProblem,
    name: str,
    parts: Sequence[Place],
    designs: Sequence[dict[str, float]],
    complete: DriverMap,
    front: ParetoFront,
    grid: int,
    find_front: Callable[[Mechanism, StudyProblem], ParetoFront],
) -> Variant:
    """The results of a study without a part.

    **Arguments:**

    - `mechanism`, `problem`: mechanism and problem of the study.
    - `name`, `parts`: of the part that is left out.
    - `designs`, `complete`: the present design and the points of the front, and their quantities
      with complete physics.
    - `front`: the complete front.
    - `grid`: number of designs of the map, whose program serves the complete mechanism.
    - `find_front`: finds the front of a mechanism.
    """
    variant = Variant(name, tuple(p.name for p in parts), _misses(parts))
    try:
        # From the last to the first, so that places in lists stay valid.
        rest = mechanism
        for part in reversed(parts):
            rest = without(rest, part)
        known = available_quantities(rest, problem.computed)
        lacking = [one for one in problem.senses if one not in known]
        if lacking:
            raise PrsmError(f"without {name} there is no {', '.join(lacking)}")
        fewer = dataclasses.replace(
            problem,
            limits=tuple(one for one in problem.limits if one.quantity in known),
            limited={one: sense for one, sense in problem.limited.items() if one in known},
        )
        bare = at_designs(rest, fewer, designs, list(problem.senses))
        variant = dataclasses.replace(
            variant,
            values=bare.values,
            changes={one: bare.values[one] / complete.values[one] - 1 for one in problem.senses},
            turned=_turned(problem, complete, bare),
            without_data=tuple(
                dict.fromkeys(q.quantity for q in problem.limits if q.quantity not in known)
            ),
        )
        other = find_front(rest, fewer)
    except (PrsmError, ValueError) as error:
        return dataclasses.replace(variant, error=str(error))
    variant = dataclasses.replace(variant, front=other)
    if not other.points:
        return variant
    there = at_designs(
        mechanism, problem, [one.variables for one in other.points], problem.computed, grid
    )
    return dataclasses.replace(
        variant,
        complete={one: there.values[one] for one in problem.names},
        allowed=there.allowed,
        violations={one: float(np.max(there.violations[one])) for one in there.violations},
        volume=_volume(problem, front, there),
    )


def _misses(parts: Sequence[Place]) -> str:
    return "; ".join(dict.fromkeys(part.without for part in parts))


def _turned(
    problem: StudyProblem, complete: DriverMap, bare: DriverMap
) -> tuple[tuple[str, str, int], ...]:
    counts = []
    for name in problem.senses:
        opposite = complete.elasticities[name] * bare.elasticities[name] < 0
        for place, driver in enumerate(problem.drivers):
            count = int(np.sum(opposite[:, place]))
            if count:
                counts.append((name, driver.name, count))
    return tuple(counts)


def _volume(problem: StudyProblem, front: ParetoFront, there: DriverMap) -> float:
    """Dominated volume of the allowed designs relative to that of the front."""
    if not front.points:
        return math.nan
    signs = np.array([-1.0 if one.sense == "maximise" else 1.0 for one in front.objectives])
    values = np.stack([there.values[name] for name in problem.objectives], axis=-1)
    worst = signs * np.array([front.reference[name] for name in problem.objectives])
    allowed = signs * values[there.allowed]
    volume = hypervolume(allowed, worst) if len(allowed) else 0.0
    return float(volume / front.dominated_volume(front.reference))
