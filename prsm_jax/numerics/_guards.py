"""Comparisons that keep a formula away from zero, and let NaN through to it.

`jnp.where(x > 0, f(x), 0.0)` returns a number for an `x` that is NaN, because every comparison with
NaN is false. With these functions NaN takes the branch of the formula, and stays NaN.
"""

from collections.abc import Callable

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
    return _or_zero(jnp.sqrt, square)


def cube_root_or_zero(cube: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """Cube root of a number that is not negative; 0, with derivative 0, at 0."""
    return _or_zero(jnp.cbrt, cube)


def _or_zero(root: Callable[[Array], Array], power: Array) -> Array:
    positive = above_or_nan(power)
    return jnp.where(positive, root(jnp.where(positive, power, 1.0)), 0.0)
