"""The axis ratio of a Hertz contact ellipse from the anisotropy of the gap."""

import math

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...numerics import polynomial
from ..special_functions import integrals_of_square

Real = Float[Array, "*batch"]

#: Below this m = 1 − κ² derivatives of the integrals are evaluated by series.
_NEARLY_CIRCULAR = 0.01
#: Below this m the derivative of D is evaluated by its series: the cancellation error of B − (1 −
#: m) D grows with 1/m, and by a further factor 1/m with each derivative.
_DIFFERENCES_CANCEL = 0.1
#: 2 dD/dm in powers of m, from D = π/2 Σ c² (2n + 2)/(2n + 1) mⁿ with c = (2n + 1)!!/(2n + 2)!!.
_D_SERIES_SLOPES = tuple(
    math.pi * (math.comb(2 * n + 2, n + 1) / 4 ** (n + 1)) ** 2 * (2 * n + 2) / (2 * n + 1) * n
    for n in range(1, 18)
)


def antoine_log_axis_ratio(log_curvature_ratio: Real) -> Real:
    """log κ from log(B/A) in closed form, by Antoine, Visa, Sauvey and Abba 2006.

    κ = (B/A)^{-γ}, γ a rational function of χ = log₁₀(B/A).
    """
    square = (log_curvature_ratio * (1 / math.log(10.0))) ** 2
    numerator = 1 + square * (
        0.40227436 + square * (3.7491752e-2 + square * (7.4855761e-4 + square * 2.1667028e-6))
    )
    denominator = 1 + square * (
        0.42678878 + square * (4.2605401e-2 + square * (9.0786922e-4 + square * 2.7868927e-6))
    )
    return -2 / 3 * log_curvature_ratio * (numerator / denominator)


@jax.custom_jvp
def _ellipse(anisotropy: Real) -> tuple[Real, Real, Real]:
    """κ, B and D: one Halley step from the closed form, with a single evaluation of B and D.

    The closed form has an error of 6e-6 up to B/A = 1e4 and Halley's method converges cubically, so
    one step reaches rounding; the integrals there follow by Taylor series. With x = log κ and m₁ =
    κ²: `dD/dx = −(B − m₁ D)/m`, `dB/dx = −B − dD/dx`. Quotients and logarithms are most of the run
    time, so both inverses are taken from 1/(B D), and the logarithm of the small residual from a
    series.
    """
    curvature_ratio = (1 + anisotropy) / (1 - anisotropy)
    start = antoine_log_axis_ratio(jnp.log(curvature_ratio))
    axis_ratio = jnp.exp(start)
    square, parameter = axis_ratio**2, (1 - axis_ratio) * (1 + axis_ratio)
    b, d = integrals_of_square(square, start)
    elongated = parameter > _NEARLY_CIRCULAR
    inverse = 1 / jnp.where(elongated, parameter, 1.0)
    first_d = jnp.where(
        elongated,
        -(b - square * d) * inverse,
        -math.pi / 2 * square * (0.375 + parameter * (15 / 32 + parameter * 525 / 1024)),
    )
    first_b = -b - first_d
    second_d = jnp.where(
        elongated,
        -(first_b - square * (2 * d + 3 * first_d)) * inverse,
        2 * first_d + math.pi * 15 / 32,
    )
    second_b = -first_b - second_d
    inverse_product = 1 / (b * d)
    inverse_d, inverse_b = b * inverse_product, d * inverse_product
    grown_d, grown_b = first_d * inverse_d, first_b * inverse_b
    slope = 2 + grown_d - grown_b
    bend = second_d * inverse_d - grown_d**2 - second_b * inverse_b + grown_b**2
    # A/B = κ² D/B, and log(1 + excess).
    excess = square * d * inverse_b * curvature_ratio - 1
    residual = excess * (1 - excess * (1 / 2 - excess * (1 / 3 - excess / 4)))
    step = -2 * residual * slope / (2 * slope**2 - residual * bend)
    # κ cannot exceed one; rounding at the circle must not push it over.
    axis_ratio = jnp.minimum(axis_ratio * (1 + step + step**2 / 2), 1.0)
    b = b + step * (first_b + step / 2 * second_b)
    d = d + step * (first_d + step / 2 * second_d)
    return axis_ratio, b, d


@_ellipse.defjvp
def _ellipse_jvp(primals, tangents):
    """Derivative of the root, not of the step: algebraic in κ, B and D, to any order.

    With x = log κ: the root of `log(κ² D/B) = log((1 − τ)/(1 + τ))`, and K' = −B.
    """
    (anisotropy,), (tangent,) = primals, tangents
    axis_ratio, b, d = _ellipse(anisotropy)
    square, parameter = axis_ratio**2, (1 - axis_ratio) * (1 + axis_ratio)
    elongated = parameter > _DIFFERENCES_CANCEL
    far = jnp.where(elongated, parameter, 1.0)
    near = jnp.where(elongated, 0.0, parameter)
    slope_d = jnp.where(elongated, -(b - square * d) / far, _slope_of_d(near))
    target_slope = -2 / ((1 - anisotropy) * (1 + anisotropy))
    change = target_slope / (3 + slope_d * (b + d) / (b * d)) * tangent
    return (axis_ratio, b, d), (axis_ratio * change, -(b + slope_d) * change, slope_d * change)


def _slope_of_d(parameter: Real) -> Real:
    """dD/d(log κ) = −2 (1 − m) dD/dm by D's series in m = 1 − κ²."""
    return (parameter - 1) * polynomial(_D_SERIES_SLOPES, parameter)


def contact_ellipse(anisotropy: Real) -> tuple[Real, Real, Real]:
    """κ, K(1 − κ²) and E(1 − κ²) of the contact ellipse, exact Hertz theory.

    Solves `A/B = (K − E)/(E/κ² − K)`, written as `κ² D/B` so that the circle is an ordinary
    point; the derivative is that of the root, not of the iterations.

    **Arguments:**

    - `anisotropy`: τ = (B − A)/(A + B) in [0, 1); 0 is a circular contact.
    """
    axis_ratio, b, d = _ellipse(anisotropy)
    return axis_ratio, b + d, b + axis_ratio**2 * d
