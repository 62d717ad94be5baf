"""The best designs of all sizes in one batch: SLSQP in step, by gradients of the whole chain.

The smallest of three gains has kinks. With one more variable t the problem is smooth: maximise t,
with every gain at least t. One search for each number of starts that a size may have.
"""

import dataclasses
import time
from collections.abc import Callable, Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.mechanism import Mechanism

from .lockstep import searched_together
from .problem import (
    FEWEST_ROLLERS,
    LOWER,
    MEASURES,
    OBJECTIVES,
    SIGNS,
    UPPER,
    VARIABLES,
    Size,
    dimensioned,
    limits_of,
    measured,
    varied,
)

#: Searches begin at the size's own values, and in the unit box here, with one roller less.
_SECOND_START = (0.4, 0.2, 0.8)
#: Tolerance of SLSQP, for t and for the sum of violated constraints.
_TOLERANCE = 1e-9
#: A number of rollers nearer to a whole one than this is whole.
_WHOLE = 1e-6
#: Largest violation of a limit, as the logarithm of a ratio, and slack of an active one.
FEASIBLE = 1e-7
#: Gains of a design whose threads do not mesh.
_FAILED = -10.0


@dataclasses.dataclass(frozen=True)
class Task:
    """One search: a size, one number of starts, and what is allowed."""

    size: Size
    starts: int
    mechanism: Mechanism
    lower: np.ndarray
    upper: np.ndarray
    limits: np.ndarray

    @property
    def own(self) -> np.ndarray:
        """The size's own values of the variables; as many rollers as fit."""
        return np.array([np.pi / 4, 1.0, 1.0, self.upper[3]])

    def unit(self, variables: np.ndarray) -> np.ndarray:
        """Position in the unit box."""
        width = np.where(self.upper > self.lower, self.upper - self.lower, 1.0)
        return (variables - self.lower) / width

    def physical(self, position: np.ndarray) -> np.ndarray:
        """Values of the variables at a position in the unit box."""
        return self.lower + (self.upper - self.lower) * position

    def with_rollers(self, count: float) -> "Task":
        """The same with a fixed number of rollers."""
        ends = (np.append(end[:3], count) for end in (self.lower, self.upper))
        return dataclasses.replace(self, lower=next(ends), upper=next(ends))


@dataclasses.dataclass(frozen=True)
class Found:
    """The end of a search."""

    task: Task
    variables: np.ndarray
    measures: np.ndarray
    objective: float
    violation: float
    kkt_residual: float
    #: Names of active limits and bounds.
    active: tuple[str, ...]


def stacked(mechanisms: Sequence[Mechanism]) -> Mechanism:
    """Mechanisms of one structure as a batch, with their numbers of rollers as numbers."""
    counted = [
        eqx.tree_at(lambda m: m.stages[0].roller_count, one, float(one.stages[0].roller_count))
        for one in mechanisms
    ]
    return jax.tree.map(lambda *leaves: jnp.stack([jnp.asarray(leaf) for leaf in leaves]), *counted)


@eqx.filter_jit
def _values_and_slopes(mechanisms: Mechanism, lower: Any, width: Any, positions: Any):
    """Logarithms of measures, their derivatives by position, and which designs are usable."""

    def one(mechanism, lower, width, position):
        def logarithms(place):
            values, good = measured(varied(mechanism, lower + width * place))
            return jnp.log(values), good

        values, push, good = jax.linearize(logarithms, position, has_aux=True)
        slopes = jax.vmap(push, out_axes=-1)(jnp.eye(position.shape[0], dtype=position.dtype))
        return values, slopes, good & jnp.isfinite(values).all() & jnp.isfinite(slopes).all()

    return jax.vmap(one)(mechanisms, lower, width, positions)


@eqx.filter_jit
def measured_together(mechanisms: Mechanism, index: Any, variables: Any):
    """Measures of many designs, and which are usable.

    **Arguments:**

    - `mechanisms`: a batch of whole length.
    - `index`: which of them each design has.
    - `variables`: designs × `VARIABLES`.
    """

    def one(index, variables):
        mechanism = jax.tree.map(lambda leaf: leaf[index], mechanisms)
        return measured(varied(mechanism, variables))

    return jax.vmap(one)(index, variables)


