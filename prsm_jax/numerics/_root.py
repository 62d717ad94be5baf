"""Roots of one number, with derivatives by the implicit function theorem.

Newton's method in a few lines rather than a library's: nothing here leaves a host callback in the
program (a library's linear solve raises through one when a design is singular, which would end a
whole batch, and keeps the program out of JAX's persistent compilation cache), and roots are traced
in nearly every program here: this is three times as fast to trace, and twice as fast to run.
"""

import functools
from collections.abc import Callable

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero
from jax.extend.core import ClosedJaxpr, jaxpr_as_fun
from jaxtyping import Array, Bool, PyTree

from ._types import Scalar


def _search(
    evaluate: Callable[[Scalar], tuple[Scalar, Scalar]],
    start: Scalar,
    tolerance: float,
    max_steps: int,
) -> tuple[Scalar, Scalar]:
    """Newton from `start` with values and derivatives; the root, and 1 if it was found, else 0."""

    def advance(carry):
        unknown, before, _, steps = carry
        value, derivative = evaluate(unknown)
        step = value / derivative
        following = unknown - step
        size = jnp.abs(step) / (1 + jnp.abs(following))
        # What is still missing shrinks at least as fast as the steps did; nobody knows that of
        # the first.
        rate = size / before
        left = jnp.where(rate < 0.5, size * rate / (1 - rate), size)
        return following, size, left, steps + 1

    def goes_on(carry):
        # Not a number compares as done; it is then not found either.
        return (carry[2] > tolerance) & (carry[3] < max_steps)

    nothing = jnp.zeros((), start.dtype)
    begin = (start, nothing, nothing + jnp.inf, jnp.zeros((), jnp.int32))
    root, _, left, _ = jax.lax.while_loop(goes_on, advance, begin)
    return root, (left <= tolerance).astype(start.dtype)


def find_root(
    function: Callable[[Scalar], Scalar], guess: Scalar, *, tolerance: float, max_steps: int
) -> tuple[Scalar, Bool[Array, ""]]:
    """Root of a function of one number, by Newton; differentiable in closures.

    **Arguments:**

    - `function`: the residual; may close over traced numbers, with respect to which the root is
      differentiable in forward and reverse mode, to any order.
    - `guess`: where to start.
    - `tolerance`: absolute and relative, on the unknown, which should be of order one.
    - `max_steps`: Newton steps allowed.

    **Returns:** the root (the last iterate where none was found), and whether it was found.
    """
    # Traced once: what the function closes over becomes the arguments of the root.
    closed = jax.make_jaxpr(function)(guess)
    jaxpr = closed.jaxpr

    def residual(constants, unknown):
        (value,) = jaxpr_as_fun(ClosedJaxpr(jaxpr, constants))(unknown)
        return value

    def with_derivative(constants, unknown):
        return jax.jvp(lambda x: residual(constants, x), (unknown,), (jnp.ones_like(unknown),))

    start = jax.lax.stop_gradient(guess)
    root, found = _root(residual, with_derivative, tolerance, max_steps, closed.consts, start)
    return root, found > 0.5


def find_root_of(
    residual: Callable[[PyTree, Scalar], tuple[Scalar, Scalar]],
    arguments: PyTree,
    guess: Scalar,
    *,
    tolerance: float,
    max_steps: int,
) -> tuple[Scalar, Bool[Array, ""]]:
    """Root of a residual whose derivative is known; half the program of `find_root`.

    **Arguments:**

    - `residual`: of the arguments and the unknown; the value and its derivative in the unknown.
      It must be a function of a module, not a closure: the root is differentiable with respect to
      the arguments only, in forward and reverse mode, to any order.
    - `arguments`: what the residual depends on.
    - `guess`, `tolerance`, `max_steps`: as in `find_root`.

    **Returns:** the root (the last iterate where none was found), and whether it was found.
    """
    root, found = _root(
        lambda arguments, unknown: residual(arguments, unknown)[0],
        residual,
        tolerance,
        max_steps,
        arguments,
        jax.lax.stop_gradient(guess),
    )
    return root, found > 0.5


@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2, 3))
def _root(residual, with_derivative, tolerance, max_steps, arguments, guess):
    return _search(lambda x: with_derivative(arguments, x), guess, tolerance, max_steps)


@functools.partial(_root.defjvp, symbolic_zeros=True)
def _root_derivative(residual, with_derivative, tolerance, max_steps, primals, tangents):
    arguments, guess = primals
    root, found = _root(residual, with_derivative, tolerance, max_steps, arguments, guess)
    leaves, structure = jax.tree.flatten(arguments)
    changes = structure.flatten_up_to(tangents[0])
    # Numbers that do not move are not differentiated: half the program where one of eight does.
    moving = [
        i
        for i, (leaf, change) in enumerate(zip(leaves, changes, strict=True))
        if jnp.issubdtype(leaf.dtype, jnp.inexact) and not isinstance(change, SymbolicZero)
    ]
    if not moving:
        return (root, found), (jnp.zeros_like(root), jnp.zeros_like(found))

    def at_root(moved):
        new = dict(zip(moving, moved, strict=True))
        return residual(structure.unflatten([new.get(i, x) for i, x in enumerate(leaves)]), root)

    _, slope = with_derivative(arguments, root)
    _, change = jax.jvp(at_root, ([leaves[i] for i in moving],), ([changes[i] for i in moving],))
    return (root, found), (-change / slope, jnp.zeros_like(found))
