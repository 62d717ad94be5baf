"""Fit of parameters of a mechanism to measurements: searches, bounds, modes, and uncertainty."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from ..mechanism import Mechanism, find_parameters, of_one_known_design, set_parameters
from ..quantities import REASONS, find_quantity, quantity_of
from ._bounds import inside
from ._data_file import read_measurements
from ._losses import influence
from ._measurements import Measurements
from ._pairing import open_rows, paired
from ._problem import (
    CalibrationProblem,
    Solved,
    all_values,
    calibration_problem,
    solve_one,
    start_values,
)
from ._result import Calibration, FittedParameter, Residuals
from ._statistics import Statistics, statistics_of
from ._undetermined import undetermined

#: Largest number of fits with new pairs of modes, or with a new estimate of the scatter.
_ROUNDS = 10
#: The estimated scatter is final if its relative change is below this.
_SETTLED = 1e-3
#: A value is tried on its bound if its distance to the bound is less than this times its magnitude.
_NEAR = 2e-2
#: The other values then start inside of their bounds by this share: on a bound, the derivative of
#: the map is 0.
_FROM_BOUND = 1e-3
#: Median of |z| of a normal distribution, for a robust standard deviation.
_MEDIAN = 0.6744897501960817


@of_one_known_design
def calibrate(
    mechanism: Mechanism,
    data: Measurements | Mapping[str, Any] | str | Path,
    parameters: Iterable[str],
    *,
    standard_deviations: Mapping[str, float] | None = None,
    bounds: Mapping[str, Any] | None = None,
    loss: str = "squared",
    undetermined_limit: float = 0.5,
) -> Calibration:
    r"""Fit parameters to measured quantities by nonlinear least squares with exact derivatives.

    Minimises $\sum_i \rho(z_i)$ over the parameters, where $z_i$ is measured minus computed value
    over its standard deviation, by Levenberg–Marquardt (optimistix). The covariance of the fitted
    values is $s^2 (J^\top J)^{-1}$ with the Jacobian $J$ of $z$ and the scatter $s$ of the
    residuals; limits are those of Student's t at 95 %. These formulas hold where the model is
    linear over the scatter of the parameters.

    **Arguments:**

    - `mechanism`: the mechanism; its present numbers are the start.
    - `data`: `Measurements`, a mapping of columns [SI] (quantities of the catalogue, and numbers of
      the mechanism as conditions), the path of a CSV file, or the name of shipped example data.
    - `parameters`: names of the numbers to be fitted. A name without a stage sets the number in
      all stages.
    - `standard_deviations`: standard deviation of the measured values of each column [SI]; they
      weight the columns. By default each column is divided by its root mean square. The scatter
      follows from the residuals in either case.
    - `bounds`: (lower, upper) by parameter [SI], `None` for no bound. Physical limits, such as a
      friction coefficient of at least 0, hold anyway.
    - `loss`: `"squared"`; or robust, so that outliers count less: `"huber"`, `"soft_l1"`, or
      `"cauchy"`, for which the influence of distant ones falls towards 0. Without standard
      deviations a robust loss estimates them from the median of the absolute residuals.
    - `undetermined_limit`: relative standard deviation from which a combination of parameters is
      called undetermined.

    **Returns:** a `Calibration`. A search that fails is reported there (`code`, `message`).

    **Raises:** `FileError` for a wrong data file; `UnknownNameError` for unknown names;
    `ValueError` for a wrong argument, too few values, or parameters that determine each other;
    `MissingDataError` where the mechanism lacks data for a quantity.
    """
    if not undetermined_limit > 0:
        raise ValueError(f"undetermined_limit is {undetermined_limit}; it must be positive")
    if isinstance(data, str | Path):
        data = read_measurements(data, mechanism)
    elif not isinstance(data, Measurements):
        data = Measurements.from_columns(data)
    problem = calibration_problem(
        mechanism,
        data,
        parameters,
        standard_deviations=standard_deviations,
        bounds=bounds,
        loss=loss,
    )
    computed, codes = (np.asarray(array) for array in start_values(problem))
    if codes.any():
        reason = REASONS[int(codes[codes != 0][0])].replace("_", " ")
        message = (
            f"the mechanism cannot be computed at the start in {int((codes != 0).sum())} of "
            f"{len(codes)} conditions ({reason}); start from other values"
        )
        return _failed(mechanism, problem, data, "start_fails", message)
    rows = open_rows(problem, data)
    weighted = set(standard_deviations or {})
    problem, solved, free, settled = _fitted(problem, rows, computed, data, weighted)
    if not bool(solved.finite):
        message = "the computed values are not finite at the end of the search; set bounds"
        return _failed(mechanism, problem, data, "not_finite", message)
    code, message = "converged", _success(problem, solved)
    if not bool(solved.converged):
        code = "not_converged"
        message = (
            f"the search stopped after {int(solved.steps)} steps; set bounds, begin nearer, or fit "
            "fewer parameters"
        )
    elif not settled:
        code = "not_converged"
        message = (
            f"pairs of modes or the scatter still changed after {_ROUNDS} fits; number the modes "
            "in the data, or give standard deviations"
        )
    return _result(mechanism, problem, data, solved, free, code, message, undetermined_limit)


def _success(problem: CalibrationProblem, solved: Solved) -> str:
    count, values = len(problem.parameters), len(problem.measured)
    many = "s" if count > 1 else ""
    return f"{count} parameter{many} fitted to {values} values in {int(solved.steps)} steps"


def _fitted(
    problem: CalibrationProblem,
    rows: dict[str, np.ndarray],
    computed: np.ndarray,
    data: Measurements,
    weighted: set[str],
) -> tuple[CalibrationProblem, Solved, np.ndarray, bool]:
    """Fits until pairs of modes and the estimated scatter no longer change."""
    estimate_scatter = problem.loss != "squared" and not set(data.values) <= weighted
    solved, free, start = None, np.ones(len(problem.parameters), bool), problem.start
    for _ in range(_ROUNDS):
        before = problem
        if rows:
            problem = paired(problem, rows, computed)
        if estimate_scatter and solved is not None:
            problem = _rescaled(problem, solved, data, weighted)
        if solved is not None and _same(before, problem):
            return problem, solved, free, True
        solved, free = _within_bounds(problem, start)
        if not (rows or estimate_scatter) or not bool(solved.finite):
            return problem, solved, free, True
        computed = np.asarray(all_values(problem, solved.values))
    assert solved is not None
    return problem, solved, free, False


def _same(one: CalibrationProblem, other: CalibrationProblem) -> bool:
    pairs = np.array_equal(np.asarray(one.component), np.asarray(other.component))
    return pairs and np.allclose(np.asarray(one.scale), np.asarray(other.scale), rtol=_SETTLED)


def _rescaled(
    problem: CalibrationProblem, solved: Solved, data: Measurements, weighted: set[str]
) -> CalibrationProblem:
    """The problem with the scatter of each column from the median of its absolute residuals."""
    scale = np.array(problem.scale)
    residuals = np.abs(np.asarray(solved.residuals)) * scale
    for name, of_column in _rows_of(data).items():
        if name in weighted:
            continue
        middle = float(np.median(residuals[of_column])) / _MEDIAN
        if middle > 1e-12 * float(np.abs(np.asarray(problem.measured)[of_column]).max()):
            scale[of_column] = middle
    return eqx.tree_at(lambda p: p.scale, problem, jnp.asarray(scale, problem.scale.dtype))


def _rows_of(data: Measurements) -> dict[str, np.ndarray]:
    """Rows of the problem that belong to each measured column."""
    rows, first = {}, 0
    for name, column in data.values.items():
        count = int(np.isfinite(np.asarray(column)).sum())
        rows[name] = np.arange(first, first + count)
        first += count
    return rows


def _within_bounds(problem: CalibrationProblem, start) -> tuple[Solved, np.ndarray]:
    """A fit. A value near a bound is set on it if the sum of losses still falls beyond the bound.

    Near a bound the search by the smooth map is slow. With this value on the bound, the search
    finds the other values exactly.
    """
    names = len(problem.parameters)
    free = np.ones(names, bool)
    fixed = np.asarray(problem.start)
    solved = solve_one(problem, problem.measured, jnp.asarray(free), jnp.asarray(fixed), start)
    lower, upper = np.asarray(problem.lower), np.asarray(problem.upper)
    values, size = np.asarray(solved.values), np.asarray(problem.magnitude)
    at_lower, at_upper = values - lower < _NEAR * size, upper - values < _NEAR * size
    near = at_lower | at_upper
    if not near.any() or not np.isfinite(values).all():
        return solved, free
    bound = np.where(at_lower, lower, upper)
    inner = inside(values, lower, upper, size, _FROM_BOUND)
    while near.any():
        again = solve_one(
            problem,
            problem.measured,
            jnp.asarray(~near),
            jnp.asarray(np.where(near, bound, values)),
            jnp.asarray(inner),
        )
        slope = _slope(problem, again)
        # On a lower bound the sum must rise with the value; on an upper bound it must fall.
        leaves = near & np.where(at_lower, slope < 0, slope > 0)
        if not bool(again.finite):
            break
        if not leaves.any():
            better = float(again.cost) <= float(solved.cost) * (1 + 1e-6) + 1e-30
            return (again, ~near) if better else (solved, free)
        near = near & ~leaves
    return solved, free


def _slope(problem: CalibrationProblem, solved: Solved) -> np.ndarray:
    """Derivative of the sum of losses by each scaled value (value over its magnitude)."""
    first, _ = influence(np.asarray(solved.residuals), problem.loss)
    return -np.asarray(solved.jacobian).T @ first


def _result(
    mechanism: Mechanism,
    problem: CalibrationProblem,
    data: Measurements,
    solved: Solved,
    free: np.ndarray,
    code: str,
    message: str,
    limit: float,
) -> Calibration:
    names, units = problem.parameters, _units(mechanism, problem.parameters)
    values, size = np.asarray(solved.values, float), np.asarray(problem.magnitude)
    # Relative to the fitted values, because the sentences on combinations are in per cent.
    share = np.where(np.abs(values) > 1e-3 * size, np.abs(values), size)
    jacobian = np.asarray(solved.jacobian) * (share / size)
    statistics = statistics_of(jacobian[:, free], np.asarray(solved.residuals), problem.loss)
    deviations = np.full(len(names), np.nan)
    deviations[free] = statistics.deviations * share[free]
    lower, upper = np.asarray(problem.lower), np.asarray(problem.upper)
    low = np.maximum(values - statistics.student * deviations, lower)
    high = np.minimum(values + statistics.student * deviations, upper)
    start = _start(mechanism, names)
    fitted = tuple(
        FittedParameter(
            name,
            units[i],
            start[i],
            float(values[i]),
            float(deviations[i]),
            float(low[i]),
            float(high[i]),
            "" if free[i] else "lower" if values[i] == lower[i] else "upper",
        )
        for i, name in enumerate(names)
    )
    calibrated = set_parameters(
        mechanism, dict(zip(names, map(float, values), strict=True)), checked=False
    )
    chosen = np.flatnonzero(free)
    return Calibration(
        mechanism=calibrated,
        parameters=fitted,
        correlation=_correlation(statistics, free),
        residual_rms=float(np.sqrt(np.mean(np.asarray(solved.residuals) ** 2))),
        undetermined=undetermined(
            tuple(names[i] for i in chosen),
            tuple(units[i] for i in chosen),
            share[chosen],
            statistics,
            limit,
        ),
        residuals=_residuals(problem, solved),
        scales=_scales(problem, data),
        loss=problem.loss,
        degrees_of_freedom=statistics.freedom,
        code=code,
        message=message,
        steps=int(solved.steps),
    )


def _start(mechanism: Mechanism, names: tuple[str, ...]) -> list[float]:
    return [float(find_parameters(mechanism, name)[0].get(mechanism)) for name in names]


def _units(mechanism: Mechanism, names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(find_parameters(mechanism, name)[0].unit for name in names)


def _scales(problem: CalibrationProblem, data: Measurements) -> dict[str, float]:
    scale = np.asarray(problem.scale)
    return {name: float(scale[rows[0]]) for name, rows in _rows_of(data).items()}


def _correlation(statistics: Statistics, free: np.ndarray) -> np.ndarray:
    correlation = np.full((len(free), len(free)), np.nan)
    deviations = statistics.deviations
    with np.errstate(invalid="ignore", divide="ignore"):
        inner = statistics.covariance / np.outer(deviations, deviations)
    inner = np.where(np.isfinite(np.outer(deviations, deviations)), inner, np.nan)
    inner[np.diag_indices_from(inner)] = 1.0
    correlation[np.ix_(free, free)] = inner
    return correlation


def _residuals(problem: CalibrationProblem, solved: Solved) -> tuple[Residuals, ...]:
    measured, scale = np.asarray(problem.measured), np.asarray(problem.scale)
    computed = measured - np.asarray(solved.residuals) * scale
    labels = np.array(problem.components)[np.asarray(problem.component)]
    quantity = np.array([quantity_of(label).name for label in labels])
    point = np.asarray(problem.point)
    return tuple(
        Residuals(
            name,
            find_quantity(name).unit,
            tuple(labels[quantity == name].tolist()),
            measured[quantity == name],
            computed[quantity == name],
            {n: np.asarray(c)[point][quantity == name] for n, c in problem.conditions.items()},
        )
        for name in problem.quantities
    )


def _failed(
    mechanism: Mechanism, problem: CalibrationProblem, data: Measurements, code: str, message: str
) -> Calibration:
    """A result without fitted values: the start, and the reason."""
    names, units = problem.parameters, _units(mechanism, problem.parameters)
    nan, start = float("nan"), _start(mechanism, names)
    return Calibration(
        mechanism=mechanism,
        parameters=tuple(
            FittedParameter(name, units[i], start[i], nan, nan, nan, nan)
            for i, name in enumerate(names)
        ),
        correlation=np.full((len(names), len(names)), nan),
        residual_rms=nan,
        undetermined=(),
        residuals=(),
        scales=_scales(problem, data),
        loss=problem.loss,
        degrees_of_freedom=len(problem.measured) - len(names),
        code=code,
        message=message,
        steps=0,
    )
