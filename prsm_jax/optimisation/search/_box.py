"""Searches within bounds, without constraints, with optax."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from ._evaluator import Guarded
from ._search import SearchResult

#: After this many halvings a step is below rounding.
_HALVINGS = 40
#: Share of the predicted decrease that a step has to achieve (Nocedal and Wright 2006, 3.1).
_SUFFICIENT = 1e-4
_LEARNING_RATE = 0.05


def _projected(position: np.ndarray, gradient: np.ndarray) -> float:
    """Largest component of the projected gradient; one is 0 where a bound stops the descent."""
    return float(np.max(np.abs(position - np.clip(position - gradient, 0.0, 1.0))))


def _optax_promotion():
    """Optax counts its steps in int32 and mixes them with int64, which strict promotion refuses."""
    return jax.numpy_dtype_promotion("standard")


def adam(
    functions: Guarded,
    start: np.ndarray,
    tolerance: float,
    maximum: int,
    report: Callable[[np.ndarray], None],
) -> SearchResult:
    """Adam, projected onto the box, with a learning rate that decays to zero as a cosine."""
    import optax

    optimiser = optax.adam(optax.cosine_decay_schedule(_LEARNING_RATE, maximum))

    @jax.jit
    def advance(gradient, state, position):
        with _optax_promotion():
            update, state = optimiser.update(gradient, state, position)
        return optax.projections.projection_box(position + update, 0.0, 1.0), state

    position = last = start
    state = optimiser.init(jnp.asarray(start))
    for iteration in range(1, maximum + 1):
        functions.cost(position)
        if not functions.evaluator.point(position).good:
            # Adam uses no function values, so it cannot step back and stops here.
            return SearchResult(last, "stopped before a design that fails", iteration)
        last = position
        gradient = functions.gradient(position)
        if _projected(position, gradient) <= tolerance:
            return SearchResult(position, "projected gradient below tolerance", iteration)
        moved, state = advance(jnp.asarray(gradient), state, jnp.asarray(position))
        position = np.asarray(moved)
        report(position)
    return SearchResult(position, "iteration limit reached", maximum)


def lbfgs(
    functions: Guarded,
    start: np.ndarray,
    tolerance: float,
    maximum: int,
    report: Callable[[np.ndarray], None],
) -> SearchResult:
    """L-BFGS on x = (1 − cos πz)/2, which maps all real z onto the box, bounds included.

    At a bound the slope in z is zero, so a start there is moved inside first.
    """
    import optax

    optimiser = optax.scale_by_lbfgs(memory_size=10)

    @jax.jit
    def precondition(slope, state, angle):
        with _optax_promotion():
            return optimiser.update(slope, state, angle)

    def position_of(angle: np.ndarray) -> np.ndarray:
        return (1 - np.cos(np.pi * angle)) / 2

    def slope_of(angle: np.ndarray, gradient: np.ndarray) -> np.ndarray:
        return gradient * np.pi / 2 * np.sin(np.pi * angle)

    inside = np.clip(start, 1e-2, 1 - 1e-2)
    if not functions.evaluator.point(inside).good:
        inside = start
    angle = np.arccos(1 - 2 * inside) / np.pi
    state = optimiser.init(jnp.asarray(angle))
    position = position_of(angle)
    cost = functions.cost(position)
    for iteration in range(1, maximum + 1):
        gradient = functions.gradient(position)
        if _projected(position, gradient) <= tolerance:
            return SearchResult(position, "projected gradient below tolerance", iteration)
        slope = slope_of(angle, gradient)
        scaled, state = precondition(jnp.asarray(slope), state, jnp.asarray(angle))
        direction = -np.asarray(scaled)
        if direction @ slope >= 0:
            direction, state = -slope, optimiser.init(jnp.asarray(angle))
        # A step longer than half the box makes no sense.
        direction = direction * min(1.0, 0.5 / max(float(np.max(np.abs(direction))), 1e-300))
        step = 1.0
        for _ in range(_HALVINGS):
            trial = angle + step * direction
            trial_cost = functions.cost(position_of(trial))
            good = functions.evaluator.point(position_of(trial)).good
            if good and trial_cost <= cost + _SUFFICIENT * step * float(direction @ slope):
                break
            step /= 2
        else:
            return SearchResult(position, "no further decrease along the direction", iteration)
        angle, cost = trial, trial_cost
        position = position_of(angle)
        report(position)
    return SearchResult(position, "iteration limit reached", maximum)
