"""Reports for the user in SI units from scaled points: designs, runs and the optimum."""

import numpy as np

from ...findings import check
from ...geometry import Finding
from ...mechanism import DesignProblem, Mechanism, find_parameters, set_parameters
from ...quantities import find_quantity
from .._optimality import Optimality
from ..search import Evaluator, Point
from ._optimum import ConstraintReport, Design, Optimum, Run
from ._printing import against_limit


class Reporter:
    """Turns scaled points into designs in SI units, with the objective in its own sense."""

    def __init__(self, evaluator: Evaluator, problem: DesignProblem):
        self._evaluator = evaluator
        self._names = [variable.name for variable in problem.variables]
        all_maximise = all(term.sense == "maximise" for term in problem.objectives)
        #: Objective = sign × cost, so that a sum that is only maximised has its own sign.
        self.sign: float = -1.0 if all_maximise else 1.0

    def variables(self, position: np.ndarray) -> dict[str, float]:
        values = self._evaluator.physical(position)
        return dict(zip(self._names, map(float, values), strict=True))

    def objective(self, point: Point) -> float:
        if not point.good:
            return float("nan")
        return float(self.sign * self._evaluator.cost(point) * self._evaluator.cost_scale)

    def constraints(self, point: Point) -> dict[str, float]:
        rows = self._evaluator.rows
        values = map(float, point.values[rows.index[: rows.explicit]])
        return dict(zip(rows.names[: rows.explicit], values, strict=True))

    def margins(self, point: Point) -> dict[str, float]:
        """Values of the margins that depend on the variables, by finding and stage."""
        rows = self._evaluator.rows
        values = map(float, point.values[rows.index[rows.explicit :]])
        return dict(zip(rows.names[rows.explicit :], values, strict=True))

    def violation(self, point: Point) -> float:
        return self._evaluator.violation(point) if point.good else float("inf")

    def design(self, point: Point) -> Design:
        return Design(
            self.variables(point.position),
            self.objective(point),
            self.constraints(point),
            point.good,
            self.violation(point),
            self.margins(point),
        )


def run_report(
    report: Reporter,
    first: Point,
    end: Point | None,
    history: list[Point],
    conditions: Optimality | None,
    failures: int,
    iterations: int,
    message: str,
) -> Run:
    """The report of one search."""
    return Run(
        start=report.design(first),
        end=None if end is None else report.design(end),
        objective_history=tuple(report.objective(point) for point in history),
        violation_history=tuple(report.violation(point) for point in history),
        variable_history=tuple(report.variables(point.position) for point in history),
        constraint_history=tuple(report.constraints(point) for point in history),
        kkt_residual=float("inf") if conditions is None else conditions.residual,
        failures=failures,
        iterations=iterations,
        message=message,
    )


def constraint_reports(
    evaluator: Evaluator, sign: float, end: Point, conditions: Optimality | None, tolerance: float
) -> tuple[ConstraintReport, ...]:
    """All constraint rows at a point, margins last, with multipliers in SI units."""
    rows = evaluator.rows
    values = end.values[rows.index]
    reports = []
    for i, name in enumerate(rows.names):
        low, high, value = float(rows.lower[i]), float(rows.upper[i]), float(values[i])
        active = conditions is not None and conditions.active[i] != 0
        if active and conditions is not None:
            limit = high if conditions.active[i] > 0 else low
        else:
            limit = low if abs(value - low) < abs(value - high) else high
            limit = limit if np.isfinite(limit) else low
        price = 0.0 if conditions is None else float(conditions.multipliers[i])
        room = tolerance * evaluator.row_scale[i]
        equality = bool(rows.equality[i])
        reports.append(
            ConstraintReport(
                name=name,
                unit=rows.units[i],
                value=value,
                lower=None if equality or not np.isfinite(low) else low,
                upper=None if equality or not np.isfinite(high) else high,
                equal=low if equality else None,
                limit=limit,
                active=bool(active),
                satisfied=bool(low - room <= value <= high + room),
                multiplier=float(sign * price * evaluator.cost_scale / evaluator.row_scale[i]),
            )
        )
    return tuple(reports)


def _findings(
    mechanism: Mechanism, optimised: Mechanism, present: dict[str, float]
) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """Findings of `check` at the start and at the optimum."""
    if optimised is mechanism:
        findings = check(mechanism)
        return findings, findings
    # Variables are set as in the optimum: one structure, so one compiled program.
    return check(set_parameters(mechanism, present, checked=False)), check(optimised)


def optimum_of(
    mechanism: Mechanism,
    problem: DesignProblem,
    method: str,
    evaluator: Evaluator,
    report: Reporter,
    initial: np.ndarray,
    runs: tuple[Run, ...],
    best: int,
    end: Point,
    conditions: Optimality | None,
    tolerance: float,
) -> Optimum:
    """The complete result: the optimum, its constraints and bounds, and the verdict in words."""
    names = [variable.name for variable in problem.variables]
    reports = constraint_reports(evaluator, report.sign, end, conditions, tolerance)
    explicit, margins = reports[: evaluator.rows.explicit], reports[evaluator.rows.explicit :]
    residual = float("inf") if conditions is None else conditions.residual
    fixed = evaluator.margins.fixed
    feasible = conditions is not None and not fixed and evaluator.violation(end) <= tolerance
    converged = feasible and residual <= tolerance
    bounds, prices = {}, {}
    if conditions is not None:
        for i, name in enumerate(names):
            if conditions.active_bounds[i]:
                bounds[name] = "upper" if conditions.active_bounds[i] > 0 else "lower"
                price = conditions.bound_multipliers[i] * evaluator.cost_scale
                prices[name] = float(report.sign * price / evaluator.width[i])
    design = report.design(end)
    optimised = mechanism
    if conditions is not None:
        optimised = set_parameters(mechanism, design.variables, checked=False)
    before, after = _findings(mechanism, optimised, report.variables(initial))
    if conditions is None:
        message = f"none of {len(runs)} starts reached a usable design: {runs[0].message}"
    elif fixed:
        named = ", ".join(dict.fromkeys(row.label for row, _ in fixed))
        message = f"no feasible design found: none of the variables changes the error {named}"
    elif not feasible:
        broken = "; ".join(
            against_limit(r.name, r.unit, r.value, r.limit) for r in reports if not r.satisfied
        )
        message = f"no feasible design found; the design of least violation has {broken}"
    elif converged:
        message = f"KKT residual {residual:.1e} <= {tolerance:.1e}"
    else:
        message = (
            f"feasible, but the KKT residual is {residual:.1e} > {tolerance:.1e}; "
            f"message of the search: {runs[best].message}"
        )
    return Optimum(
        mechanism=optimised,
        problem=problem,
        method=method,
        start=report.design(evaluator.point(initial)),
        optimum=design,
        constraints=explicit,
        margins=margins,
        feasible=bool(feasible),
        findings_start=before,
        findings_optimum=after,
        bounds_active=bounds,
        bound_multipliers=prices,
        converged=bool(converged),
        kkt_residual=residual,
        stationarity=float("inf") if conditions is None else conditions.stationarity,
        message=message,
        runs=runs,
        best_run=best,
        evaluations=evaluator.evaluations,
        derivative_evaluations=evaluator.derivative_evaluations,
        variable_units={name: find_parameters(mechanism, name)[0].unit for name in names},
        objective_unit=find_quantity(problem.objectives[0].quantity).unit,
    )