def tasks_of(
    sizes: Sequence[Size], loss: float, flattest: float = UPPER[1]
) -> tuple[list[Task], np.ndarray]:
    """A search for each size and number of starts, and the measures of the sizes' own designs."""
    made = [(size, n, dimensioned(size, n)) for size in sizes for n in size.choices]
    own = {size.name: m for size, n, m in made if n == size.starts}
    counts = {name: float(m.stages[0].roller_count) for name, m in own.items()}
    variables = jnp.asarray([[np.pi / 4, 1.0, 1.0, counts[size.name]] for size in sizes])
    batch = stacked([own[size.name] for size in sizes])
    starts = np.asarray(measured_together(batch, jnp.arange(len(sizes)), variables)[0])
    limits = {
        size.name: limits_of(start, _load(own[size.name]), loss)
        for size, start in zip(sizes, starts, strict=True)
    }
    tasks = [
        Task(
            size,
            n,
            mechanism,
            np.array([*LOWER, FEWEST_ROLLERS]),
            np.array([UPPER[0], flattest, UPPER[2], float(mechanism.stages[0].roller_count)]),
            limits[size.name],
        )
        for size, n, mechanism in made
    ]
    return tasks, starts


def _load(mechanism: Mechanism) -> float:
    assert mechanism.operating_point is not None
    return float(mechanism.operating_point.load)


def _evaluation(tasks: Sequence[Task]) -> Callable[[np.ndarray], tuple[np.ndarray, ...]]:
    """Gains over the limits, and their slopes by position, of one design for each task."""
    mechanisms = stacked([task.mechanism for task in tasks])
    lower = np.stack([task.lower for task in tasks])
    width = np.stack([task.upper for task in tasks]) - lower
    limits = np.log(np.stack([task.limits for task in tasks]))

    def answer(positions: np.ndarray) -> tuple[np.ndarray, ...]:
        values, slopes, good = map(
            np.asarray, _values_and_slopes(mechanisms, lower, width, jnp.asarray(positions))
        )
        bad = ~good
        gain = np.where(bad[:, None], _FAILED, SIGNS * (values - limits))
        slope = np.where(bad[:, None, None], 0.0, SIGNS[:, None] * slopes)
        return gain, slope

    return answer


#: Share of t in each gain.
_OF_T = np.array([1.0 if name in OBJECTIVES else 0.0 for name in MEASURES])


