"""The result for the user in SI units from the ends of all searches."""

import numpy as np

from ...mechanism import DesignProblem, Mechanism, find_parameters
from ...quantities import find_quantity
from ..results import ConstraintReport, Optimality, Reporter, constraint_reports
from ..search import Evaluator, Point
from ._dominance import hypervolume, non_dominated
from ._result import FrontPoint, ParetoFront, senses
from ._scalarised import Solved
from ._search import SAME, FrontSearch

#: Distance of the reference point beyond the worst points, in ranges of the objectives.
_BEYOND = 0.1


def front_of(
    mechanism: Mechanism,
    problem: DesignProblem,
    evaluator: Evaluator,
    report: Reporter,
    search: FrontSearch,
    initial: np.ndarray,
) -> ParetoFront:
    """The complete result: points, dropped designs, the volume, and the verdict in words."""
    words = _Words(evaluator, report, problem, search.tolerance)
    ends = sorted(search.ends, key=lambda one: tuple(one.objectives))
    statuses = _statuses(ends, search)
    points = [
        words.point(one, status)
        for one, status in zip(ends, statuses, strict=True)
        if status in ("optimal", "not converged")
    ]
    dropped = [
        words.point(one, status)
        for one, status in zip(ends, statuses, strict=True)
        if status not in ("optimal", "not converged")
    ]
    names = [one.quantity for one in problem.objectives]
    volume, ideal, reference = 0.0, {}, {}
    if points:
        signs = senses(problem.objectives)
        values = signs * np.array([list(one.objectives.values()) for one in points])
        best, worst = values.min(axis=0), values.max(axis=0)
        width = np.where(worst > best, worst - best, np.maximum(np.abs(best), 1e-300))
        beyond = worst + _BEYOND * width
        volume = hypervolume((values - best) / (beyond - best), np.ones(len(best)))
        ideal = dict(zip(names, map(float, signs * best), strict=True))
        reference = dict(zip(names, map(float, signs * beyond), strict=True))
    return ParetoFront(
        mechanism=mechanism,
        problem=problem,
        points=tuple(points),
        start=words.start(evaluator.point(initial)),
        dropped=tuple(dropped),
        hypervolume=volume,
        reference=reference,
        ideal=ideal,
        tolerance=search.tolerance,
        message=_message(points, search),
        complete=search.complete,
        evaluations=evaluator.evaluations,
        derivative_evaluations=evaluator.derivative_evaluations,
        variable_units={
            one.name: find_parameters(mechanism, one.name)[0].unit for one in problem.variables
        },
        objective_units={name: find_quantity(name).unit for name in names},
    )


def _statuses(ends: list[Solved], search: FrontSearch) -> list[str]:
    """Status of each end: a point of the front, or the reason why it is not one."""
    statuses = ["" if search.feasible(one) else "infeasible" for one in ends]
    # Equal designs: the one that satisfies the optimality conditions best stays.
    order = np.argsort([one.conditions.residual for one in ends], kind="stable")
    kept: list[int] = []
    for index in order:
        if statuses[index]:
            continue
        distances = [ends[index].objectives - ends[other].objectives for other in kept]
        if any(np.max(np.abs(one)) <= SAME for one in distances):
            statuses[index] = "repeated"
        else:
            kept.append(int(index))
    values = np.array([ends[index].objectives for index in kept])
    for index, best in zip(kept, non_dominated(values) if kept else (), strict=True):
        good = "optimal" if search.converged(ends[index]) else "not converged"
        statuses[index] = good if best else "dominated"
    return statuses


def _message(points: list[FrontPoint], search: FrontSearch) -> str:
    if not points:
        return search.message or "no feasible design found"
    worst = max(one.kkt_residual for one in points)
    poor = sum(one.status != "optimal" for one in points)
    words = f"largest KKT residual {worst:.1e} <= {search.tolerance:.1e}"
    if poor:
        words = (
            f"the KKT residual of {poor} of {len(points)} points is above {search.tolerance:.1e}"
        )
    return f"{search.message}; {words}" if search.message else words


class _Words:
    """Designs in SI units with names."""

    def __init__(
        self, evaluator: Evaluator, report: Reporter, problem: DesignProblem, tolerance: float
    ):
        self._evaluator, self._report, self._tolerance = evaluator, report, tolerance
        self._terms = problem.objectives
        self._objectives = [one.quantity for one in problem.objectives]
        self._variables = [one.name for one in problem.variables]

    def _values(self, point: Point) -> dict[str, float]:
        means = {one.quantity: self._evaluator.rows.mean_of(one) for one in self._terms}
        return {
            name: float(mean[mean != 0] @ point.values[mean != 0]) for name, mean in means.items()
        }

    def _broken(self, point: Point) -> tuple[ConstraintReport, ...]:
        """Constraints and margins that a usable design breaks."""
        if not point.good:
            return ()
        sign = self._report.sign
        rows = constraint_reports(self._evaluator, sign, point, None, self._tolerance)
        return tuple(row for row in rows if not row.satisfied)

    def start(self, point: Point) -> FrontPoint:
        """The present design, for which no search has checked the optimality."""
        violation = self._report.violation(point)
        return FrontPoint(
            variables=self._report.variables(point.position),
            objectives=self._values(point),
            constraints=self._report.constraints(point),
            margins=self._report.margins(point),
            weights={},
            active=(),
            kkt_residual=float("nan"),
            violation=violation,
            status="present design" if point.good else "fails",
            broken=self._broken(point),
        )

    def point(self, one: Solved, status: str) -> FrontPoint:
        """The end of a search."""
        report, conditions = self._report, one.conditions
        return FrontPoint(
            variables=report.variables(one.point.position),
            objectives=self._values(one.point),
            constraints=report.constraints(one.point),
            margins=report.margins(one.point),
            weights=dict(zip(self._objectives, map(float, one.weights), strict=True)),
            active=self._active(conditions),
            kkt_residual=conditions.residual,
            violation=report.violation(one.point),
            status=status,
            message=one.message,
            broken=self._broken(one.point),
        )

    def _active(self, conditions: Optimality) -> tuple[str, ...]:
        rows = zip(self._evaluator.rows.names, conditions.active, strict=True)
        names = [name for name, active in rows if active]
        for name, side in zip(self._variables, conditions.active_bounds, strict=True):
            if side:
                names.append(f"{'upper' if side > 0 else 'lower'} bound of {name}")
        return tuple(names)
