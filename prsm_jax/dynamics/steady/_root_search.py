"""Roots of a few equations at once, differentiable by the implicit function theorem."""

import functools
from collections.abc import Callable
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero
from jax.extend.core import ClosedJaxpr, jaxpr_as_fun
from jaxtyping import Array, Bool, Float

from ...numerics import in_pieces, max_few, solve_small

_Known = TypeVar("_Known")


def find_roots(
    function: Callable[[Float[Array, " n"]], Float[Array, " n"]],
    guess: Float[Array, " n"],
    *,
    tolerance: float | Float[Array, ""],
    max_steps: int,
) -> tuple[Float[Array, " n"], Bool[Array, ""]]:
    """Roots of a few functions of as many numbers, by Newton.

    The equations are traced once, with their derivatives, in one loop; nested searches for
    single roots would trace them repeatedly.

    **Arguments:**

    - `function`: the residuals, each of which should depend mostly on its own unknown; may close
      over traced numbers, with respect to which the roots are differentiable in either mode.
    - `guess`: where to start.
    - `tolerance`: on the last change of the unknowns, relative and absolute; the remaining error is
      about its square.
    - `max_steps`: steps allowed.

    **Returns:** the roots (the last iterate where none were found), and whether they were found.
    """
    roots, converged, _ = find_roots_and(
        lambda unknowns: (function(unknowns), None), guess, tolerance=tolerance, max_steps=max_steps
    )
    return roots, converged


def find_roots_and(
    function: Callable[[Float[Array, " n"]], tuple[Float[Array, " n"], _Known]],
    guess: Float[Array, " n"],
    *,
    tolerance: float | Float[Array, ""],
    max_steps: int,
) -> tuple[Float[Array, " n"], Bool[Array, ""], _Known]:
    """As `find_roots`, with further results at the roots.

    The derivatives of both come from one linearisation at the root; a second evaluation there would
    have to be differentiated, too.

    **Arguments:**

    - `function`: gives the residuals, and a pytree of arrays.
    - `guess`, `tolerance`, `max_steps`: as in `find_roots`.

    **Returns:** the roots, whether they were found, and the pytree at the roots.
    """
    structure = []

    def flat(unknowns):
        residual, known = function(unknowns)
        leaves, tree = jax.tree.flatten(known)
        structure[:] = tree, [leaf.dtype for leaf in leaves]
        # Integers and booleans have no derivative: they pass as real numbers.
        return [residual, *(leaf.astype(residual.dtype) for leaf in leaves)]

    start = jax.lax.stop_gradient(guess)
    closed = jax.make_jaxpr(flat)(start)
    equations = _Equations(closed)
    small = jnp.asarray(tolerance, start.dtype)
    roots, converged, leaves = _solved(equations, max_steps, closed.consts, start, small)
    tree, dtypes = structure
    leaves = [leaf.astype(dtype) for leaf, dtype in zip(leaves, dtypes, strict=True)]
    return roots, converged > 0.5, jax.tree.unflatten(tree, leaves)


class _Equations:
    """Residuals and further results, traced once; what they close over is `constants`."""

    def __init__(self, traced: ClosedJaxpr) -> None:
        jaxpr = traced.jaxpr
        inputs = [*jaxpr.constvars, *jaxpr.invars]
        self._traced = ClosedJaxpr(jaxpr.replace(constvars=[], invars=inputs), ())

    def __call__(self, constants, unknowns) -> list[Any]:
        """Residuals and further results.

        Those that do not depend on anything may be numbers of Python or NumPy.
        """
        return jaxpr_as_fun(self._traced)(*constants, unknowns)

    def in_pieces(self, constants, unknowns) -> list[Array]:
        """The same values, cut for derivatives, which take several times as many operations."""
        return self._cut(*constants, unknowns)

    @functools.cached_property
    def _cut(self) -> Callable[..., list[Array]]:
        return in_pieces(self._traced)


@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1))
def _solved(equations, max_steps, constants, guess, tolerance):
    """Roots, 1 where they were found and 0 elsewhere, and the further results."""
    identity = jnp.eye(guess.size, dtype=guess.dtype)

    def step(carry):
        unknowns, _, count = carry
        value, linear = jax.linearize(lambda x: equations(constants, x)[0], unknowns)
        change = solve_small(jax.vmap(linear, out_axes=-1)(identity))(value)
        size = max_few(jnp.abs(change) / (1 + jnp.abs(unknowns)))
        return unknowns - change, size, count + 1

    def goes_on(carry):
        return (carry[1] > tolerance) & (carry[2] < max_steps)

    first = (guess, jnp.full((), jnp.inf, guess.dtype), 0)
    roots, size, _ = jax.lax.while_loop(goes_on, step, first)
    # JAX requires that a number and its derivative are both batched, or neither. A result that is
    # the same in a whole batch has a batched derivative, because the roots are batched.
    of_batch = size == size
    known = [jnp.where(of_batch, leaf, leaf) for leaf in equations.in_pieces(constants, roots)[1:]]
    return roots, (size <= tolerance).astype(guess.dtype), known


@functools.partial(_solved.defjvp, symbolic_zeros=True)
def _solved_derivative(equations, max_steps, primals, tangents):
    constants, guess, tolerance = primals
    roots, converged, known = _solved(equations, max_steps, constants, guess, tolerance)
    # Constants without a tangent are not differentiated.
    moving = [
        i
        for i, (value, change) in enumerate(zip(constants, tangents[0], strict=True))
        if jnp.issubdtype(value.dtype, jnp.inexact) and not isinstance(change, SymbolicZero)
    ]
    zero = jnp.zeros_like(converged)
    if not moving:
        zeros = [jnp.zeros_like(leaf) for leaf in known]
        return (roots, converged, known), (jnp.zeros_like(roots), zero, zeros)

    def at_roots(moved):
        new = dict(zip(moving, moved, strict=True))
        changed = [new.get(i, value) for i, value in enumerate(constants)]
        return equations.in_pieces(changed, roots)

    def of_one(direction):
        return jax.jvp(lambda x: equations.in_pieces(constants, x), (roots,), (direction,))[1]

    moves = [tangents[0][i] for i in moving]
    _, (residual_change, *changes) = jax.jvp(at_roots, ([constants[i] for i in moving],), (moves,))
    slopes, *known_slopes = jax.vmap(of_one, out_axes=-1)(jnp.eye(roots.size, dtype=roots.dtype))
    root_change = -solve_small(slopes)(residual_change)
    changes = [
        change + slope @ root_change for change, slope in zip(changes, known_slopes, strict=True)
    ]
    return (roots, converged, known), (root_change, zero, changes)
