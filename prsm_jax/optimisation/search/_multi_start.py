"""Many starts at once: a first-order search of a whole batch, then the best few one by one."""

from dataclasses import dataclass, field
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ._constrained import Slsqp
from ._evaluator import Evaluator
from ._functions import SearchFunctions
from ._method import Report, SearchMethod, SearchResult, WithOptions, check_at_least
from ._optax import optax_promotion
from ._outputs import outputs_at

#: Cost of a violation of one scaled constraint, over that of the scaled objective.
_PENALTY = 10.0
#: Designs nearer than this, in units of the box, count as one start.
_APART = 0.05


def _penalised(inputs: tuple[Any, ...], rows: dict[str, Any], position: Float[Array, " variables"]):
    """Scaled cost with violations added, infinite where a design fails."""
    outputs, valid = outputs_at(inputs, position)
    total, first = jnp.zeros(()), 0
    levels = [jnp.zeros(group.shape[0]) for group in rows["worst"]]
    for numbers in outputs:
        part = slice(first, first + numbers.shape[0])
        first += numbers.shape[0]
        scaled = numbers / rows["scale"][part]
        below = rows["lower"][part] - scaled
        above = scaled - rows["upper"][part]
        used = rows["used"][part]
        broken = jnp.maximum(jnp.maximum(below, above), 0.0)
        # A number that is not used may have any value, also NaN.
        total += jnp.sum(jnp.where(used, rows["weights"][part] * numbers, 0.0))
        total += _PENALTY * jnp.sum(jnp.where(used, broken, 0.0))
        known = jnp.where(used, numbers, 0.0)
        levels = [
            level + group[:, part] @ known
            for level, group in zip(levels, rows["worst"], strict=True)
        ]
    for level in levels:
        total += jnp.max(level)
    return jnp.where(valid & jnp.isfinite(total), total, jnp.inf)


@eqx.filter_jit
def _descend(
    inputs: tuple[Any, ...],
    rows: dict[str, Any],
    positions: Float[Array, "starts variables"],
    rate: Float[Array, ""],
    steps: int,
):
    """The best position of each start after some steps of Adam, and its penalised cost."""
    import optax

    schedule = optax.cosine_decay_schedule(1.0, steps)
    adam = optax.scale_by_adam()

    def cost_and_slope(position):
        cost, push = jax.linearize(lambda point: _penalised(inputs, rows, point), position)
        slope = jax.vmap(push)(jnp.eye(position.shape[0], dtype=position.dtype))
        # A design that fails has no derivative; 0 replaces it.
        good = jnp.isfinite(cost) & jnp.isfinite(slope).all()
        return cost, jnp.where(good, slope, 0.0)

    def one_step(carry, count):
        position, state, best, least = carry
        costs, slopes = jax.vmap(cost_and_slope)(position)
        better = costs < least
        best = jnp.where(better[:, None], position, best)
        least = jnp.where(better, costs, least)
        with optax_promotion():
            direction, state = adam.update(slopes, state, position)
            moved = position - rate * schedule(count) * jnp.asarray(direction)
            moved = optax.projections.projection_box(moved, 0.0, 1.0)
        # A design that fails is moved to the middle between it and the best one.
        moved = jnp.where(jnp.isfinite(costs)[:, None], moved, (position + best) / 2)
        return (moved, state, best, least), None

    with optax_promotion():
        state = adam.init(positions)
    least = jnp.full(positions.shape[0], jnp.inf, positions.dtype)
    start = (positions, state, positions, least)
    (_, _, best, least), _ = jax.lax.scan(one_step, start, jnp.arange(steps))
    return best, least


@dataclass(frozen=True)
class MultiStart(WithOptions):
    """Adam (optax) from all starts of the problem at once, then another search from the best few.

    One compiled program moves all starts; violations of constraints count as cost there. The best
    designs that are apart from each other are the starts of `finish`, which respects constraints.
    Only these searches are runs of the result; evaluations are those of both.

    **Arguments:**

    - `steps`: of Adam, from each start.
    - `learning_rate`: the first one, in units of the box; it decays to zero as a cosine.
    - `keep`: number of designs from which `finish` searches.
    - `finish`: the search from these; default `Slsqp()`.

    **Raises:** `ValueError` for an option out of range, or one that the method does not take.
    """

    word = "multi-start"
    accepts_constraints = True
    chooses_starts = True
    steps: int = 30
    learning_rate: float = 0.05
    keep: int = 3
    finish: SearchMethod = field(default_factory=Slsqp)

    def __post_init__(self) -> None:
        check_at_least(1, steps=self.steps, keep=self.keep)
        if not 0 < self.learning_rate < np.inf:
            raise ValueError(f"learning_rate is {self.learning_rate}; it must be above 0")
        if not self.finish.accepts_constraints:
            raise ValueError(
                f"finish is {self.finish.name!r}, which accepts bounds only; give one that accepts "
                "constraints, such as Slsqp()"
            )

    def search(
        self, functions: SearchFunctions, start: np.ndarray, tolerance: float, report: Report
    ) -> SearchResult:
        return self.finish.search(functions, start, tolerance, report)

    def chosen(self, evaluator: Evaluator, positions: np.ndarray) -> list[np.ndarray]:
        """The best designs after the first search, apart from each other.

        The first of `positions` alone if every start fails.

        **Arguments:**

        - `evaluator`: the design problem, with its scales.
        - `positions`: in the unit box, starts × variables.
        """
        improved, costs = _descend(
            evaluator.program_inputs,
            _rows(evaluator),
            jnp.asarray(positions),
            jnp.asarray(self.learning_rate),
            self.steps,
        )
        evaluator.evaluations += len(positions) * self.steps
        evaluator.derivative_evaluations += len(positions) * self.steps
        improved, costs = np.asarray(improved), np.asarray(costs)
        kept: list[np.ndarray] = []
        for index in np.argsort(costs, kind="stable"):
            if not np.isfinite(costs[index]) or len(kept) == self.keep:
                break
            if all(np.max(np.abs(improved[index] - other)) > _APART for other in kept):
                kept.append(improved[index])
        return kept or [np.asarray(positions[0])]


def _rows(evaluator: Evaluator) -> dict[str, Any]:
    """Weights, scales and limits of each evaluated number; no limit where it has no constraint."""
    rows, count = evaluator.rows, len(evaluator.rows.weights)
    lower, upper = np.full(count, -np.inf), np.full(count, np.inf)
    scale, used = np.ones(count), rows.weights != 0
    for group in rows.worst:
        used |= np.any(group != 0, axis=0)
    for place, low, high, size in zip(
        rows.index, rows.lower, rows.upper, evaluator.row_scale, strict=True
    ):
        lower[place], upper[place] = max(lower[place], low), min(upper[place], high)
        scale[place], used[place] = size, True
    return {
        "weights": jnp.asarray(rows.weights / evaluator.cost_scale),
        "scale": jnp.asarray(scale),
        "lower": jnp.asarray(lower / scale),
        "upper": jnp.asarray(upper / scale),
        "used": jnp.asarray(used),
        "worst": [jnp.asarray(group / evaluator.cost_scale) for group in rows.worst],
    }
