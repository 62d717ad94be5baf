"""Steps along gradients, projected onto the box, with optax."""

from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ._functions import SearchFunctions
from ._method import Report, SearchResult, WithOptions, check_at_least


def projected(position: np.ndarray, gradient: np.ndarray) -> float:
    """Largest component of the projected gradient; one is 0 where a bound stops the descent."""
    return float(np.max(np.abs(position - np.clip(position - gradient, 0.0, 1.0))))


def optax_promotion():
    """Optax counts its steps in int32 and mixes them with int64, which strict promotion refuses."""
    return jax.numpy_dtype_promotion("standard")


def _one_step(transformation, gradient, state, position, cost):
    """Position and state after one step.

    Cost and gradient are passed a second time for transformations that ask for them by name.
    """
    import optax

    extended = optax.with_extra_args_support(transformation)
    with optax_promotion():
        update, state = extended.update(gradient, state, position, value=cost, grad=gradient)
        return optax.projections.projection_box(position + update, 0.0, 1.0), state


def _start(transformation, position):
    with optax_promotion():
        return transformation.init(position)


def _descend(
    transformation: Any,
    functions: SearchFunctions,
    start: np.ndarray,
    tolerance: float,
    maximum: int,
    report: Report,
) -> SearchResult:
    @eqx.filter_jit
    def advance(gradient, state, position, cost):
        return _one_step(transformation, gradient, state, position, cost)

    position = last = start
    state = _start(transformation, jnp.asarray(start))
    for iteration in range(1, maximum + 1):
        cost = functions.cost(position)
        if not functions.usable(position):
            # The steps do not depend on the cost, so they cannot be taken back.
            return SearchResult(last, "stopped before a design that fails", iteration)
        last = position
        gradient = functions.gradient(position)
        if projected(position, gradient) <= tolerance:
            return SearchResult(position, "projected gradient below tolerance", iteration)
        moved, state = advance(
            jnp.asarray(gradient), state, jnp.asarray(position), jnp.asarray(cost)
        )
        position = np.asarray(moved)
        report(position)
    return SearchResult(position, "iteration limit reached", maximum)


@dataclass(frozen=True)
class Adam(WithOptions):
    """Adam, projected onto the box, with a learning rate that decays to zero as a cosine.

    Accepts bounds, no constraints. Stops before a design that fails.

    **Arguments:**

    - `learning_rate`: the first one, in units of the box.
    - `max_iterations`: per start; the learning rate is zero after as many.

    **Raises:** `ValueError` for an option out of range, or one that the method does not take.
    """

    word = "adam"
    learning_rate: float = 0.05
    max_iterations: int = 2000

    def __post_init__(self):
        check_at_least(1, max_iterations=self.max_iterations)
        if not 0 < self.learning_rate < np.inf:
            raise ValueError(f"learning_rate is {self.learning_rate}; it must be above 0")

    def search(
        self, functions: SearchFunctions, start: np.ndarray, tolerance: float, report: Report
    ) -> SearchResult:
        import optax

        rate = optax.cosine_decay_schedule(self.learning_rate, self.max_iterations)
        return _descend(optax.adam(rate), functions, start, tolerance, self.max_iterations, report)


@dataclass(frozen=True)
class Optax(WithOptions):
    """Any gradient transformation of optax, projected onto the box after each step.

    Accepts bounds, no constraints. Stops before a design that fails.

    **Arguments:**

    - `transformation`: such as `optax.adam(1e-2)`, with steps in units of the box; one that asks
      for the cost (`value`) and the gradient (`grad`) gets them.
    - `max_iterations`: per start.

    **Raises:** `ValueError` if the transformation is not one of optax, or if it needs a function
    that it can trace, as a line search does.
    """

    transformation: Any
    max_iterations: int = 2000

    def __post_init__(self):
        import optax

        check_at_least(1, max_iterations=self.max_iterations)
        transformation = self.transformation
        if not isinstance(transformation, optax.GradientTransformation):
            raise ValueError(
                f"Optax: transformation is {transformation!r}; give one of optax, such as "
                "optax.adam(1e-2)"
            )

        def one_step(position):
            state = _start(transformation, position)
            return _one_step(transformation, position, state, position, position[0])

        try:
            jax.eval_shape(one_step, jnp.zeros(1))
        except TypeError as error:
            raise ValueError(
                "Optax: the transformation needs more than position, gradient and cost "
                f"({error}); give one without a line search, such as optax.lbfgs(linesearch=None)"
            ) from error

    def search(
        self, functions: SearchFunctions, start: np.ndarray, tolerance: float, report: Report
    ) -> SearchResult:
        return _descend(
            self.transformation, functions, start, tolerance, self.max_iterations, report
        )
