"""Comparisons that keep a formula away from zero, and let NaN through to it.

`jnp.where(x > 0, f(x), 0.0)` returns a number for an `x` that is NaN, because every comparison with
NaN is false. With these functions NaN takes the branch of the formula, and stays NaN.
"""

import jax.numpy as jnp
from jax.typing import ArrayLike
from jaxtyping import Array, Bool, Float


def above_or_nan(value: Float[Array, "*batch"], limit: ArrayLike = 0.0) -> Bool[Array, "*batch"]:
    """Whether a value is above a limit, or either is NaN."""
    return jnp.logical_not(value <= limit)


def below_or_nan(value: Float[Array, "*batch"], limit: ArrayLike = 0.0) -> Bool[Array, "*batch"]:
    """Whether a value is below a limit, or either is NaN."""
    return jnp.logical_not(value >= limit)


def root_or_zero(square: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """Square root of a number that is not negative; 0, with derivative 0, at 0."""
    positive = above_or_nan(square)
    return jnp.where(positive, jnp.sqrt(jnp.where(positive, square, 1.0)), 0.0)
