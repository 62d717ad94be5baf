"""Scatter and yield of quantities due to tolerances, and the contribution of each tolerance."""

from collections.abc import Iterable, Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np

from ..fields import Scalar, as_optional_scalar, listed_names
from ..findings import error_names, sources
from ..mechanism import Mechanism, Tolerance, of_one_known_design
from ..quantities import (
    REASONS,
    Quantity,
    QuantityLike,
    available_quantities,
    named_quantities,
    quantity_of,
)
from ._estimates import (
    Estimate,
    first_order,
    monte_carlo,
    quadratic,
    second_order,
    share_with_error,
    within,
)
from ._inputs import Inputs, inputs_of
from ._limits import Limits, check_components, limits_of
from ._programs import derivatives_along
from ._result import MethodResult, ToleranceAnalysis
from ._sampling import SCRAMBLINGS, Progress, by_component, evaluate_points, points
from ._zone_ends import zone_ends, zone_points

_METHODS = ("first_order", "second_order", "monte_carlo")
#: Quantities where no limits are given; without the quantities that the mechanism has no data for.
DEFAULT_QUANTITIES = ("efficiency", "drive_torque", "max_pressure", "axial_stiffness")
#: Points of the quadratic expansion, which costs no analyses.
_SURROGATE_SAMPLES = 16384
_FEWEST = 2 * SCRAMBLINGS


@of_one_known_design
def tolerance(
    mechanism: Mechanism,
    quantities: Iterable[QuantityLike] | None = None,
    limits: Mapping[Any, Any] | None = None,
    *,
    method: str = "all",
    samples: int = 4096,
    seed: int = 0,
    tolerances: Iterable[Tolerance] | None = None,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    findings: bool = True,
    progress: Progress = None,
) -> ToleranceAnalysis:
    """Scatter of quantities due to tolerances: mean, standard deviation, quantiles, yield.

    The yield is the share of mechanisms within limits. By Monte Carlo a mechanism counts only if
    it can be analysed and, with `findings`, has no error of `check`; first and second order
    consider only the limits. Both expand the quantities about the middle of the tolerance zones.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `quantities`: names from the catalogue, or functions of a mechanism; default those with
      limits, or else those of `DEFAULT_QUANTITIES` that the mechanism has the data for. Those with
      limits are added.
    - `limits`: (lower, upper) [SI] by the name of a quantity or of one of its components, such as
      `rating_life[2]`; `None` for no limit. They replace
      the limits of the same quantity in the mechanism's design problem; its others still hold.
    - `method`: `"first_order"` (from gradients), `"second_order"` (with all second derivatives),
      `"monte_carlo"` (scrambled Sobol points), or `"all"`.
    - `samples`: designs of Monte Carlo, rounded up to 8 scramblings of a power of 2.
    - `seed`: of the scramblings.
    - `tolerances`: the tolerances; default those of the mechanism.
    - `speed`, `load`: operating point [rad/s, N]; default that of the mechanism.
    - `findings`: whether Monte Carlo looks for errors of `check` in every design.
    - `progress`: called with the number of finished designs and the total number, which includes
      the ends of the tolerance zones.

    **Returns:** a `ToleranceAnalysis`.

    **Raises:** `UnknownNameError` for an unknown name; `ValueError` without tolerances, for
    tolerances or limits that make no sense, an unknown method, or too few samples;
    `MissingDataError` where the mechanism lacks data.
    """
    if method != "all" and method not in _METHODS:
        raise ValueError(f"method is {method!r}; choose one of {', '.join((*_METHODS, 'all'))}")
    if samples < _FEWEST:
        raise ValueError(f"samples is {samples}; it must be at least {_FEWEST}")
    inputs = inputs_of(mechanism, tolerances)
    bounds = limits_of(mechanism.design_problem, limits)
    selected = _selected(mechanism, quantities, bounds, speed, load)
    at = as_optional_scalar(speed), as_optional_scalar(load)
    check_components(inputs.mechanism, bounds, *at)
    methods = _METHODS if method == "all" else (method,)
    by_method: dict[str, MethodResult] = {}
    if method != "monte_carlo":
        orders = [one for one in methods if one != "monte_carlo"]
        by_method |= _propagated(inputs, selected, at, bounds, orders, seed)
    if "monte_carlo" in methods:
        checks = sources() if findings else None
        by_method["monte_carlo"] = _sampled(
            inputs, selected, at, bounds, samples, seed, checks, progress
        )
    labels = tuple(by_method[methods[-1]].estimates)
    return ToleranceAnalysis(
        quantities=labels,
        units=tuple(quantity_of(label).unit for label in labels),
        limits=tuple(limit_of(label, bounds) for label in labels),
        tolerances=inputs.tolerances,
        tolerance_units=inputs.units,
        methods=by_method,
    )


def _selected(mechanism, quantities, bounds: Limits, speed, load) -> tuple[Quantity, ...]:
    names = [] if quantities is None else listed_names(quantities, "quantities")
    names += [quantity_of(label).name for label in bounds]
    if not names:
        names = list(available_quantities(mechanism, DEFAULT_QUANTITIES, speed=speed, load=load))
    selected = named_quantities(names)
    for label in bounds:
        if quantity_of(label) not in selected:
            raise ValueError(
                f"quantities and limits have two functions of the name {label}; rename one of them"
            )
    return selected


