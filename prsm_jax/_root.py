"""Roots of small systems, with derivatives by the implicit function theorem.

Optimistix searches; the derivatives are ours (`jax.lax.custom_root` with Cramer's rule) rather than
its implicit adjoint's, whose linear solve raises through a host callback when a design is singular:
one bad design would end a whole batch, and a program with a callback cannot be kept in JAX's
persistent compilation cache.
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
    import optimistix

    def search(residual, start):
        solution = optimistix.root_find(
            lambda unknown, _: residual(unknown),
            optimistix.Newton(rtol=tolerance, atol=tolerance),
            start,
            max_steps=max_steps,
            throw=False,
        )
        found = solution.result == optimistix.RESULTS.successful
        return solution.value, found.astype(start.dtype)

    root, found = jax.lax.custom_root(
        function, jax.lax.stop_gradient(guess), search, _solve_linear, has_aux=True
    )
    return root, found > 0.5
