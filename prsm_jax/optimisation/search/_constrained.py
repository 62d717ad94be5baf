"""Searches under constraints, with SciPy and exact derivatives."""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from ..._errors import missing_extra
from ._evaluator import Guarded
from ._search import SearchResult

#: SLSQP's line search can end too early; a restart with a fresh Hessian continues.
_RESTARTS = 3
#: Cost decrease below which a search stops: far below the tolerance of the optimality check.
_COST_TOLERANCE = 1e-15


def _scipy():
    try:
        import scipy.optimize
    except ImportError as error:
        raise missing_extra("optimise", "constrained optimisation", error) from error
    return scipy.optimize


def slsqp(
    functions: Guarded,
    start: np.ndarray,
    tolerance: float,
    maximum: int,
    report: Callable[[np.ndarray], None],
) -> SearchResult:
    """Sequential least squares programming (Kraft 1988)."""
    optimize = _scipy()
    evaluator = functions.evaluator
    rows = evaluator.rows
    lower, upper = evaluator.scaled_limits
    equal = rows.equality
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
    for _ in range(1 + _RESTARTS):
        result = optimize.minimize(
            functions.cost,
            position,
            jac=functions.gradient,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * len(start),
            constraints=constraints,
            callback=lambda iterate: report(np.clip(iterate, 0.0, 1.0)),
            options={"maxiter": max(maximum - iterations, 1), "ftol": _COST_TOLERANCE},
        )
        moved = np.clip(result.x, 0.0, 1.0)
        iterations += int(result.nit)
        message = str(result.message)
        settled = np.max(np.abs(moved - position)) <= tolerance
        # With contradictory linearised constraints (status 4) a restart changes nothing.
        position = moved
        if settled or result.status == 4 or iterations >= maximum:
            break
    return SearchResult(position, message, iterations)


def trust_constr(
    functions: Guarded,
    start: np.ndarray,
    tolerance: float,
    maximum: int,
    report: Callable[[np.ndarray], None],
) -> SearchResult:
    """Trust-region interior point method (Byrd, Hribar and Nocedal 1999), finished by SLSQP.

    The interior point method regards any point of its central path as stationary and then
    approaches active limits slowly; a few steps of an active-set method reach them.
    """
    optimize = _scipy()
    evaluator = functions.evaluator
    lower, upper = evaluator.scaled_limits
    zeros = np.zeros(len(start))
    constraints = []
    if len(lower):
        constraints.append(
            optimize.NonlinearConstraint(
                functions.constraint_values,
                lower,
                upper,
                jac=functions.constraint_jacobian,  # type: ignore[arg-type]
                hess=optimize.BFGS(),
            )
        )

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
            constraints=constraints,
            callback=callback,
            options={"maxiter": maximum, "gtol": tolerance / 10, "xtol": 1e-12},
        )
    end = slsqp(functions, np.clip(result.x, 0.0, 1.0), tolerance, maximum, report)
    return SearchResult(
        end.position, f"{result.message} Then: {end.message}", int(result.nit) + end.iterations
    )
