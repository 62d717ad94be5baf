"""Bounds: a smooth map from free numbers to numbers within them.

Two bounds: `p = (l + u)/2 + (u − l)/2 sin x`; one: `p = l + s (√(1 + x²) − 1)`, of James and Roos,
MINUIT, Computer Physics Communications 10 (1975) 343. A bound is reached at a finite x.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

#: A start on a bound, where the derivative by x is 0, is moved inside by this share.
_INSIDE = 1e-2


def inside(
    start: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    scale: np.ndarray,
    share: float = _INSIDE,
) -> np.ndarray:
    """The start, moved inside of its bounds by a share of their distance or of the scale."""
    width = np.where(np.isfinite(upper - lower), upper - lower, scale)
    room = share * np.minimum(width, scale)
    return np.clip(start, lower + room, upper - room)


def _between(
    lower: Float[Array, " parameters"], upper: Float[Array, " parameters"]
) -> tuple[Bool[Array, " parameters"], Float[Array, " parameters"], Float[Array, " parameters"]]:
    """Whether there are two bounds, their middle, and half of their distance (else 0 and 1)."""
    both = jnp.isfinite(lower) & jnp.isfinite(upper)
    return (
        both,
        jnp.where(both, (lower + upper) / 2, 0.0),
        jnp.where(both, (upper - lower) / 2, 1.0),
    )


def to_free(
    values: Float[Array, " parameters"],
    lower: Float[Array, " parameters"],
    upper: Float[Array, " parameters"],
    scale: Float[Array, " parameters"],
) -> Float[Array, " parameters"]:
    """Free numbers x that the map assigns to values within their bounds."""
    low, high = jnp.isfinite(lower), jnp.isfinite(upper)
    both, middle, half = _between(lower, upper)
    angle = jnp.arcsin(jnp.clip(jnp.where(both, values - middle, 0.0) / half, -1.0, 1.0))
    # Scaled, so that a step of 1 in x changes every value by its own magnitude.
    from_low = 1.0 + jnp.where(low, values - lower, 0.0) / scale
    from_high = 1.0 + jnp.where(high, upper - values, 0.0) / scale
    above = jnp.sqrt(jnp.maximum(from_low**2 - 1.0, 0.0))
    below = jnp.sqrt(jnp.maximum(from_high**2 - 1.0, 0.0))
    one = jnp.where(low, above, jnp.where(high, below, values / scale))
    return jnp.where(both, angle, one)


def from_free(
    free: Float[Array, " parameters"],
    lower: Float[Array, " parameters"],
    upper: Float[Array, " parameters"],
    scale: Float[Array, " parameters"],
) -> Float[Array, " parameters"]:
    """Values within their bounds that the map assigns to free numbers x."""
    low, high = jnp.isfinite(lower), jnp.isfinite(upper)
    both, middle, half = _between(lower, upper)
    away = scale * (jnp.sqrt(1.0 + free * free) - 1.0)
    one = jnp.where(low, jnp.where(low, lower, 0.0) + away, free * scale)
    one = jnp.where(high & ~low, jnp.where(high, upper, 0.0) - away, one)
    return jnp.where(both, middle + half * jnp.sin(free), one)
