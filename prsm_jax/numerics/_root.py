"""Roots of one number, with derivatives by the implicit function theorem.

Newton's method in a few lines instead of a library: there is no host callback in the program. The
linear solve of a library raises errors through one if a design is singular, which would end a whole
batch, and keeps the program out of JAX's persistent compilation cache. Roots are traced in nearly
every program here: this is three times as fast to trace, and twice as fast to run.
"""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero
from jax.extend.core import ClosedJaxpr, jaxpr_as_fun
from jaxtyping import Array, Bool, Int

from ._types import Scalar

#: Least distance of the first two points of a search by secants.
_LEAST_SPACING = 1e-6


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

    def search(constants, start):
        return _search(lambda x: with_derivative(constants, x), start, tolerance, max_steps)

    root, converged = _root(residual, search, closed.consts, jax.lax.stop_gradient(guess))
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

    def value(arguments, unknown):
        return residual(arguments, unknown)[0]

    def search(arguments, start):
        return _search(lambda x: residual(arguments, x), start, tolerance, max_steps)

    root, converged = _root(value, search, arguments, jax.lax.stop_gradient(guess))
    return root, converged > 0.5


class FirstEvaluation(NamedTuple):
    """What a function was where a search began; without derivatives."""

    value: Scalar
    valid: Bool[Array, ""]


def find_root_by_secants(
    function: Callable[[Scalar], tuple[Scalar, Bool[Array, ""]]],
    guess: Scalar,
    second_guess: Callable[[Scalar], Scalar],
    *,
    tolerance: float,
    max_steps: int,
) -> tuple[Scalar, Bool[Array, ""], FirstEvaluation]:
    """Root of a function whose derivative is expensive, because it contains a search of its own.

    The search is one loop that evaluates the function and not its derivative, which Newton's method
    needs; it also returns the first value. The root is differentiable like that of `find_root`.

    **Arguments:**

    - `function`: the residual, and whether it is valid; may close over traced numbers.
    - `guess`: starting value.
    - `second_guess`: where to evaluate next, from the value there.
    - `tolerance`: on the last step, absolute and relative; the remaining error is about its product
      with the step before.
    - `max_steps`: evaluations allowed.

    **Returns:** the root, whether it was found with a valid function, and the first evaluation.
    """
    closed = jax.make_jaxpr(function)(guess)
    jaxpr = closed.jaxpr

    def evaluate(constants, unknown):
        return jaxpr_as_fun(ClosedJaxpr(jaxpr, constants))(unknown)

    def value(constants, unknown):
        return evaluate(constants, unknown)[0]

    def search(constants, start):
        def goes_on(carry):
            # NaN ends the search, and does not count as found.
            return (carry.size > tolerance) & (carry.steps < max_steps)

        def advance(carry):
            found, valid = evaluate(constants, carry.at)
            first = carry.steps == 0
            ahead = second_guess(found) - carry.at
            # Two equal points have no secant.
            ahead = jnp.where(jnp.abs(ahead) < _LEAST_SPACING, _LEAST_SPACING, ahead)
            secant = (found - carry.value_before) / (carry.at - carry.before)
            step = jnp.where(first, ahead, -found / secant)
            following = carry.at + step
            size = jnp.where(first, jnp.inf, jnp.abs(step) / (1 + jnp.abs(following)))
            return _Secants(
                following,
                carry.at,
                found,
                jnp.where(jnp.isnan(found), jnp.nan, size),
                valid,
                carry.steps + 1,
                jnp.where(first, found, carry.first_value),
                jnp.where(first, valid, carry.first_valid),
            )

        zero, no = jnp.zeros_like(start), jnp.asarray(False)
        begin = _Secants(
            start, start - 1, zero, zero + jnp.inf, no, jnp.zeros((), jnp.int32), zero, no
        )
        last = jax.lax.while_loop(goes_on, advance, begin)
        converged = (last.size <= tolerance) & last.valid
        of_real = [one.astype(start.dtype) for one in (converged, last.first_valid)]
        return last.at, of_real[0], last.first_value, of_real[1]

    root, converged, first, valid = _root(
        value, search, closed.consts, jax.lax.stop_gradient(guess)
    )
    return root, converged > 0.5, FirstEvaluation(first, valid > 0.5)


class _Secants(NamedTuple):
    """State of `find_root_by_secants`."""

    at: Scalar
    before: Scalar
    value_before: Scalar
    size: Scalar
    valid: Bool[Array, ""]
    steps: Int[Array, ""]
    first_value: Scalar
    first_valid: Bool[Array, ""]


@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1))
def _root(residual, search, arguments, guess):
    """The root, and further real numbers of the search that have no derivatives."""
    return search(arguments, guess)


@functools.partial(_root.defjvp, symbolic_zeros=True)
def _root_derivative(residual, search, primals, tangents):
    arguments, guess = primals
    root, *others = _root(residual, search, arguments, guess)
    no_change = [jnp.zeros_like(one) for one in others]
    leaves, structure = jax.tree.flatten(arguments)
    changes = structure.flatten_up_to(tangents[0])
    # Constant numbers are not differentiated: half the program size if one of eight varies.
    varying = [
        i
        for i, (leaf, change) in enumerate(zip(leaves, changes, strict=True))
        if jnp.issubdtype(leaf.dtype, jnp.inexact) and not isinstance(change, SymbolicZero)
    ]
    if not varying:
        return (root, *others), (jnp.zeros_like(root), *no_change)

    def at_root(values, unknown):
        new = dict(zip(varying, values, strict=True))
        leaves_there = [new.get(i, x) for i, x in enumerate(leaves)]
        return residual(structure.unflatten(leaves_there), unknown)

    # One reverse pass gives all partial derivatives of the residual; a forward one would give the
    # sum, and a second one the slope.
    partials, slope = jax.grad(at_root, argnums=(0, 1))([leaves[i] for i in varying], root)
    products = [part * changes[i] for i, part in zip(varying, partials, strict=True)]
    change = functools.reduce(jnp.add, (jnp.sum(x) if x.ndim else x for x in products))
    return (root, *others), (-change / slope, *no_change)
