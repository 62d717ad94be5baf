"""Tolerances of least total cost that reach a wanted yield."""

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..fields import Scalar, as_optional_scalar
from ..mechanism import Mechanism, Tolerance, find_parameters, of_one_known_design
from ..quantities import quantity_of
from ..results import Shown
from ..text import TextTable, display_unit
from ._inputs import Inputs, inputs_of
from ._limits import check_components, limits_of
from ._result import ToleranceAnalysis
from ._tolerance import derivatives, limit_of, tolerance

#: Widest and narrowest tolerance, relative to the given one.
WIDEST = 10.0


@dataclasses.dataclass(frozen=True, repr=False)
class Allocation(Shown):
    """Tolerances of least cost for a wanted yield.

    - `before`, `tolerances`: given and allocated tolerances, with their costs.
    - `units`: their SI units.
    - `wanted_yield`: share of mechanisms within all limits.
    - `yield_first_order`: yield from first-order standard deviations. With limits of several
      quantities the shares outside of each limit are added; for normal quantities this is a lower
      bound.
    - `verification`: Monte Carlo with the allocated tolerances.
    """

    before: tuple[Tolerance, ...]
    tolerances: tuple[Tolerance, ...]
    units: tuple[str, ...]
    wanted_yield: float
    yield_first_order: float
    verification: ToleranceAnalysis | None

    @property
    def cost_before(self) -> float:
        """Total cost of the given tolerances."""
        return sum(one.cost for one in self.before)

    @property
    def cost(self) -> float:
        """Total cost of the allocated tolerances."""
        return sum(one.cost for one in self.tolerances)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and lists [SI] for JSON."""
        best = None if self.verification is None else self.verification.best
        return {
            "wanted_yield": self.wanted_yield,
            "yield_first_order": self.yield_first_order,
            "yield_monte_carlo": None if best is None else best.yield_share,
            "yield_standard_error": None if best is None else best.yield_error,
            "cost_before": self.cost_before,
            "cost": self.cost,
            "tolerances": [
                {**dataclasses.asdict(one), "unit": unit}
                for one, unit in zip(self.tolerances, self.units, strict=True)
            ],
        }

    def __str__(self) -> str:
        return self.text()

    def text(self, width: int | None = None) -> str:
        """Given and allocated tolerances with their costs, and the yield.

        **Arguments:**

        - `width`: number of characters in a line; default as many as the table needs.
        """
        rows = []
        for old, new, unit in zip(self.before, self.tolerances, self.units, strict=True):
            shown = display_unit(unit, old.half_width)
            sides = [
                f"{float(shown(one.lower)):+.4g} to {float(shown(one.upper)):+.4g}"
                for one in (old, new)
            ]
            rows.append((shown.heading(old.name), *sides, old.cost, new.cost))
        columns = ("tolerance", "given", "allocated", "cost given", "cost allocated")
        words = TextTable("", columns, rows).text(width)
        words += f"\ncost {self.cost:.5g} in place of {self.cost_before:.5g}; yield wanted "
        words += (
            f"{100 * self.wanted_yield:.5g} %, first order {100 * self.yield_first_order:.5g} %"
        )
        best = None if self.verification is None else self.verification.best
        if best is not None and best.yield_share is not None and best.yield_error is not None:
            words += f", Monte Carlo {100 * best.yield_share:.5g} ± {100 * best.yield_error:.1g} %"
            if best.not_counted:
                words += (
                    f"\nof {best.samples} designs, those that fail or have an error are not "
                    f"within the limits: {', '.join(best.not_counted)}"
                )
        return words


@of_one_known_design
def allocate_tolerances(
    mechanism: Mechanism,
    wanted_yield: float,
    limits: Mapping[str, Any] | None = None,
    *,
    tolerances: Iterable[Tolerance] | None = None,
    samples: int = 4096,
    seed: int = 0,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    findings: bool = True,
    verify: bool = True,
) -> Allocation:
    r"""Widen and narrow tolerances so that a wanted yield costs least.

    The cost of a tolerance is inversely proportional to its width: $\sum_i c_i / s_i$, where $s_i$
    is the width relative to the given one (0.1 to 10, or less where the number would leave its
    range) and $c_i$ the cost of the given one. Zones keep their middle and distribution. For limits
    of one quantity the optimum has the closed form $s_i \propto (c_i / a_i^2)^{1/3}$, $a_i$ the
    standard deviation of the quantity due to tolerance $i$; for several quantities, or where a
    width reaches its bound, SLSQP finds it.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `wanted_yield`: share of mechanisms within all limits, between 0 and 1.
    - `limits`, `tolerances`, `samples`, `seed`, `speed`, `load`, `findings`: as for `tolerance`.
    - `verify`: whether to compute the yield by Monte Carlo, too.

    **Returns:** an `Allocation`.

    **Raises:** as `tolerance`; `ValueError` without limits, if no widths reach the yield, or if
    the search finds no optimum.
    """
    _check_yield(wanted_yield)
    inputs, problem = _problem_of(mechanism, wanted_yield, limits, tolerances, speed, load)
    widths = problem.solve()
    allocated = tuple(
        widened(one, width) for one, width in zip(inputs.tolerances, widths.tolist(), strict=True)
    )
    check = None
    if verify:
        check = tolerance(
            mechanism,
            limits=limits,
            method="monte_carlo",
            samples=samples,
            seed=seed,
            tolerances=allocated,
            speed=speed,
            load=load,
            findings=findings,
        )
    return Allocation(
        inputs.tolerances, allocated, inputs.units, wanted_yield, problem.share(widths), check
    )


@dataclasses.dataclass(frozen=True, repr=False)
class CostCurve(Shown):
    """Least cost of the tolerances for each of several yields.

    - `yields`: wanted shares of mechanisms within all limits.
    - `costs`: least cost for each; NaN where no tolerances reach the yield.
    - `given_yield`, `given_cost`: first-order yield and cost of the given tolerances.
    """

    yields: np.ndarray
    costs: np.ndarray
    given_yield: float
    given_cost: float

    def __str__(self) -> str:
        rows = [("given", self.given_yield, self.given_cost)]
        rows += [("least cost", *pair) for pair in zip(self.yields, self.costs, strict=True)]
        return TextTable("Cost of tolerances", ("", "yield", "cost"), rows).text().rstrip()


#: Yields of a cost curve.
_YIELDS = (0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.925, 0.95, 0.97, 0.98, 0.99, 0.995)


@of_one_known_design
def cost_curve(
    mechanism: Mechanism,
    yields: Iterable[float] = _YIELDS,
    limits: Mapping[str, Any] | None = None,
    *,
    tolerances: Iterable[Tolerance] | None = None,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
) -> CostCurve:
    """Least cost of the tolerances against the yield, as `allocate_tolerances` finds it.

    **Arguments:**

    - `mechanism`, `limits`, `tolerances`, `speed`, `load`: as for `allocate_tolerances`.
    - `yields`: shares of mechanisms within all limits, each between 0 and 1.

    **Returns:** a `CostCurve`.

    **Raises:** as `allocate_tolerances`, but not for a yield that no tolerances reach.
    """
    wanted = tuple(yields)
    for share in wanted:
        _check_yield(share)
    _, problem = _problem_of(mechanism, 0.5, limits, tolerances, speed, load)
    costs = []
    for share in wanted:
        try:
            widths = dataclasses.replace(problem, wanted=share).solve()
            costs.append(float(np.sum(problem.costs / widths)))
        except ValueError:
            costs.append(np.nan)
    ones = np.ones(len(problem.costs))
    return CostCurve(
        np.array(wanted), np.array(costs), problem.share(ones), float(problem.costs.sum())
    )


def _check_yield(wanted: float) -> None:
    if not 0 < wanted < 1:
        raise ValueError(f"wanted_yield is {wanted}; it must be between 0 and 1")


def _problem_of(
    mechanism: Mechanism, wanted_yield: float, limits, tolerances, speed, load
) -> "tuple[Inputs, _Problem]":
    """Slopes at the middle of the tolerances, and the problem of their widths."""
    inputs = inputs_of(mechanism, tolerances)
    bounds = limits_of(mechanism.design_problem, limits)
    if not bounds:
        raise ValueError("there are no limits; give limits, or constraints in the [optimise] table")
    selected = tuple(dict.fromkeys(map(quantity_of, bounds)))
    at = as_optional_scalar(speed), as_optional_scalar(load)
    check_components(inputs.mechanism, bounds, *at)
    values, slopes, _, code = derivatives(inputs, selected, at, False)
    if code:
        raise ValueError("the design in the middle of the tolerances fails; see `prsm check`")
    limited = [label for label in values if limit_of(label, bounds) is not None]
    middle = np.array([float(values[label]) for label in limited])
    sides = np.array([limit_of(label, bounds) for label in limited])
    for label, value, (low, high) in zip(limited, middle, sides, strict=True):
        if not low < value < high:
            raise ValueError(
                f"{label} is {value:.6g} in the middle of the tolerances and outside of its limits "
                f"{low:g} to {high:g}; no tolerances help, change the design"
            )
    parts = np.stack([slopes[label] for label in limited])
    # A quantity that no tolerance changes always lies within its limits here: it is left out.
    moves = (parts != 0).any(axis=1)
    parts, sides = parts[moves], sides[moves]
    costs = np.array([one.cost for one in inputs.tolerances])
    widest = np.array([widest_factor(mechanism, one) for one in inputs.tolerances])
    return inputs, _Problem(parts, sides - middle[moves, None], costs, wanted_yield, widest)


def widened(one: Tolerance, width: float) -> Tolerance:
    """A tolerance with its zone widened about the middle, and its cost."""
    return dataclasses.replace(
        one,
        lower=one.middle - one.half_width * width,
        upper=one.middle + one.half_width * width,
        cost=one.cost / width,
    )


def widest_factor(mechanism: Mechanism, one: Tolerance) -> float:
    """Greatest relative width, at most 10, at which the limits of a tolerance are possible."""

    def possible(width: float) -> bool:
        sides = (one.middle - width * one.half_width, one.middle + width * one.half_width)
        return all(
            parameter.limit.admits(float(np.asarray(parameter.get(mechanism))) + side)
            for parameter in find_parameters(mechanism, one.name)
            for side in sides
        )

    if possible(WIDEST):
        return WIDEST
    low, high = 1.0, WIDEST
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if possible(middle) else (low, middle)
    return low


@dataclasses.dataclass(frozen=True)
class _Problem:
    """Least cost over relative widths.

    - `parts`: standard deviation of each quantity due to each tolerance, quantities × tolerances;
      each row has a number other than 0.
    - `sides`: limits of each quantity less its value in the middle.
    - `costs`: cost of each given tolerance.
    - `wanted`: wanted yield.
    - `widest`: greatest relative widths.
    """

    parts: np.ndarray
    sides: np.ndarray
    costs: np.ndarray
    wanted: float
    widest: np.ndarray

    def share(self, widths: np.ndarray) -> float:
        """First-order yield: 1 less the shares outside of the limits of each quantity."""
        from scipy.special import ndtr

        deviation = np.sqrt(np.sum((self.parts * widths) ** 2, axis=1))
        low, high = self.sides[:, 0] / deviation, self.sides[:, 1] / deviation
        return float(1 - np.sum(1 - (ndtr(high) - ndtr(low))))

    def _slope(self, logarithms: np.ndarray) -> np.ndarray:
        """Derivative of the yield by the logarithms of the widths."""
        squares = (self.parts * np.exp(logarithms)) ** 2
        deviation = np.sqrt(squares.sum(axis=1))
        scaled = np.where(np.isfinite(self.sides), self.sides, 0.0) / deviation[:, None]
        weights = scaled * np.exp(-0.5 * scaled**2) / np.sqrt(2 * np.pi)
        return -((weights[:, 1] - weights[:, 0]) / deviation**2) @ squares

    def solve(self) -> np.ndarray:
        """Relative widths of least cost."""
        count = len(self.costs)
        if self.share(self.widest) >= self.wanted:
            return self.widest
        if self.share(np.full(count, 1 / WIDEST)) < self.wanted:
            raise ValueError(
                f"a yield of {self.wanted:g} needs tolerances of less than a tenth of the given "
                "ones; give narrower tolerances, wider limits, or change the design"
            )
        if len(self.parts) == 1 and (self.parts != 0).all():
            shape = (self.costs / self.parts[0] ** 2) ** (1 / 3)
            widths = shape * self._scale(shape)
            if (widths <= self.widest).all() and (widths >= 1 / WIDEST).all():
                return widths
        return self._searched()

    def _scale(self, shape: np.ndarray) -> float:
        """Factor on widths of a given shape at which the yield is the wanted one.

        The yield falls as the factor rises.
        """
        low, high = -60.0, 60.0
        for _ in range(80):
            middle = 0.5 * (low + high)
            if self.share(shape * np.exp(middle)) >= self.wanted:
                low = middle
            else:
                high = middle
        return float(np.exp(low))

    def _searched(self) -> np.ndarray:
        from scipy.optimize import minimize

        count, ends = len(self.costs), np.log(self.widest)
        least = -float(np.log(WIDEST))
        whole = float(np.sum(self.costs))
        start = np.clip(np.full(count, np.log(self._scale(np.ones(count)))), least, ends)
        least_cost = minimize(
            lambda x: (np.sum(self.costs * np.exp(-x)) / whole, -self.costs * np.exp(-x) / whole),
            start,
            jac=True,
            bounds=[(least, end) for end in ends],
            constraints=[
                {
                    "type": "ineq",
                    "fun": lambda x: self.share(np.exp(x)) - self.wanted,
                    "jac": self._slope,
                }
            ],
            method="SLSQP",
            options={"ftol": 1e-12, "maxiter": 500},
        )
        # SLSQP ends with status 8 where rounding errors hide a further descent at the optimum.
        if least_cost.status not in (0, 8):
            raise ValueError(
                "the search for the tolerances of least cost found no optimum: "
                f"{least_cost.message}; give fewer tolerances or limits"
            )
        widths = np.exp(least_cost.x)
        # Rounding in the search may leave the yield just short of the wanted one.
        return np.maximum(widths * min(self._scale(widths), 1.0), 1 / WIDEST)
