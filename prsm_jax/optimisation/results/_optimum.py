"""The result of an optimisation: start, optimum, history and optimality."""

import math
from dataclasses import dataclass, field
from typing import Any

from ...geometry import Finding
from ...mechanism import DesignProblem, Mechanism
from ...results import Shown
from ._printing import text_of


@dataclass(frozen=True)
class Design:
    """One design: its variables, objective and constrained quantities [SI].

    `usable` is false where it fails (no meshing, a value that is not finite); `violation` is the
    largest violation of a constraint, over its larger limit (at a limit of 0 over the magnitude of
    the quantity).
    """

    variables: dict[str, float]
    objective: float
    constraints: dict[str, float]
    usable: bool
    violation: float
    #: Margins of findings that depend on the variables [SI], by finding and stage.
    margins: dict[str, float] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON; `None` where one is not finite."""
        return {
            "variables": {name: _plain(value) for name, value in self.variables.items()},
            "objective": _plain(self.objective),
            "constraints": {name: _plain(value) for name, value in self.constraints.items()},
            "margins": {name: _plain(value) for name, value in self.margins.items()},
            "usable": self.usable,
            "violation": _plain(self.violation),
        }


@dataclass(frozen=True)
class ConstraintReport:
    """A constraint at the optimum [SI].

    `limit` is the active limit, or the nearest if none is active. `multiplier` is the change of
    the best objective per unit increase of that limit.
    """

    name: str
    unit: str
    value: float
    lower: float | None
    upper: float | None
    equal: float | None
    limit: float
    active: bool
    satisfied: bool
    multiplier: float

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON."""
        numbers = ("value", "limit", "lower", "upper", "equal", "multiplier")
        return {
            "quantity": self.name,
            "unit": self.unit,
            **{name: _plain(getattr(self, name)) for name in numbers},
            "active": self.active,
            "satisfied": self.satisfied,
        }


@dataclass(frozen=True)
class Run:
    """The search from one start; histories have one entry per iterate, the start included."""

    start: Design
    #: `None` if no usable design was reached.
    end: Design | None
    objective_history: tuple[float, ...]
    #: Largest violation of a constraint in scaled units: over its larger limit, or its magnitude.
    violation_history: tuple[float, ...]
    #: Values of the variables [SI].
    variable_history: tuple[dict[str, float], ...]
    #: Values of the constrained quantities [SI].
    constraint_history: tuple[dict[str, float], ...]
    kkt_residual: float
    #: Number of failed designs, from which the search stepped back.
    failures: int
    iterations: int
    message: str

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON."""
        return {
            "start": self.start.to_dict(),
            "end": None if self.end is None else self.end.to_dict(),
            "objective_history": [_plain(value) for value in self.objective_history],
            "violation_history": [_plain(value) for value in self.violation_history],
            "kkt_residual": _plain(self.kkt_residual),
            "failures": self.failures,
            "iterations": self.iterations,
            "message": self.message,
        }


@dataclass(frozen=True)
class Trial:
    """One combination of choices [SI]: its best design, or why it was dropped."""

    choices: dict[str, float]
    #: `None` if the mechanism cannot be built.
    variables: dict[str, float] | None
    objective: float | None
    #: `"best"`, `"worse"`, `"infeasible"` or `"cannot be built"`.
    status: str
    message: str
    kkt_residual: float

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON; `None` where one is not finite."""
        variables = None
        if self.variables is not None:
            variables = {name: _plain(value) for name, value in self.variables.items()}
        return {
            "choices": dict(self.choices),
            "variables": variables,
            "objective": _plain(self.objective),
            "status": self.status,
            "message": self.message,
            "kkt_residual": _plain(self.kkt_residual),
        }


