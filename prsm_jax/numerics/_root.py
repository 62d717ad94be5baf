"""Roots of one number, with derivatives by the implicit function theorem.

Newton's method in a few lines instead of a library: there is no host callback in the program. The
linear solve of a library raises errors through one if a design is singular, which would end a whole
batch, and keeps the program out of JAX's persistent compilation cache. Roots are traced in nearly
every program here: this is three times as fast to trace, and twice as fast to run.
"""

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero
from jax.extend.core import ClosedJaxpr, jaxpr_as_fun
from jaxtyping import Array, Bool

from ._types import Scalar


def _search(
    evaluate: Callable[[Scalar], tuple[Scalar, Scalar]],
    start: Scalar,
    tolerance: float,
    max_steps: int,
) -> tuple[Scalar, Scalar]:
    """Newton's method from `start`; the root, and 1 if it converged, else 0."""

    def advance(carry):
        unknown, before, _, steps = carry
        value, derivative = evaluate(unknown)
        step = value / derivative
        following = unknown - step
        size = jnp.abs(step) / (1 + jnp.abs(following))
        # The remaining error shrinks at least as fast as the steps; rate unknown after the first
        # step.
        rate = size / before
        error = jnp.where(rate < 0.5, size * rate / (1 - rate), size)
        return following, size, error, steps + 1

    def goes_on(carry):
        # NaN ends the search, and does not count as converged.
        return (carry[2] > tolerance) & (carry[3] < max_steps)

    zero = jnp.zeros((), start.dtype)
    begin = (start, zero, zero + jnp.inf, jnp.zeros((), jnp.int32))
    root, _, error, _ = jax.lax.while_loop(goes_on, advance, begin)
    return root, (error <= tolerance).astype(start.dtype)


def find_root(
    function: Callable[[Scalar], Scalar], guess: Scalar, *, tolerance: float, max_steps: int
) -> tuple[Scalar, Bool[Array, ""]]:
    """Root of a function of one number, by Newton's method; differentiable in closures.

    **Arguments:**

    - `function`: the residual; may close over traced numbers, with respect to which the root is
      differentiable in forward and reverse mode, to any order.
    - `guess`: starting value.
    - `tolerance`: absolute and relative, on the unknown, which should be of order one.
    - `max_steps`: Newton steps allowed.

    **Returns:** the root (the last iterate if not converged), and whether it converged.
    """
    # Traced once: closed-over values become the arguments of the root.
    closed = jax.make_jaxpr(function)(guess)
    jaxpr = closed.jaxpr

    def residual(constants, unknown):
        (value,) = jaxpr_as_fun(ClosedJaxpr(jaxpr, constants))(unknown)
        return value

    def with_derivative(constants, unknown):
        return jax.jvp(lambda x: residual(constants, x), (unknown,), (jnp.ones_like(unknown),))

    start = jax.lax.stop_gradient(guess)
    root, converged = _root(residual, with_derivative, tolerance, max_steps, closed.consts, start)
    return root, converged > 0.5


def find_root_of(
    residual: Callable[[Any, Scalar], tuple[Scalar, Scalar]],
    arguments: Any,
    guess: Scalar,
    *,
    tolerance: float,
    max_steps: int,
) -> tuple[Scalar, Bool[Array, ""]]:
    """Root of a residual with known derivative; half the program size of `find_root`.

    **Arguments:**

    - `residual`: function of the arguments and the unknown; its value, and its derivative with
      respect to the unknown. It must be a function of a module, not a closure: the root is
      differentiable with respect to the arguments only, in forward and reverse mode, to any order.
    - `arguments`: the arguments of the residual.
    - `guess`, `tolerance`, `max_steps`: as in `find_root`.

    **Returns:** the root (the last iterate if not converged), and whether it converged.
    """
    root, converged = _root(
        lambda arguments, unknown: residual(arguments, unknown)[0],
        residual,
        tolerance,
        max_steps,
        arguments,
        jax.lax.stop_gradient(guess),
    )
    return root, converged > 0.5


@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2, 3))
def _root(residual, with_derivative, tolerance, max_steps, arguments, guess):
    return _search(lambda x: with_derivative(arguments, x), guess, tolerance, max_steps)


@functools.partial(_root.defjvp, symbolic_zeros=True)
def _root_derivative(residual, with_derivative, tolerance, max_steps, primals, tangents):
    arguments, guess = primals
    root, converged = _root(residual, with_derivative, tolerance, max_steps, arguments, guess)
    leaves, structure = jax.tree.flatten(arguments)
    changes = structure.flatten_up_to(tangents[0])
    # Constant numbers are not differentiated: half the program size if one of eight varies.
    varying = [
        i
        for i, (leaf, change) in enumerate(zip(leaves, changes, strict=True))
        if jnp.issubdtype(leaf.dtype, jnp.inexact) and not isinstance(change, SymbolicZero)
    ]
    if not varying:
        return (root, converged), (jnp.zeros_like(root), jnp.zeros_like(converged))

    def at_root(values, unknown):
        new = dict(zip(varying, values, strict=True))
        leaves_there = [new.get(i, x) for i, x in enumerate(leaves)]
        return residual(structure.unflatten(leaves_there), unknown)

    # One reverse pass gives all partial derivatives of the residual; a forward one would give the
    # sum, and a second one the slope.
    partials, slope = jax.grad(at_root, argnums=(0, 1))([leaves[i] for i in varying], root)
    products = [part * changes[i] for i, part in zip(varying, partials, strict=True)]
    change = functools.reduce(jnp.add, (jnp.sum(x) if x.ndim else x for x in products))
    return (root, converged), (-change / slope, jnp.zeros_like(converged))
