"""The front of several objectives: points, their active limits, and the dominated volume."""

import math
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...mechanism import DesignProblem, Mechanism, Objective, set_parameters
from ...results import Shown
from ...text import TextTable, display_unit, state_without_efficiency
from ..results import ConstraintReport
from ._dominance import hypervolume


@dataclass(frozen=True)
class FrontPoint:
    """One design [SI], with its optimality.

    `weights` (sum 1, by objective) are multipliers of the objectives scaled by their range: the
    design minimises their weighted sum to first order, so that the ratio of two weights is the
    exchange rate of two objectives along the front. `kkt_residual` is that of this sum.
    """

    variables: dict[str, float]
    objectives: dict[str, float]
    constraints: dict[str, float]
    #: Margins of findings that depend on the variables, by finding and stage.
    margins: dict[str, float]
    weights: dict[str, float]
    #: Constraints, margins and bounds that are active.
    active: tuple[str, ...]
    kkt_residual: float
    #: Largest violation of a constraint in scaled units: over its larger limit, or its magnitude.
    violation: float
    #: `"optimal"`, `"not converged"`, `"infeasible"`, `"dominated"` or `"repeated"`.
    status: str
    message: str = ""
    #: Constraints and margins that the design breaks, with value and limit [SI].
    broken: tuple[ConstraintReport, ...] = ()

    @property
    def breaks(self) -> str:
        """The limits that it breaks, in words; those of findings end with "of prsm check"."""
        names = [
            one.name if one.name in self.constraints else f"{one.name} of prsm check"
            for one in self.broken
        ]
        return f"breaks {', '.join(names)}" if names else ""

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON; `None` where one is not finite."""
        numbers = {
            name: {key: _plain(value) for key, value in getattr(self, name).items()}
            for name in ("variables", "objectives", "constraints", "margins", "weights")
        }
        return {
            "variables": numbers["variables"],
            "quantities": numbers["objectives"] | numbers["constraints"],
            "margins": numbers["margins"],
            "weights": numbers["weights"],
            "active": list(self.active),
            "kkt_residual": _plain(self.kkt_residual),
            "violation": _plain(self.violation),
            "status": self.status,
            "message": self.message,
            "broken": [
                {
                    "name": one.name,
                    "unit": one.unit,
                    "value": _plain(one.value),
                    "limit": _plain(one.limit),
                }
                for one in self.broken
            ],
        }


@dataclass(frozen=True, repr=False)
class ParetoFront(Shown):
    """The designs found that no other design dominates; prints itself.

    `points` are ordered by the first objective, the best first. No point of them is dominated by
    another, and each satisfies every constraint and error limit of `check` (with
    `avoid_warnings` limits of warnings, too).
    """

    #: The given mechanism; `design` returns the mechanism of a point.
    mechanism: Mechanism
    problem: DesignProblem
    points: tuple[FrontPoint, ...]
    #: The present design, which may violate limits.
    start: FrontPoint
    #: Results of searches that are not points of the front, with the reason as their status.
    dropped: tuple[FrontPoint, ...]
    #: Share of the box between the ideal point and `reference` that the front dominates.
    hypervolume: float
    #: The point that is worse than every point of the front by 10 % of the range of each objective.
    reference: dict[str, float]
    #: Best value of each objective among the points.
    ideal: dict[str, float]
    tolerance: float
    message: str
    #: Designs whose values were computed, and designs whose derivatives were.
    evaluations: int
    derivative_evaluations: int
    variable_units: dict[str, str]
    objective_units: dict[str, str]
    #: Whether the best of each objective was found; else the front may extend beyond its ends.
    complete: bool = True

    @property
    def objectives(self) -> tuple[Objective, ...]:
        """The objectives with their senses."""
        return self.problem.objectives

    @property
    def converged(self) -> bool:
        """Whether the best of each objective was found, and every point is optimal."""
        return (
            self.complete
            and bool(self.points)
            and all(one.status == "optimal" for one in self.points)
        )

    @property
    def least_violation(self) -> FrontPoint | None:
        """Where no design found is feasible, the one that breaks its limits least."""
        found = [one for one in self.dropped if one.broken] if not self.points else []
        return min(found, key=lambda one: one.violation, default=None)

    @property
    def values(self) -> np.ndarray:
        """Objectives of the points [SI], points × objectives."""
        rows = [list(one.objectives.values()) for one in self.points]
        return np.array(rows, dtype=float).reshape(len(rows), len(self.objectives))

    def design(self, index: int) -> Mechanism:
        """The mechanism of a point, a pytree like the given one.

        **Raises:** `IndexError` for a point that does not exist.
        """
        count = len(self.points)
        if not -count <= index < count:
            known = f"points 0 to {count - 1}" if count else "no points"
            raise IndexError(f"index is {index}; the front has {known}")
        return set_parameters(self.mechanism, self.points[index].variables, checked=False)

    def dominated_volume(self, reference: Mapping[str, float]) -> float:
        """The area or volume between the front and a point, in the product of the units.

        **Arguments:**

        - `reference`: a value [SI] for every objective; points that are not better add nothing.

        **Raises:** `ValueError` where an objective has no value.
        """
        missing = [one.quantity for one in self.objectives if one.quantity not in reference]
        if missing:
            raise ValueError(f"the reference has no value for {', '.join(missing)}; give one")
        signs = senses(self.objectives)
        worst = signs * np.array([reference[one.quantity] for one in self.objectives])
        return hypervolume(signs * self.values, worst)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON; `None` where one is not finite."""
        nearest = self.least_violation
        return {
            "objectives": [
                {"quantity": one.quantity, "sense": one.sense} for one in self.objectives
            ],
            "points": [one.to_dict() for one in self.points],
            "start": self.start.to_dict(),
            "dropped": [one.to_dict() for one in self.dropped],
            "least_violation": None if nearest is None else nearest.to_dict(),
            "hypervolume": _plain(self.hypervolume),
            "hypervolume_reference": {k: _plain(v) for k, v in self.reference.items()},
            "ideal": {k: _plain(v) for k, v in self.ideal.items()},
            "converged": self.converged,
            "message": self.message,
            "evaluations": self.evaluations,
            "derivative_evaluations": self.derivative_evaluations,
            "variable_units": dict(self.variable_units),
            "objective_units": dict(self.objective_units),
        }

    def to_table(self) -> TextTable:
        """The points in an engineer's units, a row each; the present design first.

        Without points it follows the design of least violation.
        """
        nearest = self.least_violation
        first = {"start": self.start}
        if nearest is not None:
            first = {"least violation": nearest, **first}
        designs = [*first.values(), *self.points]
        columns: list[str] = [""]
        cells: list[list[Any]] = [[*first, *(str(i + 1) for i in range(len(self.points)))]]
        groups = (
            ("objectives", self.objective_units),
            ("variables", self.variable_units),
        )
        senses_by_name = {one.quantity: one.sense for one in self.objectives}
        for group, units in groups:
            for name, unit in units.items():
                values = [getattr(one, group)[name] for one in designs]
                quantity = name if group == "objectives" else ""
                shown = display_unit(unit, values, quantity)
                words = f"{senses_by_name[name]} {name}" if quantity else name
                columns.append(f"{words} [{shown.label}]" if shown.label else words)
                cells.append([state_without_efficiency(quantity, v) or shown(v) for v in values])
        columns += ["KKT residual", "status"]
        cells.append([one.kkt_residual for one in designs])
        cells.append([", ".join(filter(None, (one.status, one.breaks))) for one in designs])
        return TextTable("", columns, list(zip(*cells, strict=True)))

    def text(self, width: int | None = None) -> str:
        """The points as a table in an engineer's units, and the verdict.

        If no feasible design was found, the first line says so.

        **Arguments:**

        - `width`: number of characters in a line; default as many as the table needs.
        """
        values, slopes = self.evaluations, self.derivative_evaluations
        cost = f"{values} evaluations of values, {slopes} of derivatives"
        table = self.to_table().text(width)
        if not self.points:
            first = f"NO FEASIBLE DESIGN: {self.message}"
            lines = [first] if width is None else textwrap.wrap(first, width)
            return "\n".join([*lines, *([table] if self.least_violation else []), cost])
        return "\n".join(
            [
                table,
                f"{'converged' if self.converged else 'NOT CONVERGED'}: {self.message}",
                f"{len(self.points)} points; {cost}; the front dominates "
                f"{100 * self.hypervolume:.4g} % of the box up to its reference point",
            ]
        )

    def __str__(self) -> str:
        return self.text()


def senses(objectives: tuple[Objective, ...]) -> np.ndarray:
    """−1 for each objective to be maximised, else 1."""
    return np.array([-1.0 if one.sense == "maximise" else 1.0 for one in objectives])


def _plain(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
