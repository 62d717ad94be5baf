"""Roots of one number or of a pair, with derivatives by the implicit function theorem.

Newton's method in a few lines rather than a library's: `jax.lax.custom_root` with Cramer's rule
leaves no host callback in the program (a library's linear solve raises through one when a design is
singular, which would end a whole batch, and keeps the program out of JAX's persistent compilation
cache), and roots are traced in nearly every program here: this is three times as fast to trace, and
twice as fast to run.
"""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float


def _solve_linear(linear: Callable, right: Float[Array, "..."]) -> Float[Array, "..."]:
    """Solve `linear(x) = right` for a number or a pair of numbers; not finite if singular."""
    if right.ndim == 0:
        return right / linear(jnp.ones_like(right))
    first, second = (
        linear(jnp.asarray([1, 0], right.dtype)),
        linear(jnp.asarray([0, 1], right.dtype)),
    )
    determinant = first[0] * second[1] - second[0] * first[1]
    return (
        jnp.stack(
            [
                second[1] * right[0] - second[0] * right[1],
                first[0] * right[1] - first[1] * right[0],
            ]
        )
        / determinant
    )


def find_root(
    function: Callable[[Float[Array, "..."]], Float[Array, "..."]],
    guess: Float[Array, "..."],
    *,
    tolerance: float,
    max_steps: int,
) -> tuple[Float[Array, "..."], Bool[Array, ""]]:
    """Root of a function of one number or of a pair, by Newton; differentiable in closures.

    **Arguments:**

    - `function`: the residual; may close over traced numbers, with respect to which the root is
      differentiable in forward and reverse mode, to any order.
    - `guess`: where to start; a number or an array of two.
    - `tolerance`: absolute and relative, on the unknown, which should be of order one.
    - `max_steps`: Newton steps allowed.

    **Returns:** the root (the last iterate where none was found), and whether it was found.
    """

    def search(residual, start):
        def advance(carry):
            unknown, size, _, steps = carry
            value, linear = jax.linearize(residual, unknown)
            step = _solve_linear(linear, value)
            following = unknown - step
            largest = jnp.max(jnp.abs(step) / (1 + jnp.abs(following)))
            # What is still missing shrinks at least as fast as the steps did; nobody knows that of
            # the first.
            rate = jnp.where(steps > 0, largest / size, 0.5)
            left = largest * jnp.where(rate < 0.5, rate / (1 - rate), 1.0)
            return following, largest, left, steps + 1

        def goes_on(carry):
            # Not a number compares as done; it is then not found either.
            return (carry[2] > tolerance) & (carry[3] < max_steps)

        far = jnp.full((), jnp.inf, start.dtype)
        value, _, left, _ = jax.lax.while_loop(goes_on, advance, (start, far, far, 0))
        return value, (left <= tolerance).astype(start.dtype)

    root, found = jax.lax.custom_root(
        function, jax.lax.stop_gradient(guess), search, _solve_linear, has_aux=True
    )
    return root, found > 0.5