@dataclass(frozen=True, repr=False)
class Optimum(Shown):
    """The best feasible design that was found; prints itself.

    `feasible` means: every constraint and every error limit of `check` is satisfied, and with
    `avoid_warnings` every warning limit that is a constraint.
    `converged` means: feasible, and `kkt_residual` (stationarity, violation and complementarity in
    scaled units, from exact gradients and independent of the method) within the tolerance.
    """

    #: The optimised mechanism, a pytree like the given one.
    mechanism: Mechanism
    problem: DesignProblem
    method: str
    #: The present design, which may lie outside the bounds.
    start: Design
    optimum: Design
    constraints: tuple[ConstraintReport, ...]
    #: Variables at a bound: `"lower"` or `"upper"`.
    bounds_active: dict[str, str]
    #: Change of the best objective per unit increase of the active bound [SI].
    bound_multipliers: dict[str, float]
    converged: bool
    kkt_residual: float
    stationarity: float
    message: str
    runs: tuple[Run, ...]
    #: Index of the run that found the optimum.
    best_run: int
    evaluations: int
    derivative_evaluations: int
    variable_units: dict[str, str]
    #: SI unit of the objective, where it is one quantity.
    objective_unit: str = "1"
    #: Margins of `check` that depend on the variables: constraints that the
    #: problem does not name.
    margins: tuple[ConstraintReport, ...] = ()
    #: False if no design satisfies every constraint and margin; `optimum` is then the best found.
    feasible: bool = True
    #: Findings of `check` at the start and at the optimum.
    findings_start: tuple[Finding, ...] = ()
    findings_optimum: tuple[Finding, ...] = ()
    #: Every combination of choices that was tried, where the problem has choices. `start` then is
    #: the present design with the choices of the best, and evaluations count all combinations.
    choices: tuple[Trial, ...] = ()

    @property
    def objective_history(self) -> tuple[float, ...]:
        """Objective along the best run."""
        return self.runs[self.best_run].objective_history

    @property
    def violated(self) -> tuple[str, ...]:
        """Names of the constraints and margins that the optimum violates."""
        reports = (*self.constraints, *self.margins)
        return tuple(report.name for report in reports if not report.satisfied)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON; `None` where one is not finite."""
        return {
            "start": self.start.to_dict(),
            "optimum": self.optimum.to_dict(),
            "objective": [
                {"quantity": term.quantity, "sense": term.sense, "weight": term.weight}
                for term in self.problem.objectives
            ],
            "objective_history": [_plain(value) for value in self.objective_history],
            "constraints": [report.to_dict() for report in self.constraints],
            "margins": [report.to_dict() for report in self.margins],
            "feasible": self.feasible,
            "findings_start": [_finding_entry(finding) for finding in self.findings_start],
            "findings_optimum": [_finding_entry(finding) for finding in self.findings_optimum],
            "bounds_active": dict(self.bounds_active),
            "bound_multipliers": {k: _plain(v) for k, v in self.bound_multipliers.items()},
            "converged": self.converged,
            "kkt_residual": _plain(self.kkt_residual),
            "stationarity": _plain(self.stationarity),
            "method": self.method,
            "message": self.message,
            "evaluations": self.evaluations,
            "derivative_evaluations": self.derivative_evaluations,
            "best_run": self.best_run,
            "runs": [run.to_dict() for run in self.runs],
            "variable_units": dict(self.variable_units),
        } | ({"choices": [one.to_dict() for one in self.choices]} if self.choices else {})

    def text(self, width: int | None = None) -> str:
        """Start and optimum as a table in an engineer's units, and the verdict.

        **Arguments:**

        - `width`: number of characters in a line; default as many as the table needs.
        """
        return text_of(self, width)

    def __str__(self) -> str:
        return self.text()


def _plain(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)


def _finding_entry(finding: Finding) -> dict[str, Any]:
    keys = ("name", "severity", "stage", "value", "limit", "message")
    entry = {key: getattr(finding, key) for key in keys}
    return entry | {key: _plain(entry[key]) for key in ("value", "limit")}
