"""Comparisons that keep a formula away from zero, and let NaN through to it.

`jnp.where(x > 0, f(x), 0.0)` makes a number of an `x` that is NaN, because every comparison with
NaN is false. With these NaN takes the branch of the formula, and comes out as NaN.
"""

import jax.numpy as jnp
from jax.typing import ArrayLike
from jaxtyping import Array, Bool, Float


def above_or_nan(value: Float[Array, "*batch"], limit: ArrayLike = 0.0) -> Bool[Array, "*batch"]:
    """Whether a value is above a limit, or one of both is NaN."""
    return jnp.logical_not(value <= limit)


def below_or_nan(value: Float[Array, "*batch"], limit: ArrayLike = 0.0) -> Bool[Array, "*batch"]:
    """Whether a value is below a limit, or one of both is NaN."""
    return jnp.logical_not(value >= limit)


def root_or_zero(square: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """Square root of what is not negative; 0, with derivative 0, at 0."""
    some = above_or_nan(square)
    return jnp.where(some, jnp.sqrt(jnp.where(some, square, 1.0)), 0.0)
