"""Stress on the axis of an elliptical Hertz contact without friction, in closed form."""

import jax.numpy as jnp

from ...fields import Scalar
from ...programs import physics
from ..special_functions import incomplete_elliptic_integrals


@physics("axis_stress")
def axis_stress(
    depth: Scalar,
    semi_major: Scalar,
    semi_minor: Scalar,
    max_pressure: Scalar,
    poisson_ratio: Scalar,
) -> tuple[Scalar, Scalar, Scalar]:
    """Principal stresses along the major axis, along the minor axis and in depth.

    The closed form of Thomas and Hoersch 1930, rearranged to avoid cancellation at a circular
    contact, with incomplete elliptic integrals in Carlson's form. With κ = b/a, ζ = z/a and n² =
    (κ² + ζ²)/(1 + ζ²) the stress in depth is `−p₀ κ (1 − n²)/(n (1 − κ²))`.

    **Arguments:**

    - `depth`: z ≥ 0 [m].
    - `semi_major`, `semi_minor`: a ≥ b [m].
    - `max_pressure`: p₀ [Pa].
    - `poisson_ratio`: ν of this body.

    **Returns:** σ along a, σ along b, σ in depth [Pa]; 0 without a load (semi-axes 0). The rounding
    error of the second one is about ε p₀ (a/b)², for the rounding ε.
    """
    unloaded = semi_minor <= 0
    semi_major, semi_minor = (jnp.where(unloaded, 1.0, axis) for axis in (semi_major, semi_minor))
    max_pressure = jnp.where(unloaded, 0.0, max_pressure)
    # The integrals take the root of ζ²: at the surface its derivative needs a ζ that is not 0.
    ratio, zeta = semi_minor / semi_major, depth / semi_major + jnp.finfo(depth.dtype).eps ** 2
    square, below = ratio**2, 1 + zeta**2
    ratio_below = jnp.sqrt((square + zeta**2) / below)
    # ∫ sin²θ/Δ and ∫ cos²θ/Δ up to arccot ζ, the amplitude at this depth.
    integral_d, integral_b = incomplete_elliptic_integrals(square, zeta)
    shared = 1 / (below * (1 + ratio_below))
    along = zeta * integral_d - shared / 2
    along_poisson = (shared + zeta * integral_b - 1) / square
    across = (shared * (1 + 2 * ratio_below) - 1 - ratio_below) / (2 * ratio_below * square)
    # The part without ν: Ω_y of the source over 1 − κ².
    across = across + zeta * integral_b / square
    across_poisson = zeta * integral_d - shared
    factor = 2 * max_pressure * ratio
    return (
        factor * (along + poisson_ratio * along_poisson),
        factor * (across + poisson_ratio * across_poisson),
        -max_pressure * ratio / (ratio_below * below),
    )
