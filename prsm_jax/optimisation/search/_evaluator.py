"""The design problem as guarded functions of a point in the unit box, with a cache."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...fields import Scalar
from ...findings import Margin, evaluate_margins, margins_of, shared_loads, sources
from ...mechanism import DesignProblem, Mechanism, set_parameters
from ...quantities import Analysis, component_names, compute, find_quantity
from ._margin_rows import WHOLE_SCALE, MarginRows, is_constraint, probe_positions, sorted_margins


def screw_speed(
    mechanism: Mechanism, speed: Scalar | None, load: Scalar | None, nut_speed: Scalar | None
) -> Scalar | None:
    """Screw speed of a design [rad/s]: given, or from the speed of the nut [m/s]."""
    if nut_speed is None:
        return speed
    one = Analysis(mechanism, jnp.ones_like(nut_speed), load)
    return nut_speed / find_quantity("nut_speed").function(one)


def outputs_at(inputs: tuple[Any, ...], position: Float[Array, " variables"]):
    """Quantities and margins of a design as separate arrays, and whether the design is usable."""
    mechanism, names, quantities, margins, lower, width, speed, load, nut_speed = inputs
    values = lower + width * position
    moved = set_parameters(mechanism, {name: values[i] for i, name in enumerate(names)})
    if load is None or jnp.ndim(load) == 0:
        at = screw_speed(moved, speed, load, nut_speed)
        return _analysed(moved, quantities, margins, at, load)
    # Several operating points: every quantity at each of them, and the least of every margin.
    at_each = jax.vmap(lambda one, other: _analysed(moved, quantities, margins, one, other))
    outputs, valid = at_each(speed, load)
    split = len(quantities)
    return (
        [jnp.ravel(numbers) for numbers in outputs[:split]]
        + [jnp.min(numbers, axis=0) for numbers in outputs[split:]],
        jnp.all(valid),
    )


def _analysed(
    moved: Mechanism, quantities: tuple[str, ...], margins: Any, speed: Any, load: Any
) -> tuple[list[Array], Any]:
    """Quantities and margins at one operating point, and whether they can be used."""
    analysis = Analysis(moved, speed, load)
    # A design whose threads do not mesh is unusable, whatever the requested quantities.
    for stage in analysis.kinematics:
        analysis.require(stage.meshing.converged)
    analysis.expect(case for name in quantities for case in find_quantity(name).shares)
    if margins:
        analysis.expect(shared_loads(margins_of(moved), is_constraint))
    # Not concatenated: XLA would recompute the operands for each element.
    outputs = [jnp.ravel(find_quantity(name).function(analysis)) for name in quantities]
    if margins:
        for numbers in evaluate_margins(analysis, is_constraint, details=False):
            if numbers is not None:
                outputs.append(jnp.ravel(numbers["value"]))
    # Overlapping rollers violate only a margin, which a search may do on its way.
    return outputs, analysis.computed


@eqx.filter_jit
def _values(inputs: tuple[Any, ...], position: Float[Array, " variables"]):
    return outputs_at(inputs, position)


@eqx.filter_jit
def _derivatives(inputs: tuple[Any, ...], position: Float[Array, " variables"]):
    # Forward mode: one pass per variable, and there are few variables.
    _, push = jax.linearize(lambda point: outputs_at(inputs, point)[0], position)
    return jax.vmap(push, out_axes=-1)(jnp.eye(position.shape[0], dtype=position.dtype))


def _margins(mechanism: Mechanism, speed: Scalar | None, load: Scalar | None) -> tuple[Margin, ...]:
    """The margins for which the mechanism has data."""
    margins: list[Margin] = []

    def try_all(traced, speed, load):
        analysis = Analysis(traced, speed, load)
        values = evaluate_margins(analysis, is_constraint, details=False)
        pairs = zip(margins_of(traced), values, strict=True)
        margins.extend(margin for margin, numbers in pairs if numbers is not None)

    eqx.filter_eval_shape(try_all, mechanism, speed, load)
    known = {(m.name, m.stage, m.subject, m.levels) for m in margins}
    # Margins of the mechanism itself: the ones above refer to a finished trace.
    return tuple(
        m for m in margins_of(mechanism) if (m.name, m.stage, m.subject, m.levels) in known
    )


class Rows:
    """The constraints as rows `lower <= value <= upper`, one per component of a quantity.

    The first `explicit` rows are the constraints of the problem; those of the margins follow.
    """

    def __init__(self, problem: DesignProblem, shapes: dict[str, tuple[int, ...]], margins: int):
        shares = np.array([one.share for one in problem.operating_points] or [1.0])
        #: Share of each operating point in the mean.
        self.shares: np.ndarray = shares / shares.sum()
        for term in problem.objectives:
            if int(np.prod(shapes[term.quantity])) != 1:
                raise ValueError(
                    f"objective {term.quantity!r} has {int(np.prod(shapes[term.quantity]))} "
                    "components; an objective must be one number"
                )
        if problem.operating_points:
            # The operating point is the first index of a component.
            shapes = {name: (len(shares), *shape) for name, shape in shapes.items()}
        first = np.cumsum([0, *(int(np.prod(shape)) for shape in shapes.values())])
        place: dict[str, int] = dict(zip(shapes, map(int, first[:-1]), strict=True))
        #: Index of the first component of each quantity among the evaluated values.
        self.place: dict[str, int] = place
        self.names: list[str] = []
        index, lower, upper, equality = [], [], [], []
        for constraint in problem.constraints:
            name = constraint.quantity
            for offset, label in enumerate(component_names(name, shapes[name])):
                self.names.append(label)
                index.append(place[name] + offset)
                equality.append(constraint.equal is not None)
                low, high = constraint.lower, constraint.upper
                if constraint.equal is not None:
                    low = high = constraint.equal
                lower.append(-np.inf if low is None else low)
                upper.append(np.inf if high is None else high)
        self.units: list[str] = [find_quantity(name.partition("[")[0]).unit for name in self.names]
        self.index: np.ndarray = np.array(index, dtype=int)
        self.lower: np.ndarray = np.array(lower, dtype=float)
        self.upper: np.ndarray = np.array(upper, dtype=float)
        self.equality: np.ndarray = np.array(equality, dtype=bool)
        self.explicit: int = len(self.names)
        self.first_margin: int = int(first[-1])
        self.weights: np.ndarray = np.zeros(int(first[-1]) + margins)
        for term in problem.objectives:
            sign = -1.0 if term.sense == "maximise" else 1.0
            self.weights += sign * term.weight * self.mean_of(term.quantity)

    def mean_of(self, name: str) -> np.ndarray:
        """Weights of all values in an objective: its mean over the operating points."""
        weights = np.zeros(len(self.weights))
        first = self.place[name]
        weights[first : first + len(self.shares)] = self.shares
        return weights

    def add(self, rows: MarginRows) -> None:
        """Append the margins that a search has to respect."""
        added = rows.smooth
        self.names += [row.label for row in added]
        self.units += [row.margin.unit for row in added]
        places = [self.first_margin + row.place for row in added]
        self.index = np.concatenate([self.index, np.array(places, dtype=int)])
        self.lower = np.concatenate([self.lower, [row.lower for row in added]])
        self.upper = np.concatenate([self.upper, np.full(len(added), np.inf)])
        self.equality = np.concatenate([self.equality, np.zeros(len(added), dtype=bool)])

    def fix(self, label: str, value: float | None, lower: float) -> None:
        """Fix a margin at a whole number, or release it (`None`)."""
        row = self.names.index(label, self.explicit)
        self.equality[row] = value is not None
        self.lower[row] = lower if value is None else value
        self.upper[row] = np.inf if value is None else value


class Point:
    """One evaluated design; derivatives are added on demand."""

    def __init__(self, position: np.ndarray, values: np.ndarray, good: bool):
        self.position: np.ndarray = position
        self.values: np.ndarray = values
        self.good: bool = good
        self.jacobian: np.ndarray | None = None


class Evaluator:
    """Cost, constraints and derivatives over the unit box, each design evaluated once.

    Cost and constraints come from one compiled function and their derivatives from another; the
    mechanism and the bounds are arguments of both, so that another problem with the same names
    does not compile again. `cost` and `constraint_values` are in units of `cost_scale` and
    `row_scale`, typical magnitudes found at the first good design.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        problem: DesignProblem,
        speed: Scalar | None,
        load: Scalar | None,
        *,
        margins: bool = True,
    ):
        names = tuple(variable.name for variable in problem.variables)
        terms = (*problem.objectives, *problem.constraints)
        self.quantities: tuple[str, ...] = tuple(dict.fromkeys(term.quantity for term in terms))
        self.lower: np.ndarray = np.array([variable.lower for variable in problem.variables])
        upper = np.array([variable.upper for variable in problem.variables])
        self.width: np.ndarray = upper - self.lower
        cases = problem.operating_points
        if cases and (speed is not None or load is not None):
            raise ValueError(
                "a speed or a load is given, and the problem has operating points; give one or the "
                "other"
            )
        speeds = jnp.asarray([float(one.speed) for one in cases])
        loads = jnp.asarray([float(one.load) for one in cases])
        self._given = (
            mechanism,
            names,
            self.quantities,
            # Other sources of margins need another program.
            sources() if margins else None,
            jnp.asarray(self.lower),
            jnp.asarray(self.width),
            speeds if cases else speed,
            loads if cases else load,
            None if problem.nut_speed is None else jnp.asarray(problem.nut_speed, float),
        )
        if problem.nut_speed is not None and speed is not None:
            raise ValueError(
                f"speed is {float(speed):g} rad/s and nut_speed {problem.nut_speed:g} m/s; give one"
            )
        # With a nut speed the screw speed is any number: there need not be an operating point.
        some_speed = speed if problem.nut_speed is None else jnp.ones(())
        some_load = load
        if problem.operating_points:
            some_speed, some_load = speeds[0], loads[0]
        shapes = eqx.filter_eval_shape(self._shapes, mechanism, some_speed, some_load)
        # A derived number that a variable makes explicit has margins too (the profile radius).
        written = set_parameters(
            mechanism, dict(zip(names, self.lower, strict=True)), checked=False
        )
        known = _margins(written, some_speed, some_load) if margins else ()
        shape_of = {name: shapes[name].shape for name in self.quantities}
        self.rows: Rows = Rows(problem, shape_of, len(known))
        self.evaluations: int = 0
        self.derivative_evaluations: int = 0
        self._last: Point | None = None
        #: Whether a design that violates a margin is unusable: for searches with bounds only.
        self.guarded: bool = False
        self.margins: MarginRows = MarginRows()
        if known:
            points = [self.point(p) for p in probe_positions(len(names))]
            values = np.stack([point.values[self.rows.first_margin :] for point in points])
            self.margins = sorted_margins(known, values)
            self.rows.add(self.margins)
            self._last = None
        self.cost_scale: float = 1.0
        self.row_scale: np.ndarray = np.ones(len(self.rows.names))

    def _shapes(self, mechanism, speed, load):
        # `compute` names the quantity for which data are missing.
        return compute(mechanism, self.quantities, speed=speed, load=load)

    @property
    def program_inputs(self) -> tuple[Any, ...]:
        """What the compiled programs take beside the position."""
        return self._given

    @property
    def variables(self) -> int:
        return len(self.lower)

    def physical(self, position: np.ndarray) -> np.ndarray:
        """Values of the variables [SI] at a position in the unit box."""
        return self.lower + self.width * position

    def point(self, position: np.ndarray) -> Point:
        """The design at a position; the last one is cached."""
        if self._last is not None and np.array_equal(self._last.position, position):
            return self._last
        arrays, valid = _values(self._given, jnp.asarray(position))
        self.evaluations += 1
        values = np.concatenate([np.asarray(array, dtype=float) for array in arrays])
        good = bool(valid) and bool(np.isfinite(values[self._used]).all())
        if good and self.guarded:
            good = not self._breaks_margin(values)
        self._last = Point(np.array(position), values, good)
        return self._last

    def _breaks_margin(self, values: np.ndarray) -> bool:
        rows = slice(self.rows.explicit, None)
        return bool(np.any(values[self.rows.index[rows]] < self.rows.lower[rows]))

    def guard(self, on: bool) -> None:
        """Set whether a design that violates a margin counts as failed."""
        self.guarded, self._last = on, None

    @property
    def _used(self) -> np.ndarray:
        used = self.rows.weights != 0
        used[self.rows.index] = True
        return used

    def jacobian(self, position: np.ndarray) -> np.ndarray:
        """Derivatives of all quantities with respect to the position; 0 where not finite."""
        point = self.point(position)
        if point.jacobian is None:
            arrays = _derivatives(self._given, jnp.asarray(position))
            jacobian = np.concatenate([np.asarray(rows, dtype=float) for rows in arrays])
            self.derivative_evaluations += 1
            if not np.isfinite(jacobian[self._used]).all():
                point.good = False
            point.jacobian = np.nan_to_num(jacobian, nan=0.0, posinf=0.0, neginf=0.0)
        return point.jacobian

    def scale_from(self, position: np.ndarray) -> None:
        """Take typical magnitudes from a good design: the value, its change over the box, or 1."""
        values, jacobian = self.point(position).values, self.jacobian(position)
        cost, slope = self.rows.weights @ values, self.rows.weights @ jacobian
        self.cost_scale = float(max(abs(cost), np.max(np.abs(slope)))) or 1.0
        limits = np.where(np.isfinite(self.rows.lower), np.abs(self.rows.lower), 0.0)
        limits = np.maximum(
            limits, np.where(np.isfinite(self.rows.upper), np.abs(self.rows.upper), 0.0)
        )
        reached = np.abs(values[self.rows.index])
        reached = np.maximum(reached, np.max(np.abs(jacobian[self.rows.index]), axis=1, initial=0))
        # The limit of a margin is at or near 0, and says nothing about the size of the margin.
        explicit = np.arange(len(limits)) < self.rows.explicit
        scale = np.where((limits > 0) & explicit, limits, reached)
        self.row_scale = np.where(scale > 0, scale, 1.0)
        for row in self.margins.integer:
            self.row_scale[self.rows.names.index(row.label, self.rows.explicit)] = WHOLE_SCALE

    def cost(self, point: Point) -> float:
        """Scaled cost, to be minimised."""
        return float(self.rows.weights[self._used] @ point.values[self._used]) / self.cost_scale

    def cost_gradient(self, position: np.ndarray) -> np.ndarray:
        return self.rows.weights @ self.jacobian(position) / self.cost_scale

    def constraint_values(self, point: Point) -> np.ndarray:
        """Scaled values of the constraint rows."""
        return point.values[self.rows.index] / self.row_scale

    def constraint_jacobian(self, position: np.ndarray) -> np.ndarray:
        return self.jacobian(position)[self.rows.index] / self.row_scale[:, None]

    @property
    def scaled_limits(self) -> tuple[np.ndarray, np.ndarray]:
        return self.rows.lower / self.row_scale, self.rows.upper / self.row_scale

    def violation(self, point: Point) -> float:
        """Largest violation of the limits by a scaled row."""
        if not len(self.rows.names):
            return 0.0
        values, (lower, upper) = self.constraint_values(point), self.scaled_limits
        return float(np.max(np.maximum(np.maximum(lower - values, values - upper), 0.0)))
