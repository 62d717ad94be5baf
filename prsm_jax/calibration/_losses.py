"""Losses: how much a residual of several standard deviations counts.

A loss ρ is minimised by least squares over residuals g(z) with g(z)² = 2 ρ(z), so that every loss
has the same solver. z is the residual over its standard deviation.
"""

from typing import Literal, TypeAlias, get_args

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

Loss: TypeAlias = Literal["squared", "huber", "cauchy", "soft_l1"]
LOSSES: tuple[str, ...] = get_args(Loss)
#: Residual, in standard deviations, beyond which a loss grows less than the square. Those of Huber
#: and Cauchy have an efficiency of 95 % for normal errors; both as in Holland and Welsch (1977).
TUNING: dict[str, float] = {"squared": 1.0, "huber": 1.345, "cauchy": 2.385, "soft_l1": 1.0}


def as_squares(residuals: Float[Array, " rows"], loss: str) -> Float[Array, " rows"]:
    """Residuals g(z) whose half sum of squares is the sum of losses; smooth at 0."""
    if loss == "squared":
        return residuals
    scale = TUNING[loss]
    z = residuals / scale
    square = z * z
    if loss == "huber":
        far = jnp.abs(z) > 1.0
        root = jnp.sqrt(jnp.where(far, 2.0 * jnp.abs(z) - 1.0, 1.0))
        return scale * jnp.where(far, jnp.sign(z) * root, z)
    if loss == "soft_l1":
        return scale * z * jnp.sqrt(2.0 / (1.0 + jnp.sqrt(1.0 + square)))
    # log1p(x)/x, by its series near 0.
    near = square < 1e-6
    ratio = jnp.log1p(jnp.where(near, 1.0, square)) / jnp.where(near, 1.0, square)
    return scale * z * jnp.sqrt(jnp.where(near, 1.0 - 0.5 * square, ratio))


def influence(residuals: np.ndarray, loss: str) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivative of the loss, ψ = ρ′ and ψ′, at each residual."""
    scale = TUNING[loss]
    z = residuals / scale
    if loss == "huber":
        return scale * np.clip(z, -1.0, 1.0), (np.abs(z) <= 1.0).astype(float)
    if loss == "soft_l1":
        root = np.sqrt(1.0 + z * z)
        return scale * z / root, root**-3.0
    if loss == "cauchy":
        root = 1.0 + z * z
        return scale * z / root, (1.0 - z * z) / root**2
    return residuals, np.ones_like(residuals)
