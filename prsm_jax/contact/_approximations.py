"""Closed-form approximations of the contact ellipse, for the error-against-run-time chart.

Each takes the anisotropy τ = (B − A)/(A + B) and returns (κ, K, E). Their measured errors over
the range of roller screws are in `benchmarks`; the exact solution is the default everywhere.
"""

import jax.numpy as jnp

from ..mechanism import Scalar
from ._elliptic import complete_elliptic_integrals


def _curvature_ratio(anisotropy: Scalar) -> Scalar:
    """B/A ≥ 1."""
    return (1 + anisotropy) / (1 - anisotropy)


def power(anisotropy: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """κ = (A/B)^{2/3} with exact integrals."""
    axis_ratio = _curvature_ratio(anisotropy) ** (-2 / 3)
    return axis_ratio, *complete_elliptic_integrals(axis_ratio)


def antoine(anisotropy: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Closed form for κ of Antoine, Visa, Sauvey and Abba 2006, with exact integrals.

    κ = (B/A)^{-γ}, γ a rational function of χ = log₁₀(B/A).
    """
    ratio = _curvature_ratio(anisotropy)
    square = (jnp.log(ratio) / jnp.log(10.0)) ** 2
    numerator = 1 + square * (
        0.40227436 + square * (3.7491752e-2 + square * (7.4855761e-4 + square * 2.1667028e-6))
    )
    denominator = 1 + square * (
        0.42678878 + square * (4.2605401e-2 + square * (9.0786922e-4 + square * 2.7868927e-6))
    )
    axis_ratio = ratio ** (-2 / 3 * numerator / denominator)
    return axis_ratio, *complete_elliptic_integrals(axis_ratio)


def hamrock_brewe(anisotropy: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Power-law form of Hamrock and Brewe 1983: 1/κ = (B/A)^{2/π}, with q = π/2 − 1."""
    ratio = _curvature_ratio(anisotropy)
    q = jnp.pi / 2 - 1
    return ratio ** (-2 / jnp.pi), jnp.pi / 2 + q * jnp.log(ratio), 1 + q / ratio


def hamrock_brewe_log(anisotropy: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Fitted form of Brewe and Hamrock 1977: 1/κ = 1.0339 (B/A)^{0.636}."""
    ratio = _curvature_ratio(anisotropy)
    axis_ratio = 1 / (1.0339 * ratio**0.636)
    return axis_ratio, 1.5277 + 0.6023 * jnp.log(ratio), 1.0003 + 0.5968 / ratio


APPROXIMATIONS = {
    "antoine": antoine,
    "power": power,
    "hamrock_brewe": hamrock_brewe,
    "hamrock_brewe_log": hamrock_brewe_log,
}
