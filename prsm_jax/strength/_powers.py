"""Powers and ratios of non-negative numbers, with derivatives that stay finite at zero."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..numerics import above_or_nan


def positive_power(base: Float[Array, "*batch"], exponent: float) -> Float[Array, "*batch"]:
    """`base ** exponent` for a positive exponent; 0, with derivative 0, at or below 0.

    Where the exponent is below 1 the true derivative at 0 is infinite; 0 avoids NaN by the chain
    rule.
    """
    positive = above_or_nan(base)
    return jnp.where(positive, jnp.where(positive, base, 1.0) ** exponent, 0.0)


def ratio_or_infinity(
    above: Float[Array, "*batch"], below: Float[Array, "*batch"]
) -> Float[Array, "*batch"]:
    """`above / below`; ∞, with derivative 0, where `below` is 0 or negative."""
    positive = above_or_nan(below)
    return jnp.where(positive, above / jnp.where(positive, below, 1.0), jnp.inf)


def scaled_unless_infinite(
    value: Float[Array, "*batch"], factor: Float[Array, "*batch"]
) -> Float[Array, "*batch"]:
    """`factor * value`; ∞ stays ∞, with derivative 0."""
    infinite = jnp.isinf(value)
    return jnp.where(infinite, jnp.inf, factor * jnp.where(infinite, 1.0, value))
