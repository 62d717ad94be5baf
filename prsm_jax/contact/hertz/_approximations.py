"""Closed-form approximations of the contact ellipse, for the error-against-run-time chart.

Each takes the anisotropy τ = (B − A)/(A + B) and returns (κ, K, E). Their measured errors over
the range of roller screws are in `benchmarks`; the exact solution is the default everywhere.
"""

import jax.numpy as jnp

from ...fields import Scalar
from ...numerics import polynomial
from ..special_functions import complete_elliptic_integrals
from ._axis_ratio import antoine_log_axis_ratio


def _curvature_ratio(anisotropy: Scalar) -> Scalar:
    """B/A ≥ 1."""
    return (1 + anisotropy) / (1 - anisotropy)


def power(anisotropy: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """κ = (A/B)^{2/3} with exact integrals."""
    axis_ratio = _curvature_ratio(anisotropy) ** (-2 / 3)
    return axis_ratio, *complete_elliptic_integrals(axis_ratio)


def antoine(anisotropy: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Closed form for κ of Antoine, Visa, Sauvey and Abba 2006, with exact integrals."""
    axis_ratio = jnp.exp(antoine_log_axis_ratio(jnp.log(_curvature_ratio(anisotropy))))
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


#: 1/m_H and n_H in powers of θ.
_MAJOR = (0.018040, 0.817353, -0.425848, 0.306757, -0.072576)
_MINOR = (0.108768, 1.771294, -4.592703, 7.984778, -7.405219, 3.471455, -0.640562)


def lisowski_coefficients(angle: Scalar) -> tuple[Scalar, Scalar]:
    """Hertz coefficients m_H and n_H by the polynomials of Lisowski 2014, equations 8 and 9.

    From Romanowicz and Szybiński 2013; the leading coefficient of 1/m_H, misprinted as −0.72576,
    is −0.072576.

    **Arguments:**

    - `angle`: auxiliary angle θ = arccos τ [rad].
    """
    return 1 / polynomial(_MAJOR, angle), polynomial(_MINOR, angle)


def lisowski(anisotropy: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Polynomials for the Hertz coefficients, corrected; see `lisowski_coefficients`.

    The axes are those of the source: κ = n_H/m_H and E = π κ² m_H³/2. The source gives no approach,
    so K is exact for this κ. Made for θ from 15° to 90°; for more slender ellipses the error is ten
    per cent and more.
    """
    major, minor = lisowski_coefficients(jnp.arccos(anisotropy))
    axis_ratio = minor / major
    first, _ = complete_elliptic_integrals(axis_ratio)
    return axis_ratio, first, jnp.pi / 2 * axis_ratio**2 * major**3


APPROXIMATIONS = {
    "antoine": antoine,
    "power": power,
    "hamrock_brewe": hamrock_brewe,
    "hamrock_brewe_log": hamrock_brewe_log,
    "lisowski": lisowski,
}
