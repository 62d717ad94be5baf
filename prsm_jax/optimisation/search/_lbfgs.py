"""L-BFGS within bounds, with optax's approximation of the Hessian."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from ._functions import SearchFunctions
from ._method import Report, SearchResult, WithOptions, check_at_least
from ._optax import optax_promotion, projected

#: After this many halvings a step is below rounding.
_HALVINGS = 40
#: Share of the predicted decrease that a step has to achieve (Nocedal and Wright 2006, 3.1).
_SUFFICIENT = 1e-4


@dataclass(frozen=True)
class Lbfgs(WithOptions):
    """L-BFGS on x = (1 − cos πz)/2, which maps all real z onto the box, bounds included.

    Accepts bounds, no constraints. At a bound the slope in z is zero, so a start there is moved
    inside first.

    **Arguments:**

    - `memory_size`: number of earlier steps that approximate the Hessian.
    - `max_iterations`: per start.

    **Raises:** `ValueError` for an option out of range, or one that the method does not take.
    """

    word = "lbfgs"
    memory_size: int = 10
    max_iterations: int = 500

    def __post_init__(self):
        check_at_least(1, memory_size=self.memory_size, max_iterations=self.max_iterations)

    def search(
        self, functions: SearchFunctions, start: np.ndarray, tolerance: float, report: Report
    ) -> SearchResult:
        import optax

        maximum = self.max_iterations
        optimiser = optax.scale_by_lbfgs(memory_size=self.memory_size)

        @jax.jit
        def precondition(slope, state, angle):
            with optax_promotion():
                return optimiser.update(slope, state, angle)

        def position_of(angle: np.ndarray) -> np.ndarray:
            return (1 - np.cos(np.pi * angle)) / 2

        def slope_of(angle: np.ndarray, gradient: np.ndarray) -> np.ndarray:
            return gradient * np.pi / 2 * np.sin(np.pi * angle)

        inside = np.clip(start, 1e-2, 1 - 1e-2)
        if not functions.usable(inside):
            inside = start
        angle = np.arccos(1 - 2 * inside) / np.pi
        state = optimiser.init(jnp.asarray(angle))
        position = position_of(angle)
        cost = functions.cost(position)
        for iteration in range(1, maximum + 1):
            gradient = functions.gradient(position)
            if projected(position, gradient) <= tolerance:
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
                good = functions.usable(position_of(trial))
                if good and trial_cost <= cost + _SUFFICIENT * step * float(direction @ slope):
                    break
                step /= 2
            else:
                return SearchResult(position, "no further decrease along the direction", iteration)
            angle, cost = trial, trial_cost
            position = position_of(angle)
            report(position)
        return SearchResult(position, "iteration limit reached", maximum)
