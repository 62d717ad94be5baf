"""Summary of an optimisation: designs before and after, limits, and active constraints."""

import dataclasses
from dataclasses import dataclass

from ...mechanism import what_follows
from ...optimisation import ConstraintReport, Optimum
from ...quantities import find_quantity
from ...text import MINUS, fixed, is_efficiency, number, show, with_label
from .._style import readable
from ._optimisation_chart import limit_use


@dataclass(frozen=True)
class Change:
    """A number before and after [SI]; bounds where it is a design variable."""

    name: str
    unit: str
    before: float
    after: float
    lower: float | None = None
    upper: float | None = None
    #: `"lower"` or `"upper"` where the value after lies on that bound.
    at_bound: str = ""
    #: For a design variable: parameters that change with it, and parameters that stay constant.
    follows: tuple[str, ...] = ()
    stays: tuple[str, ...] = ()


@dataclass(frozen=True)
class Limit:
    """A constraint at the optimum [SI]; `sense` is `"upper"`, `"lower"` or `"equal"`."""

    quantity: str
    unit: str
    value: float
    limit: float
    active: bool
    sense: str
    #: Change of the best objective for each unit by which the limit is raised [SI].
    multiplier: float = 0.0

    @property
    def use(self) -> float:
        """Share of the limit that is used, 1 at the limit."""
        return limit_use(self.value, self.limit, self.sense != "lower")


@dataclass(frozen=True)
class Optimisation:
    """Changes by an optimisation, its results and its convergence."""

    #: Name of the objective and its unit; the first of `quantities` is its value.
    objective: str
    objective_unit: str
    #: Objective by iteration, the start first.
    history: tuple[float, ...]
    variables: tuple[Change, ...]
    quantities: tuple[Change, ...]
    limits: tuple[Limit, ...]
    converged: bool
    #: First-order optimality; 0 at an exact optimum. `None` if it is not known.
    kkt_residual: float | None = None
    message: str = ""
    #: Largest relative violation of a limit by iteration; empty if it is not known.
    violations: tuple[float, ...] = ()
    #: False if the best design found violates a limit.
    feasible: bool = True

    @property
    def active(self) -> tuple[str, ...]:
        """Active limits and bounds at the optimum, in words."""
        constraints = [
            f"{readable(c.quantity)} at {show(c.limit, c.unit, c.quantity)}"
            for c in self.limits
            if c.active
        ]
        constraints += [
            f"{readable(v.name)} at its {v.at_bound} bound of {show(v.after, v.unit)}"
            for v in self.variables
            if v.at_bound
        ]
        return tuple(constraints)

    def in_a_sentence(self) -> str:
        """The result of the optimisation in one sentence."""
        if not self.feasible:
            why = self.message.removeprefix("no feasible design found").lstrip(";: ")
            return f"No feasible design: {why or 'limits are violated'}."
        main = self.quantities[0]
        verb = "rises" if main.after > main.before else "falls"
        change = (
            f"{readable(main.name).capitalize()} {verb} from "
            f"{show(main.before, main.unit, main.name)} to "
            f"{show(main.after, main.unit, main.name)}"
        )
        if main.after == main.before:
            change = f"{readable(main.name).capitalize()} is unchanged"
        if not self.converged:
            return (
                f"{change}; the search stopped before it converged, so a better design may be "
                "possible."
            )
        if self.active:
            words = self.active
            if len(words) == 1:
                return (
                    f"{change}. The active limit is {words[0]}: more is possible only if it is "
                    "relaxed."
                )
            return (
                f"{change}. The active limits are {', '.join(words[:-1])} and {words[-1]}: more is "
                "possible only if one of them is relaxed."
            )
        return f"{change}; no limit is active, so the optimum lies inside the permitted range."


def summarise_optimisation(optimum: Optimum) -> Optimisation:
    """Collect the summary of an optimisation for a report.

    **Arguments:**

    - `optimum`: result of `optimise`.
    """
    problem, start, end = optimum.problem, optimum.start, optimum.optimum
    terms = problem.objectives
    single = terms[0] if len(terms) == 1 else None
    scale = 1.0 if single is None else 1 / single.weight
    objective = "objective" if single is None else single.quantity
    unit = "1" if single is None else find_quantity(single.quantity).unit
    best = optimum.runs[optimum.best_run]
    names = [variable.name for variable in problem.variables]
    quantities = [
        Change(c.name, c.unit, start.constraints[c.name], c.value)
        for c in optimum.constraints
        if c.name != objective
    ]
    # Errors of `check` limit a design as much as the constraints of the problem.
    margins = [
        dataclasses.replace(margin, name=f"check: {margin.name}")
        for margin in optimum.margins
        if margin.active or not margin.satisfied
    ]
    quantities += [
        Change(m.name, m.unit, start.margins[m.name.removeprefix("check: ")], m.value)
        for m in margins
    ]
    return Optimisation(
        objective=objective,
        objective_unit=unit,
        history=tuple(scale * float(v) for v in optimum.objective_history),
        violations=tuple(float(v) for v in best.violation_history),
        variables=tuple(
            Change(
                v.name,
                optimum.variable_units[v.name],
                start.variables[v.name],
                end.variables[v.name],
                v.lower,
                v.upper,
                optimum.bounds_active.get(v.name, ""),
                *what_follows(optimum.mechanism, v.name, names),
            )
            for v in problem.variables
        ),
        quantities=(
            Change(objective, unit, scale * start.objective, scale * end.objective),
            *quantities,
        ),
        limits=tuple(_limit(c, scale) for c in (*optimum.constraints, *margins)),
        converged=optimum.converged,
        kkt_residual=optimum.kkt_residual,
        message=optimum.message,
        feasible=optimum.feasible,
    )


def _limit(report: ConstraintReport, scale: float) -> Limit:
    sense = "upper" if report.limit == report.upper else "lower"
    return Limit(
        quantity=report.name,
        unit=report.unit,
        value=report.value,
        limit=report.limit,
        active=report.active,
        sense=sense if report.equal is None else "equal",
        multiplier=scale * report.multiplier,
    )


def signed_change(quantity: str, unit: str, difference: float) -> str:
    """A difference of a quantity with its sign; for an efficiency in percentage points."""
    if unit == "1" and is_efficiency(quantity):
        text = f"{number(100 * abs(difference), 3)} points"
    else:
        text = show(abs(difference), unit, digits=3)
    return ("+" if difference > 0 else MINUS) + text


def relative_change(change: Change) -> str:
    """Change of a number in per cent, or in percentage points for an efficiency."""
    if is_efficiency(change.name):
        if min(change.before, change.after) < 0:
            # A self-locking thread has no efficiency, so there is no difference.
            return ""
        return signed_change(change.name, change.unit, change.after - change.before)
    if change.before == 0:
        return ""
    return with_label(fixed(100 * (change.after / change.before - 1), 2, "+"), "%", " ")
