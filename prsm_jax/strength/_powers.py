"""Powers of what is never negative, whose derivatives stay finite at zero."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..numerics import above_or_nan


def positive_power(base: Float[Array, "*batch"], exponent: float) -> Float[Array, "*batch"]:
    """`base ** exponent` for a positive exponent; 0, with derivative 0, at or below 0.

    Where the exponent is below 1 the true derivative at 0 is infinite; 0 is what keeps it from
    becoming NaN by the chain rule.
    """
    some = above_or_nan(base)
    return jnp.where(some, jnp.where(some, base, 1.0) ** exponent, 0.0)


def ratio_or_infinity(
    above: Float[Array, "*batch"], below: Float[Array, "*batch"]
) -> Float[Array, "*batch"]:
    """`above / below`; ∞ where nothing (or less) is below, with derivative 0."""
    some = above_or_nan(below)
    return jnp.where(some, above / jnp.where(some, below, 1.0), jnp.inf)


def scaled_unless_infinite(
    value: Float[Array, "*batch"], factor: Float[Array, "*batch"]
) -> Float[Array, "*batch"]:
    """`factor * value`; ∞ stays ∞ and has no part in any derivative."""
    infinite = jnp.isinf(value)
    return jnp.where(infinite, jnp.inf, factor * jnp.where(infinite, 1.0, value))
