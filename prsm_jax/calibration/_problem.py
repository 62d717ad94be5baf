"""The least-squares problem of a calibration: arrays in SI, and one program that solves it."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from .._errors import UnknownNameError
from ..fields import listed_names
from ..mechanism import (
    Mechanism,
    check_independent,
    find_parameters,
    of_one_known_design,
    set_parameters,
)
from ..quantities import Analysis, component_names, evaluate, evaluate_coded, find_quantity
from ._bounds import from_free, inside, to_free
from ._losses import LOSSES, as_squares
from ._measurements import Measurements, check_conditions, split_component
from ._optimum import near_optimum

#: A physical limit is no bound of the search if its distance from the start is more than this many
#: times the start.
_FAR = 100.0
#: Relative change of scaled numbers and of the sum of squares at which the search stops.
_TOLERANCE = 1e-10
_MOST_STEPS = 300


class Solved(eqx.Module):
    """Result of one search: fitted values [SI], and the data for their uncertainty."""

    values: Float[Array, " parameters"]
    #: Measured minus computed value, over `scale` of the problem.
    residuals: Float[Array, " rows"]
    #: Derivative of computed value over `scale` by value over `magnitude`.
    jacobian: Float[Array, "rows parameters"]
    cost: Float[Array, ""]
    #: Whether the search converged, and whether all numbers are finite.
    converged: Bool[Array, ""]
    finite: Bool[Array, ""]
    steps: Int[Array, ""]


class CalibrationProblem(eqx.Module):
    """Parameters and measured values of a fit [SI]; arrays are traced, names and loss are static.

    A row is one measured value of one component of a quantity, at one point. A point is one set of
    conditions.
    """

    mechanism: Mechanism
    conditions: dict[str, Float[Array, " points"]]
    measured: Float[Array, " rows"]
    #: Standard deviation of each row, or the typical magnitude of its quantity.
    scale: Float[Array, " rows"]
    point: Int[Array, " rows"]
    #: Index of the component among those of all quantities.
    component: Int[Array, " rows"]
    start: Float[Array, " parameters"]
    lower: Float[Array, " parameters"]
    upper: Float[Array, " parameters"]
    #: Magnitude by which each parameter is scaled.
    magnitude: Float[Array, " parameters"]
    parameters: tuple[str, ...] = eqx.field(static=True)
    quantities: tuple[str, ...] = eqx.field(static=True)
    #: Labels of all components, in the order of the quantities.
    components: tuple[str, ...] = eqx.field(static=True)
    #: Quantities with several components that have a column without the number of one: until its
    #: rows are paired, they count as the first component.
    unnumbered: tuple[str, ...] = eqx.field(static=True)
    #: Names of the conditions in the order in which they are set, which a program does not keep.
    order: tuple[str, ...] = eqx.field(static=True)
    loss: str = eqx.field(static=True)

    def all_computed(
        self, values: Float[Array, " parameters"]
    ) -> Float[Array, "points components"]:
        """Every component of every quantity at every point."""

        return _at_points(self, values, lambda *of: (evaluate(*of), None))[0]

    def computed(self, values: Float[Array, " parameters"]) -> Float[Array, " rows"]:
        """Computed value of each row."""
        return self.all_computed(values)[self.point, self.component]

    def residuals(
        self, values: Float[Array, " parameters"], measured: Float[Array, " rows"]
    ) -> Float[Array, " rows"]:
        """Measured minus computed value, over the scale of the row."""
        return (measured - self.computed(values)) / self.scale

    def solve(
        self,
        measured: Float[Array, " rows"],
        free: Bool[Array, " parameters"],
        fixed: Float[Array, " parameters"],
        start: Float[Array, " parameters"],
    ) -> Solved:
        """Fit the free parameters by Levenberg–Marquardt; jittable, can be mapped over `measured`.

        **Arguments:**

        - `measured`: measured value of each row.
        - `free`: which parameters are fitted; the others keep their value in `fixed`.
        - `fixed`: values of the parameters that are not free.
        - `start`: where the search begins, inside of the bounds.
        """
        import optimistix as optx

        # Here, because optimistix takes a while to import.
        from ._search import Search, ended_by_itself

        def values_of(x: Array) -> Array:
            inner = from_free(x, self.lower, self.upper, self.magnitude)
            return jnp.where(free, inner, fixed)

        def losses(x: Array, data: Array) -> Array:
            return as_squares(self.residuals(values_of(x), data), self.loss)

        solver = Search(_TOLERANCE)
        x = to_free(start, self.lower, self.upper, self.magnitude)
        solution = optx.least_squares(
            losses, solver, x, args=measured, max_steps=_MOST_STEPS, throw=False
        )
        values = values_of(solution.value)

        def scaled(shares: Array) -> Array:
            return -self.residuals(shares * self.magnitude, measured)

        # Forward: there are fewer parameters than rows.
        shares = values / self.magnitude
        negative, push = jax.linearize(scaled, shares)
        jacobian = jax.vmap(push, out_axes=1)(jnp.eye(len(self.parameters), dtype=shares.dtype))
        squares, slope = jax.jvp(
            lambda z: as_squares(z, self.loss), (-negative,), (jnp.ones_like(negative),)
        )
        cost = 0.5 * jnp.sum(squares**2)
        exact = _TOLERANCE * jnp.linalg.norm(measured / self.scale)
        columns = jnp.where(free, slope[:, None] * jacobian, 0.0)
        finite = jnp.isfinite(cost) & jnp.isfinite(jacobian).all()
        return Solved(
            values,
            -negative,
            jacobian,
            cost,
            ended_by_itself(solution) | near_optimum(squares, columns, exact),
            finite,
            jnp.asarray(solution.stats["num_steps"]),
        )


def _at_points(
    problem: CalibrationProblem,
    values: Float[Array, " parameters"],
    evaluation: Callable[[Analysis, tuple[str, ...]], tuple[dict[str, Array], Any]],
) -> tuple[Float[Array, "points components"], Any]:
    """All components at all points, and further results of the evaluation, a row per point."""
    numbers = dict(zip(problem.parameters, values, strict=True))

    def at(conditions: dict[str, Array]):
        given = {name: conditions[name] for name in problem.order}
        one = set_parameters(problem.mechanism, given | numbers, checked=False)
        computed, more = evaluation(Analysis(one), problem.quantities)
        return jnp.concatenate([jnp.ravel(computed[name]) for name in problem.quantities]), more

    if not problem.conditions:
        return jax.tree.map(lambda array: array[None], at({}))
    return jax.vmap(at)(problem.conditions)


@of_one_known_design
def calibration_problem(
    mechanism: Mechanism,
    data: Measurements,
    parameters: Iterable[str],
    *,
    standard_deviations: Mapping[str, float] | None = None,
    bounds: Mapping[str, Any] | None = None,
    loss: str = "squared",
) -> CalibrationProblem:
    """The least-squares problem of `calibrate`; the arguments have the same meaning.

    **Raises:** as `calibrate`.
    """
    if loss not in LOSSES:
        raise ValueError(f"loss is {loss!r}; choose one of {', '.join(LOSSES)}")
    names = tuple(listed_names(parameters, "parameters"))
    if not names:
        raise ValueError("parameters is empty; name at least one")
    check_conditions(data, names)
    start, lower, upper, magnitude = _parameters(mechanism, names, dict(bounds or {}))
    for name in data.conditions:
        if find_parameters(mechanism, name)[0].static:
            raise ValueError(
                f"condition {name!r} is a whole number of the mechanism; calibrate with each value"
            )
    check_independent(mechanism, [*data.conditions, *names])

    quantities = tuple(dict.fromkeys(split_component(name)[0] for name in data.values))
    shapes = _shapes(mechanism, quantities)
    labels: list[str] = []
    first: dict[str, int] = {}
    for quantity in quantities:
        first[quantity] = len(labels)
        labels += component_names(quantity, shapes[quantity])

    points, at = _points(data)
    rows = []
    unnumbered: list[str] = []
    deviations = dict(standard_deviations or {})
    for name, column in data.values.items():
        values = np.asarray(column, float)
        quantity, number = split_component(name)
        count = int(np.prod(shapes[quantity], dtype=int))
        if number is not None and not 1 <= number <= count:
            many = f"{count} components; give [1] to [{count}]"
            raise UnknownNameError(
                f"{name}: the quantity has {'one component; give [1]' if count == 1 else many}"
            )
        if number is None and count > 1:
            unnumbered.append(quantity)
        scale = _scale(name, values, deviations)
        # A row without a component number is paired with a component later.
        component = first[quantity] + (0 if number is None else number - 1)
        known = np.flatnonzero(np.isfinite(values))
        rows += [(values[i], scale, at[i], component) for i in known]
    if deviations:
        raise UnknownNameError(
            f"standard deviation of {next(iter(deviations))!r}, which is not in the data; measured "
            f"are {', '.join(data.values)}"
        )
    if len(rows) <= len(names):
        raise ValueError(
            f"{len(rows)} measured values for {len(names)} parameters: the residuals then do "
            "not show the scatter; give more values, or fit fewer parameters"
        )
    measured, scales, point, component = (np.array(column) for column in zip(*rows, strict=True))
    real = jnp.result_type(float)
    return CalibrationProblem(
        mechanism=mechanism,
        conditions={
            name: jnp.asarray(points[:, i], real) for i, name in enumerate(data.conditions)
        },
        measured=jnp.asarray(measured, real),
        scale=jnp.asarray(scales, real),
        point=jnp.asarray(point),
        component=jnp.asarray(component),
        start=jnp.asarray(start, real),
        lower=jnp.asarray(lower, real),
        upper=jnp.asarray(upper, real),
        magnitude=jnp.asarray(magnitude, real),
        parameters=names,
        quantities=quantities,
        components=tuple(labels),
        unnumbered=tuple(unnumbered),
        order=tuple(data.conditions),
        loss=loss,
    )


def _points(data: Measurements) -> tuple[np.ndarray, np.ndarray]:
    """Distinct conditions, points × conditions, and the point of each row."""
    if not data.conditions:
        return np.zeros((1, 0)), np.zeros(data.rows, int)
    table = np.stack([np.asarray(column) for column in data.conditions.values()], axis=1)
    points, at = np.unique(table, axis=0, return_inverse=True)
    return points, np.asarray(at).reshape(-1)


def _scale(name: str, values: np.ndarray, deviations: dict[str, float]) -> float:
    if name in deviations:
        given = deviations.pop(name)
        try:
            deviation = float(given)
        except (TypeError, ValueError):
            raise ValueError(
                f"standard deviation of {name!r} is {given!r}; give one number per column"
            ) from None
        if not (np.isfinite(deviation) and deviation > 0):
            raise ValueError(f"standard deviation of {name!r} is {deviation}; it must be positive")
        return deviation
    typical = float(np.sqrt(np.nanmean(values**2)))
    return typical if typical > 0 else 1.0


def _shapes(mechanism: Mechanism, quantities: tuple[str, ...]) -> dict[str, tuple[int, ...]]:
    for name in quantities:
        find_quantity(name)
    shapes = eqx.filter_eval_shape(lambda m: evaluate(Analysis(m), quantities), mechanism)
    return {name: shapes[name].shape for name in quantities}


def _paths(mechanism: Mechanism, name: str) -> tuple[str, ...]:
    return tuple(one.path for one in find_parameters(mechanism, name))


def _parameters(mechanism: Mechanism, names: tuple[str, ...], bounds: dict[str, Any]):
    """Start, bounds and magnitude of each parameter."""
    start, lower, upper, magnitude = [], [], [], []
    fitted = {_paths(mechanism, name): name for name in names}
    # A number has several names: `lead` is `stage.thread.lead`.
    for other in [name for name in bounds if name not in names]:
        name = fitted.get(_paths(mechanism, other))
        if name is None or name in bounds:
            raise UnknownNameError(
                f"bounds of {other!r}, which is not fitted or has bounds already; fitted are "
                f"{', '.join(names)}"
            )
        bounds[name] = bounds.pop(other)
    for name in names:
        parameters = find_parameters(mechanism, name)
        if any(one.static for one in parameters):
            raise ValueError(
                f"parameter {name!r} is a whole number and cannot be fitted; calibrate with each "
                "of its values"
            )
        present = [float(one.get(mechanism)) for one in parameters]
        if not np.allclose(present, present[0], rtol=1e-12, atol=0.0):
            raise ValueError(
                f"parameter {name!r} differs between the stages "
                f"({', '.join(f'{value:g}' for value in present)}); name the stage: "
                f"{' or '.join(one.path for one in parameters)}"
            )
        try:
            low, high = bounds.get(name, (None, None))
        except (TypeError, ValueError):
            raise ValueError(
                f"parameter {name!r} has the bounds {bounds[name]!r}; give (lower, upper), with "
                "None for no bound"
            ) from None
        limit, value = parameters[0].limit, present[0]
        far = _FAR * abs(value)
        if low is None:
            low = limit.lower
        if high is None:
            high = limit.upper if abs(limit.upper - value) <= far else np.inf
        low, high = float(low), float(high)
        unit = parameters[0].unit
        words = f"({low:g}, {high:g})" + ("" if unit == "1" else f" {unit}")
        if not low < high:
            remedy = "reverse them" if low > high else "the upper one must be above the lower one"
            raise ValueError(f"parameter {name!r} has the bounds {words}; {remedy}")
        # A physical limit that is far away is no bound; infinity replaces it.
        if low < limit.lower or limit.upper < high < np.inf:
            raise ValueError(f"parameter {name!r} has the bounds {words}; it must be {limit.words}")
        size = abs(value)
        if size == 0:
            size = high - low
        if not np.isfinite(size):
            raise ValueError(
                f"parameter {name!r} is 0 at the start, so its magnitude is not known; give both "
                "bounds, or another start"
            )
        start.append(value)
        lower.append(low)
        upper.append(high)
        magnitude.append(size)
    first, low, high, size = (np.array(column) for column in (start, lower, upper, magnitude))
    return inside(first, low, high, size), low, high, size


@eqx.filter_jit
def start_values(
    problem: CalibrationProblem,
) -> tuple[Float[Array, "points components"], Int[Array, " points"]]:
    """All computed values at the start, and the reason code of each point (0: usable)."""
    return _at_points(problem, problem.start, evaluate_coded)


@eqx.filter_jit
def all_values(
    problem: CalibrationProblem, values: Float[Array, " parameters"]
) -> Float[Array, "points components"]:
    """All components at all points."""
    return problem.all_computed(values)


@eqx.filter_jit
def solve_one(problem: CalibrationProblem, measured, free, fixed, start) -> Solved:
    """`CalibrationProblem.solve` as one program."""
    return problem.solve(measured, free, fixed, start)


@eqx.filter_jit
def solve_many(problem: CalibrationProblem, measured, free, fixed, start) -> Solved:
    """As `solve_one`, for several sets of measured values."""
    return jax.vmap(lambda data: problem.solve(data, free, fixed, start))(measured)
