"""Methods of `scipy.optimize.minimize` that keep bounds, by SciPy's names and with its options."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ...fields import refuse_options
from ._constrained import COST_TOLERANCE, STEP_TOLERANCE, nonlinear_constraints
from ._functions import SearchFunctions
from ._method import Report, SearchResult, WithOptions, check_at_least


class _Support(NamedTuple):
    """What a method of SciPy supports, and its options."""

    constraints: bool
    derivatives: bool
    #: Names, separated by spaces.
    options: str
    #: Options by the tolerance of the search, where the caller gives none.
    defaults: Callable[[float], dict[str, float]]
    iterations: str = "maxiter"


_METHODS = {
    "SLSQP": _Support(True, True, "ftol", lambda _: {"ftol": COST_TOLERANCE}),
    "COBYQA": _Support(
        True,
        False,
        "initial_tr_radius final_tr_radius feasibility_tol f_target maxfev",
        # The largest trust region within the box.
        lambda tolerance: {"initial_tr_radius": 0.5, "final_tr_radius": tolerance},
    ),
    "L-BFGS-B": _Support(
        False,
        True,
        "maxcor ftol gtol maxfun maxls",
        lambda tolerance: {"ftol": COST_TOLERANCE, "gtol": tolerance},
    ),
    "TNC": _Support(
        False,
        True,
        "scale offset maxCGit eta stepmx accuracy minfev ftol xtol gtol rescale",
        lambda tolerance: {"ftol": COST_TOLERANCE, "xtol": STEP_TOLERANCE, "gtol": tolerance},
        iterations="maxfun",
    ),
    "Powell": _Support(
        False,
        False,
        "xtol ftol direc maxfev",
        lambda tolerance: {"xtol": tolerance, "ftol": COST_TOLERANCE},
    ),
}


@dataclass(frozen=True)
class Scipy(WithOptions):
    """A method of `scipy.optimize.minimize`, in units of the box.

    With constraints: SLSQP and, without derivatives, COBYQA. With bounds only: L-BFGS-B, TNC and,
    without derivatives, Powell. `TrustConstr` is SciPy's trust-constr.

    **Arguments:**

    - `method`: SciPy's name of it.
    - `options`: SciPy's options of this method, such as `{"initial_tr_radius": 0.1}`. Tolerances
      that are not given follow from that of the search.
    - `max_iterations`: per start; for TNC, evaluations of the cost.

    **Raises:** `ValueError` for another method, or for an option that the method does not take.
    """

    method: str
    options: Mapping[str, Any] = field(default_factory=dict, hash=False)
    max_iterations: int = 1000

    def __post_init__(self) -> None:
        check_at_least(1, max_iterations=self.max_iterations)
        if self.method not in _METHODS:
            raise ValueError(
                f"Scipy: method is {self.method!r}; choose one of {', '.join(_METHODS)}, or "
                "derive a search of your own from SearchMethod"
            )
        support = _METHODS[self.method]
        if support.iterations in self.options:
            raise ValueError(
                f"Scipy: {support.iterations} is given by max_iterations; leave it out of options"
            )
        refuse_options(f"Scipy({self.method!r})", self.options, support.options.split())
        object.__setattr__(self, "accepts_constraints", support.constraints)

    @property
    def name(self) -> str:
        """`"SciPy"` and SciPy's name of the method."""
        return f"SciPy {self.method}"

    def search(
        self, functions: SearchFunctions, start: np.ndarray, tolerance: float, report: Report
    ) -> SearchResult:
        support = _METHODS[self.method]
        defaults = {support.iterations: self.max_iterations, **support.defaults(tolerance)}
        from scipy.optimize import minimize

        minimum = minimize(
            functions.cost,
            start,
            method=self.method,
            jac=functions.gradient if support.derivatives else None,
            bounds=[(0.0, 1.0)] * len(start),
            constraints=nonlinear_constraints(functions) if support.constraints else (),
            callback=lambda iterate: report(np.clip(iterate, 0.0, 1.0)),
            options=defaults | dict(self.options),
        )
        return SearchResult(np.clip(minimum.x, 0.0, 1.0), str(minimum.message), int(minimum.nit))
