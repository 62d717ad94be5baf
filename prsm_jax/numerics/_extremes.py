"""Largest and smallest number of an array, with the derivative of the one that is chosen."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ._types import Scalar


def largest(values: Float[Array, "..."]) -> Scalar:
    """The largest of all numbers; NaN if any is.

    The derivative of `jnp.max` is the mean over all numbers that equal the maximum, and infinite if
    none does. The compiler may compute the numbers a second time for that comparison, and rounds
    them differently if they are fused with other operations. An index is always that of a number.
    At a tie the derivative is that of the first.
    """
    return _at(jax.lax.argmax, values)


def smallest(values: Float[Array, "..."]) -> Scalar:
    """The smallest of all numbers, as `largest`."""
    return _at(jax.lax.argmin, values)


def _at(place: Callable[..., Array], values: Array) -> Scalar:
    flat = jnp.ravel(values)
    # An unsigned index cannot count from the end: three operations less.
    return jax.lax.dynamic_index_in_dim(flat, place(flat, 0, jnp.uint32), keepdims=False)