def limit_of(label: str, bounds: Limits) -> tuple[float, float] | None:
    """Limits of a component: those of its quantity."""
    return bounds.get(label, bounds.get(label.partition("[")[0]))


def _all_within(values: dict[str, np.ndarray], bounds: Limits) -> np.ndarray | None:
    inside = [
        within(array, limit)
        for label, array in values.items()
        if (limit := limit_of(label, bounds)) is not None
    ]
    return np.logical_and.reduce(inside) if inside else None


def derivatives(
    inputs: Inputs, selected: tuple[Quantity, ...], at: tuple[Scalar | None, ...], second: bool
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], dict[str, np.ndarray], int]:
    """Values, standardised slopes and curvatures of each component; the code of the design."""
    count = len(inputs.tolerances)
    left, right = np.triu_indices(count)
    pairs = (jnp.asarray(left), jnp.asarray(right)) if second else None
    middle, directions = jnp.asarray(inputs.middle), jnp.asarray(inputs.directions)
    values, first, curved, code = derivatives_along(
        inputs.mechanism, inputs.paths, middle, directions, pairs, selected, *at
    )

    def arrays(values) -> dict[str, np.ndarray]:
        return {one.name: np.asarray(values[one.name]) for one in selected}

    curvatures: dict[str, np.ndarray] = {}
    if curved is not None:
        for label, entries in by_component(arrays(curved), 1).items():
            matrix = np.zeros((count, count))
            matrix[left, right] = matrix[right, left] = entries
            curvatures[label] = matrix
    return by_component(arrays(values), 0), by_component(arrays(first), 1), curvatures, int(code)


def _propagated(
    inputs: Inputs, selected, at, bounds: Limits, orders: list[str], seed: int
) -> dict[str, MethodResult]:
    values, slopes, curvatures, code = derivatives(inputs, selected, at, "second_order" in orders)
    deviations = points(inputs, _SURROGATE_SAMPLES, seed)
    at_ends = zone_points(inputs)
    by_order = {}
    for order in orders:
        estimates: dict[str, Estimate] = {}
        ends: dict[str, np.ndarray] = {}
        surrogates: dict[str, np.ndarray] = {}
        for label, value in values.items():
            limit, curved = limit_of(label, bounds), np.zeros((len(inputs.tolerances),) * 2)
            if order == "first_order":
                estimates[label] = first_order(
                    float(value), slopes[label], inputs.normal, deviations, limit
                )
            else:
                curved = curvatures[label]
                estimates[label] = second_order(
                    float(value), slopes[label], curved, inputs.kurtosis, deviations, limit
                )
            ends[label] = quadratic(float(value), slopes[label], curved, at_ends)
            if limit is not None:
                surrogates[label] = quadratic(float(value), slopes[label], curved, deviations)
        inside = _all_within(surrogates, bounds)
        share: tuple[float | None, float | None] = (None, None)
        if len(surrogates) == 1:
            one = estimates[next(iter(surrogates))]
            share = (one.yield_share, one.yield_error)
        elif inside is not None:
            share = share_with_error(inside)
        reasons = _reasons(np.array([code]))
        by_order[order] = MethodResult(
            estimates, *share, reasons=reasons, slopes=slopes, ends=zone_ends(ends)
        )
    return by_order


def _reasons(codes: np.ndarray) -> dict[str, int]:
    return {REASONS[code]: int((codes == code).sum()) for code in np.unique(codes) if code}


def _sampled(
    inputs: Inputs, selected, at, bounds: Limits, samples: int, seed: int, checks, progress
) -> MethodResult:
    deviations = points(inputs, samples, seed)
    shape = deviations.shape[:2]
    flat = deviations.reshape(-1, deviations.shape[-1])
    # The ends of the zones are further designs of the same program.
    everything = np.concatenate([flat, zone_points(inputs)])
    columns, *flags = evaluate_points(inputs, everything, selected, at[0], at[1], checks, progress)
    values = {label: array[: len(flat)].reshape(shape) for label, array in columns.items()}
    codes, errors = (array[: len(flat)] for array in flags)
    usable = (codes == 0).reshape(shape)
    estimates = {
        label: monte_carlo(array, deviations, limit_of(label, bounds))
        for label, array in values.items()
    }
    inside = _all_within(values, bounds)
    good = usable & (errors == 0).reshape(shape)
    share: tuple[float | None, float | None] = (None, None)
    if inside is not None or checks:
        share = share_with_error(good if inside is None else good & inside)
    names = list(error_names(inputs.mechanism)) if checks else []
    counts = {
        names[place - 1]: int(((errors == place) & (codes == 0)).sum())
        for place in np.unique(errors)
        if place
    }
    return MethodResult(
        estimates,
        *share,
        reasons=_reasons(codes),
        errors={name: count for name, count in counts.items() if count},
        samples=len(flat),
        values={label: array.ravel() for label, array in values.items()},
        ends=zone_ends({label: array[len(flat) :] for label, array in columns.items()}),
    )
