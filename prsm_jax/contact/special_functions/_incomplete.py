"""Incomplete elliptic integrals as functions of a depth, with derivatives of their own."""

import functools
from collections.abc import Callable

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero

from ...numerics import Scalar
from ._carlson import carlson_rf_and_rd

#: ∫ sin²θ/Δ and ∫ cos²θ/Δ, or their derivatives.
_Pair = tuple[Scalar, Scalar]


def incomplete_elliptic_integrals(square: Scalar, depth: Scalar) -> _Pair:
    """∫ sin²θ/Δ dθ and ∫ cos²θ/Δ dθ from 0 to arccot ζ, with Δ² = 1 − (1 − κ²) sin²θ.

    Carlson's duplications (DLMF 19.36) compute them and are regular at κ = 1. Derivatives by ζ are
    elementary: the integrand at the upper limit times −1/(1 + ζ²). Derivatives by κ² come from the
    duplications in forward mode, also where JAX differentiates in reverse. Differentiable to any
    order.

    **Arguments:**

    - `square`: κ² in (0, 1].
    - `depth`: ζ ≥ 0; where its derivatives are needed, not 0.
    """
    (found,) = _derivatives(0, square, depth)
    return found


def _integrals(square: Scalar, depth: Scalar) -> _Pair:
    below = 1 + depth**2
    sine = 1 / jnp.sqrt(below)
    first_kind, second_kind = carlson_rf_and_rd(
        depth**2 / below, (square + depth**2) / below, jnp.ones_like(depth)
    )
    integral_d = sine**3 * second_kind / 3
    return integral_d, sine * first_kind - integral_d


def _slopes(square: Scalar, depth: Scalar) -> _Pair:
    """Derivatives of both by the depth."""
    below = 1 + depth**2
    by_depth = -1 / (below * jnp.sqrt(below * (square + depth**2)))
    return by_depth, depth**2 * by_depth


def _by_square(
    function: Callable[[Scalar, Scalar], _Pair], order: int, square: Scalar, depth: Scalar
) -> tuple[_Pair, ...]:
    """A function of κ² and ζ, and its derivatives by κ² up to this order."""
    if order == 0:
        return (function(square, depth),)

    def lower(square: Scalar) -> tuple[_Pair, ...]:
        return _by_square(function, order - 1, square, depth)

    values, slopes = jax.jvp(lower, (square,), (jnp.ones_like(square),))
    return *values, slopes[-1]


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def _derivatives(order: int, square: Scalar, depth: Scalar) -> tuple[_Pair, ...]:
    """Both integrals and their derivatives by κ² up to this order."""
    return _by_square(_integrals, order, square, depth)


@functools.partial(_derivatives.defjvp, symbolic_zeros=True)
def _derivatives_of_derivatives(order, primals, tangents):
    square, depth = primals
    by_square, by_depth = tangents
    changes = []
    if isinstance(by_square, SymbolicZero):
        values = _derivatives(order, square, depth)
    else:
        # One loop of duplications for all orders.
        *values, last = _derivatives(order + 1, square, depth)
        values = tuple(values)
        changes.append(jax.tree.map(lambda slope: slope * by_square, (*values[1:], last)))
    if not isinstance(by_depth, SymbolicZero):
        slopes = _by_square(_slopes, order, square, depth)
        changes.append(jax.tree.map(lambda slope: slope * by_depth, slopes))
    if not changes:
        return values, jax.tree.map(jnp.zeros_like, values)
    return values, jax.tree.map(lambda *parts: functools.reduce(jnp.add, parts), *changes)