def _search(task: Task, ask: Callable[[np.ndarray], tuple[np.ndarray, ...]]) -> Found:
    """The best end of SLSQP from two starts."""
    from scipy.optimize import minimize

    last: dict[str, Any] = {"at": None}

    def at(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if last["at"] is None or not np.array_equal(last["at"], x[:-1]):
            # SLSQP writes into its vector.
            last.update(at=x[:-1].copy(), of=ask(x[:-1]))
        return last["of"]

    count = len(VARIABLES)
    upwards = np.append(np.zeros(count), -1.0)
    margins = {
        "type": "ineq",
        "fun": lambda x: at(x)[0] - _OF_T * x[-1],
        "jac": lambda x: np.concatenate([at(x)[1], -_OF_T[:, None]], axis=1),
    }
    box = np.where(task.upper > task.lower, 1.0, 0.0)
    bounds = [(0.0, end) for end in box] + [(-5.0, 5.0)]
    fewer = box[3] * max(0.0, 1 - 1 / max(task.upper[3] - task.lower[3], 1.0))
    best: Found | None = None
    for start in (task.unit(task.own) * box, np.append(_SECOND_START, fewer)):
        first = at(np.append(start, 0.0))[0]
        found = minimize(
            lambda x: -x[-1],
            np.append(start, np.min(first[: len(OBJECTIVES)])),
            jac=lambda _: upwards,
            bounds=bounds,
            constraints=[margins],
            method="SLSQP",
            options={"ftol": _TOLERANCE, "maxiter": 40},
        )
        one = _judged(task, found.x[:-1], at(found.x), box)
        if best is None or _rank(one) > _rank(best):
            best = one
    assert best is not None
    return best


def _rank(found: Found) -> tuple[bool, float]:
    """Feasible before better."""
    return found.violation <= FEASIBLE, found.objective


def _judged(
    task: Task, position: np.ndarray, at: tuple[np.ndarray, np.ndarray], box: np.ndarray
) -> Found:
    """The end of a search, with the residual of the conditions of Karush, Kuhn and Tucker.

    The residual is the largest component of the gradient of the Lagrangian by t and the unit box,
    with the best multipliers of active limits and bounds.
    """
    from scipy.optimize import nnls

    gain, slope = at
    objective = float(np.min(gain[: len(OBJECTIVES)]))
    columns, names = [], []
    for name, value, row, share in zip(MEASURES, gain, slope, _OF_T, strict=True):
        if value - share * objective < FEASIBLE:
            columns.append(np.append(row, -share))
            names.append(name)
    for i, variable in enumerate(VARIABLES):
        for end, sign in ((0.0, 1.0), (1.0, -1.0)):
            # A fixed variable is at both of its bounds.
            if abs(position[i] - end * box[i]) < FEASIBLE:
                columns.append(sign * np.eye(len(VARIABLES) + 1)[i])
                names.append(f"{variable} {'lower' if sign > 0 else 'upper'}")
    upwards = np.append(np.zeros(len(VARIABLES)), -1.0)
    matrix = np.array(columns).T
    residual = np.max(np.abs(matrix @ nnls(matrix, upwards)[0] - upwards))
    measures = task.limits * np.exp(SIGNS * gain)
    return Found(
        task,
        task.physical(position),
        measures,
        objective,
        float(max(0.0, -np.min(gain[len(OBJECTIVES) :]))),
        float(residual),
        tuple(names),
    )


@dataclasses.dataclass(frozen=True)
class Batch:
    """All searches of one problem."""

    #: For each size, the best end for each number of starts.
    found: dict[str, list[Found]]
    #: Measures of the sizes' own designs (sizes × measures).
    starts: np.ndarray
    #: Evaluations, each with its derivatives, and compiled calls.
    evaluations: int
    calls: int
    #: Run times: of all searches, and before them of building the mechanisms [s].
    seconds: float
    building_s: float

    def best(self, size: Size, starts: int | None = None) -> Found:
        """The best feasible design of a size; with `starts`, that of this number of starts."""
        ends = [one for one in self.found[size.name] if starts in (None, one.task.starts)]
        return max(ends, key=_rank)


def solve(sizes: Sequence[Size], loss: float, flattest: float = UPPER[1]) -> Batch:
    """The best designs of all sizes.

    **Arguments:**

    - `sizes`: the sizes.
    - `loss`: allowed loss of efficiency.
    - `flattest`: upper bound of the ratio of profile radii.
    """
    begin = time.perf_counter()
    tasks, starts = tasks_of(sizes, loss, flattest)
    built = time.perf_counter()
    ends, evaluations, calls = _ends(tasks)
    divided = [
        one.task.with_rollers(count)
        for one in ends
        if abs(one.variables[3] - round(one.variables[3])) > _WHOLE
        for count in (np.floor(one.variables[3]), np.ceil(one.variables[3]))
    ]
    # A relaxed number of rollers is replaced by the whole ones beside it.
    ends = [one for one in ends if abs(one.variables[3] - round(one.variables[3])) <= _WHOLE]
    if divided:
        more, again, further = _ends(divided)
        ends, evaluations, calls = ends + more, evaluations + again, calls + further
    found: dict[str, list[Found]] = {size.name: [] for size in sizes}
    for one in ends:
        found[one.task.size.name].append(one)
    seconds = time.perf_counter() - built
    return Batch(found, starts, evaluations + len(sizes), calls, seconds, built - begin)


def _ends(tasks: Sequence[Task]) -> tuple[list[Found], int, int]:
    starts = np.stack([task.unit(task.own) for task in tasks])
    ends, shared = searched_together(
        lambda index, ask: _search(tasks[index], ask), _evaluation(tasks), starts
    )
    return ends, shared.questions, shared.calls
