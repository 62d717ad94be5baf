"""The design problem as guarded functions of a point in the unit box, with a cache."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ...fields import Scalar
from ...mechanism import (
    DesignProblem,
    Mechanism,
    set_parameters,
    with_traced_counts,
    written_out,
)
from ...programs import bind_program, prepare_program
from ._margin_rows import (
    WHOLE_SCALE,
    MarginRows,
    evaluated,
    probe_positions,
    respected,
    sorted_margins,
)
from ._outputs import compiled_derivatives, compiled_values, scatter_of
from ._parts import order_of, parts_of
from ._rows import Rows

#: Designs that the program with derivatives evaluates. Another one for values alone takes half a
#: millisecond less, and seconds to compile.
_WITH_DERIVATIVES = 5000


class Point:
    """One evaluated design; derivatives are added on demand."""

    def __init__(
        self, position: np.ndarray, values: np.ndarray, good: bool, slopes: np.ndarray | None
    ):
        self.position: np.ndarray = position
        self.values: np.ndarray = values
        self.good: bool = good
        #: Derivatives, where they were calculated with the values.
        self.slopes: np.ndarray | None = slopes
        self.jacobian: np.ndarray | None = None


class Evaluator:
    """Cost, constraints and derivatives over the unit box, each design evaluated once.

    Cost, constraints and their derivatives come from one compiled function, or from two
    (`parts_of`); a very long search has another one without derivatives. The mechanism and the
    bounds are arguments of these, so that another problem with the same names does not compile
    again; numbers of rollers in `counts` are numbers of the program, not part of it. `cost` and
    `constraint_values` are in units of `cost_scale` and `row_scale`, typical magnitudes found at
    the first good design. `meanwhile` is called when the program may still be compiling, before the
    first evaluation.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        problem: DesignProblem,
        speed: Scalar | None,
        load: Scalar | None,
        *,
        margins: bool = True,
        counts: Mapping[str, float | int] | None = None,
        meanwhile: Callable[[], None] | None = None,
    ):
        names = tuple(variable.name for variable in problem.variables)
        terms = (*problem.objectives, *problem.constraints)
        self.quantities: tuple[str, ...] = tuple(dict.fromkeys(term.quantity for term in terms))
        scatter = scatter_of(mechanism, problem.tolerance_sigmas)
        kept = respected(warnings=problem.avoid_warnings) if margins else None
        # The optimum, in which no variable follows from others, is evaluated by the same programs.
        mechanism = written_out(mechanism, names)
        self.lower: np.ndarray = np.array([variable.lower for variable in problem.variables])
        upper = np.array([variable.upper for variable in problem.variables])
        self.width: np.ndarray = upper - self.lower
        cases = problem.operating_points
        assert not isinstance(cases, str), "the phases of the duty cycle have been looked up"
        if cases and (speed is not None or load is not None):
            raise ValueError(
                "a speed or a load is given, and the problem has operating points; give one or the "
                "other"
            )
        speeds = jnp.asarray([float(one.speed) for one in cases])
        loads = jnp.asarray([float(one.load) for one in cases])
        numbers = {name: jnp.asarray(float(count)) for name, count in (counts or {}).items()}
        self._given = (
            with_traced_counts(mechanism, numbers),
            names,
            self.quantities,
            kept,
            jnp.asarray(self.lower),
            jnp.asarray(self.width),
            speeds if cases else speed,
            loads if cases else load,
            None if problem.nut_speed is None else jnp.asarray(problem.nut_speed, float),
            scatter,
        )
        # With tolerances, derivatives take many times as long as values.
        self._with_derivatives: int = _WITH_DERIVATIVES if scatter is None else 0
        parts = parts_of(self._given)
        traced = [
            prepare_program(compiled_derivatives, part, jnp.zeros(len(names))) for part in parts
        ]
        self._values = bind_program(compiled_values, self._given)
        self._derivatives = [bind_program(compiled_derivatives, part) for part in parts]
        if problem.nut_speed is not None and speed is not None:
            raise ValueError(
                f"speed is {float(speed):g} rad/s and nut_speed {problem.nut_speed:g} m/s; give one"
            )
        # With a nut speed any screw speed gives the shapes; the mechanism may have no own speed.
        some_speed = speed if problem.nut_speed is None else jnp.ones(())
        some_load = load
        if cases:
            some_speed, some_load = speeds[0], loads[0]
        # A derived number that a variable makes explicit has margins too (the profile radius).
        written = set_parameters(
            mechanism, dict(zip(names, self.lower, strict=True)), checked=False
        )
        if scatter is not None:
            written = scatter.made(written)
        shape_of, known = evaluated(
            written, self.quantities, some_speed, some_load, margins=kept, after=traced[0]
        )
        self.rows: Rows = Rows(problem, shape_of, len(known))
        #: Where the numbers stand among those of several programs.
        self._order: np.ndarray | None = None
        if len(parts) > 1:
            count = len(cases) or 1
            sizes = {name: count * int(np.prod(shape)) for name, shape in shape_of.items()}
            self._order = order_of(self._given, parts, sizes, len(known))
        self.evaluations: int = 0
        self.derivative_evaluations: int = 0
        self._last: Point | None = None
        #: Whether a design that violates a margin is unusable: for searches with bounds only.
        self.guarded: bool = False
        self.margins: MarginRows = MarginRows()
        if meanwhile is not None:
            meanwhile()
        if known and kept is not None:
            points = [self.point(p) for p in probe_positions(len(names))]
            values = np.stack([point.values[self.rows.first_margin :] for point in points])
            self.margins = sorted_margins(known, values, kept)
            self.rows.add(self.margins)
            self._last = None
        self.cost_scale: float = 1.0
        self.row_scale: np.ndarray = np.ones(len(self.rows.names))

    @property
    def program_inputs(self) -> tuple[Any, ...]:
        """Arguments of the compiled programs in addition to the position."""
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
        values, valid, slopes = self._evaluated(jnp.asarray(position))
        self.evaluations += 1
        good = valid and bool(np.isfinite(values[self._used]).all())
        if good and self.guarded:
            good = not self._breaks_margin(values)
        self._last = Point(np.array(position), values, good, slopes)
        return self._last

    def _evaluated(self, position: Array) -> tuple[np.ndarray, bool, np.ndarray | None]:
        """All numbers, whether they can be used, and derivatives if the program calculates them."""
        if self.evaluations < self._with_derivatives:
            if self.evaluations == self._with_derivatives // 2:
                prepare_program(compiled_values, self._given, position)
            found, slopes = self._with_slopes(position)
            values = self._joined([numbers for numbers, _ in found])
            return values, all(bool(valid) for _, valid in found), slopes
        numbers, valid = self._values(position)
        return np.asarray(numbers, dtype=float), bool(valid), None

    def _with_slopes(self, position: Array) -> tuple[list[Any], np.ndarray]:
        results = [program(position) for program in self._derivatives]
        return [found for found, _ in results], self._joined([slopes for _, slopes in results])

    def _joined(self, parts: Sequence[Array]) -> np.ndarray:
        joined = np.concatenate([np.asarray(part, dtype=float) for part in parts])
        return joined if self._order is None else joined[self._order]

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
        for group in self.rows.worst:
            used |= np.any(group != 0, axis=0)
        return used

    def jacobian(self, position: np.ndarray) -> np.ndarray:
        """Derivatives of all quantities with respect to the position; 0 where not finite."""
        point = self.point(position)
        if point.jacobian is None:
            jacobian = point.slopes
            if jacobian is None:
                _, jacobian = self._with_slopes(jnp.asarray(position))
            self.derivative_evaluations += 1
            if not np.isfinite(jacobian[self._used]).all():
                point.good = False
            point.jacobian = np.nan_to_num(jacobian, nan=0.0, posinf=0.0, neginf=0.0)
        return point.jacobian

    def scale_from(self, position: np.ndarray) -> None:
        """Take typical magnitudes from a good design: the value, its change over the box, or 1."""
        values, jacobian = self.point(position).values, self.jacobian(position)
        cost, slope = self._cost(values), self._cost_slope(values, jacobian)
        self.cost_scale = float(max(abs(cost), np.max(np.abs(slope)))) or 1.0
        limits = np.where(np.isfinite(self.rows.lower), np.abs(self.rows.lower), 0.0)
        limits = np.maximum(
            limits, np.where(np.isfinite(self.rows.upper), np.abs(self.rows.upper), 0.0)
        )
        reached = np.abs(values[self.rows.index])
        reached = np.maximum(reached, np.max(np.abs(jacobian[self.rows.index]), axis=1, initial=0))
        # The limit of a margin is at or near 0, and is no measure of its magnitude.
        explicit = np.arange(len(limits)) < self.rows.explicit
        scale = np.where((limits > 0) & explicit, limits, reached)
        self.row_scale = np.where(scale > 0, scale, 1.0)
        for row in self.margins.integer:
            self.row_scale[self.rows.names.index(row.label, self.rows.explicit)] = WHOLE_SCALE

    def _cost(self, values: np.ndarray) -> float:
        levels = (float(np.max(part)) for part in self._parts(values))
        return self.mean_cost_of(values) + sum(levels)

    def mean_cost_of(self, values: np.ndarray) -> float:
        """The part of the cost that is a weighted sum [SI]: all but the worst cases."""
        return float(self.rows.weights[self._used] @ values[self._used])

    def _parts(self, values: np.ndarray) -> list[np.ndarray]:
        used = self._used
        return [group[:, used] @ values[used] for group in self.rows.worst]

    def _cost_slope(self, values: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
        slope = self.rows.weights @ jacobian
        for group, part in zip(self.rows.worst, self._parts(values), strict=True):
            slope = slope + group[np.argmax(part)] @ jacobian
        return slope

    def cost(self, point: Point) -> float:
        """Scaled cost, to be minimised."""
        return self._cost(point.values) / self.cost_scale

    def mean_cost(self, point: Point) -> float:
        """Scaled cost without the worst cases."""
        return self.mean_cost_of(point.values) / self.cost_scale

    def mean_cost_gradient(self, position: np.ndarray) -> np.ndarray:
        """Derivatives of the scaled cost without the worst cases."""
        return self.rows.weights @ self.jacobian(position) / self.cost_scale

    def cost_gradient(self, position: np.ndarray) -> np.ndarray:
        """Derivatives of the scaled cost; where worst cases tie, those of the first."""
        jacobian = self.jacobian(position)
        return self._cost_slope(self.point(position).values, jacobian) / self.cost_scale

    def worst_parts(self, point: Point) -> list[np.ndarray]:
        """Scaled cost of each worst-case objective at every operating point."""
        return [part / self.cost_scale for part in self._parts(point.values)]

    def worst_slopes(self, position: np.ndarray) -> list[np.ndarray]:
        """Derivatives of these costs (operating points × variables), objective by objective."""
        jacobian = self.jacobian(position)
        return [group @ jacobian / self.cost_scale for group in self.rows.worst]

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
