"""Searches under constraints, with SciPy and exact derivatives."""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._optimality import optimality
from ._functions import SearchFunctions
from ._method import Report, SearchResult, WithOptions, check_at_least

#: Cost decrease below which a search stops: far below the tolerance of the optimality check.
COST_TOLERANCE = 1e-15
#: Step below which a search stops, in units of the box.
STEP_TOLERANCE = 1e-12


def nonlinear_constraints(functions: SearchFunctions) -> list[Any]:
    """All constraints as one `NonlinearConstraint` of SciPy, or none."""
    from scipy import optimize

    lower, upper = functions.limits
    if not len(lower):
        return []
    return [
        optimize.NonlinearConstraint(
            functions.constraint_values,
            lower,
            upper,
            jac=functions.constraint_jacobian,  # type: ignore[arg-type]
            hess=optimize.BFGS(),
        )
    ]


class _Optimal(Exception):
    """Ends a search at an optimum."""


def _residual(functions: SearchFunctions, position: np.ndarray, tolerance: float) -> float:
    """Karush–Kuhn–Tucker residual at a position; infinite where the design fails."""
    if not functions.usable(position):
        return np.inf
    lower, upper = functions.limits
    values, jacobian = np.zeros(0), np.zeros((0, len(position)))
    if len(lower):
        values = functions.constraint_values(position)
        jacobian = functions.constraint_jacobian(position)
    conditions = optimality(
        position,
        functions.gradient(position),
        values,
        jacobian,
        lower,
        upper,
        active_tolerance=max(tolerance, 1e-9),
    )
    return conditions.residual


@dataclass(frozen=True)
class Slsqp(WithOptions):
    """Sequential least squares programming (Kraft 1988), by SciPy. Accepts constraints.

    It stops at the second iterate in succession whose Karush–Kuhn–Tucker residual is within the
    tolerance: after the first one, a step adds several digits. By its own criteria SciPy may go on
    for hundreds of steps as small as rounding.

    **Arguments:**

    - `restarts`: number of restarts with a new Hessian, because the line search can end too early.
    - `max_iterations`: per start, restarts included.

    **Raises:** `ValueError` for an option out of range, or one that the method does not take.
    """

    word = "slsqp"
    accepts_constraints = True
    restarts: int = 3
    max_iterations: int = 300

    def __post_init__(self) -> None:
        check_at_least(0, restarts=self.restarts)
        check_at_least(1, max_iterations=self.max_iterations)

    def search(
        self, functions: SearchFunctions, start: np.ndarray, tolerance: float, report: Report
    ) -> SearchResult:
        from scipy import optimize

        lower, upper = functions.limits
        equal, maximum = functions.equality, self.max_iterations
        has_lower, has_upper = ~equal & np.isfinite(lower), ~equal & np.isfinite(upper)

        def inequalities(position):
            values = functions.constraint_values(position)
            return np.concatenate([(values - lower)[has_lower], (upper - values)[has_upper]])

        def inequality_slopes(position):
            slopes = functions.constraint_jacobian(position)
            return np.concatenate([slopes[has_lower], -slopes[has_upper]])

        constraints: list[dict[str, Any]] = []
        if has_lower.any() or has_upper.any():
            constraints.append({"type": "ineq", "fun": inequalities, "jac": inequality_slopes})
        if equal.any():
            constraints.append(
                {
                    "type": "eq",
                    "fun": lambda position: (functions.constraint_values(position) - lower)[equal],
                    "jac": lambda position: functions.constraint_jacobian(position)[equal],
                }
            )
        position, iterations, message = start, 0, ""
        done = within = 0

        def look(iterate: np.ndarray) -> None:
            nonlocal position, done, within
            # Rounding may move an iterate out of the box.
            iterate, done = np.clip(iterate, 0.0, 1.0), done + 1
            report(iterate)
            within = within + 1 if _residual(functions, iterate, tolerance) <= tolerance else 0
            if within == 2:
                position = iterate
                raise _Optimal

        try:
            for _ in range(1 + self.restarts):
                result = optimize.minimize(
                    functions.cost,
                    position,
                    jac=functions.gradient,
                    method="SLSQP",
                    bounds=[(0.0, 1.0)] * len(start),
                    constraints=constraints,
                    callback=look,
                    options={"maxiter": max(maximum - iterations, 1), "ftol": COST_TOLERANCE},
                )
                moved = np.clip(result.x, 0.0, 1.0)
                done = iterations = iterations + int(result.nit)
                message = str(result.message)
                settled = np.max(np.abs(moved - position)) <= tolerance
                # With contradictory linearised constraints (status 4) a restart changes nothing.
                position = moved
                if settled or result.status == 4 or iterations >= maximum:
                    break
        except _Optimal:
            message, iterations = "KKT residual below tolerance", done
        return SearchResult(position, message, iterations)


@dataclass(frozen=True)
class TrustConstr(WithOptions):
    """Trust-region interior point method (Byrd, Hribar and Nocedal 1999), finished by SLSQP.

    Accepts constraints. The interior point method regards any point of its central path as
    stationary and then approaches active limits slowly; a few steps of an active-set method reach
    them.

    **Arguments:**

    - `max_iterations`: per start, of each of the two.

    **Raises:** `ValueError` for an option out of range, or one that the method does not take.
    """

    word = "trust-constr"
    accepts_constraints = True
    max_iterations: int = 3000

    def __post_init__(self) -> None:
        check_at_least(1, max_iterations=self.max_iterations)

    def search(
        self, functions: SearchFunctions, start: np.ndarray, tolerance: float, report: Report
    ) -> SearchResult:
        from scipy import optimize

        zeros, maximum = np.zeros(len(start)), self.max_iterations

        def callback(iterate, _state):
            report(np.clip(iterate, 0.0, 1.0))
            return False

        with warnings.catch_warnings():
            # SciPy warns that a linear quantity has no curvature to learn.
            warnings.filterwarnings("ignore", message="delta_grad == 0.0", category=UserWarning)
            result = optimize.minimize(
                functions.cost,
                np.clip(start, 1e-2, 1 - 1e-2),
                jac=functions.gradient,
                hess=optimize.BFGS(),
                method="trust-constr",
                # The barrier keeps iterates inside: outside the box a design may not exist.
                bounds=optimize.Bounds(zeros, zeros + 1, keep_feasible=True),  # type: ignore[arg-type]
                constraints=nonlinear_constraints(functions),
                callback=callback,
                options={"maxiter": maximum, "gtol": tolerance / 10, "xtol": STEP_TOLERANCE},
            )
        finish = Slsqp(max_iterations=maximum)
        end = finish.search(functions, np.clip(result.x, 0.0, 1.0), tolerance, report)
        return SearchResult(
            end.position, f"{result.message} Then: {end.message}", int(result.nit) + end.iterations
        )
