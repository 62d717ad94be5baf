"""Roots of a few equations at once, differentiable by the implicit function theorem."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..numerics import solve_small


def find_roots(
    function: Callable[[Float[Array, " n"]], Float[Array, " n"]],
    guess: Float[Array, " n"],
    *,
    tolerance: float | Float[Array, ""],
    max_steps: int,
) -> tuple[Float[Array, " n"], Bool[Array, ""]]:
    """Roots of a few functions of as many numbers, by Newton.

    The equations are traced once, with their derivatives, in one loop: a nest of single roots would
    trace them over and over.

    **Arguments:**

    - `function`: the residuals, which should depend on their own unknown the most; may close over
      traced numbers, with respect to which the roots are differentiable in either mode.
    - `guess`: where to start.
    - `tolerance`: on the last change of the unknowns, relative and absolute; what is left is about
      its square.
    - `max_steps`: steps allowed.

    **Returns:** the roots (the last iterate where none were found), and whether they were found.
    """
    identity = jnp.eye(guess.size, dtype=guess.dtype)

    def search(residual, start):
        def step(carry):
            unknowns, _, count = carry
            value, linear = jax.linearize(residual, unknowns)
            change = solve_small(jax.vmap(linear, out_axes=-1)(identity))(value)
            size = jnp.max(jnp.abs(change) / (1 + jnp.abs(unknowns)))
            return unknowns - change, size, count + 1

        def goes_on(carry):
            return (carry[1] > tolerance) & (carry[2] < max_steps)

        first = (start, jnp.full((), jnp.inf, start.dtype), 0)
        unknowns, size, _ = jax.lax.while_loop(goes_on, step, first)
        return unknowns, (size <= tolerance).astype(start.dtype)

    def solve(linear, right):
        return solve_small(jax.vmap(linear, out_axes=-1)(identity))(right)

    roots, found = jax.lax.custom_root(
        function, jax.lax.stop_gradient(guess), search, solve, has_aux=True
    )
    return roots, found > 0.5
