"""Elliptical Hertz contact: pressure, semi-axes, approach and stiffness."""

from typing import Literal, TypeAlias

import equinox as eqx
import jax.numpy as jnp

from .._physics import physics
from ..mechanism import Material, Scalar
from ._approximations import APPROXIMATIONS
from ._axis_ratio import contact_ellipse

HertzMethod: TypeAlias = Literal[
    "exact", "antoine", "power", "hamrock_brewe", "hamrock_brewe_log", "lisowski"
]


class HertzContact(eqx.Module):
    """Result of an elliptical Hertz contact under a normal force."""

    semi_major: Scalar
    semi_minor: Scalar
    max_pressure: Scalar
    #: Normal approach of the two bodies δ [m].
    approach: Scalar
    #: Secant stiffness F/δ [N/m].
    stiffness: Scalar
    #: Tangent stiffness dF/dδ = 3/2 F/δ [N/m].
    stiffness_tangent: Scalar
    #: Complete elliptic integral of the second kind E(1 − κ²), used by the spin moment.
    second_elliptic_integral: Scalar


def contact_modulus(first: Material, second: Material) -> Scalar:
    """Contact modulus E*, 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂ [Pa]."""
    compliance = (1 - first.poisson_ratio**2) / first.youngs_modulus
    return 1 / (compliance + (1 - second.poisson_ratio**2) / second.youngs_modulus)


def _cube_root(value: Scalar) -> Scalar:
    """Cube root of a load; no load (or tension, which a contact cannot carry) gives 0.

    The derivative at zero load is infinite for the load and 0 for everything else; it is reported
    as 0 so that it cannot turn into NaN by the chain rule.
    """
    loaded = value > 0
    return jnp.where(loaded, jnp.cbrt(jnp.where(loaded, value, 1.0)), 0.0)


def anisotropy_of(total: Scalar, difference_squared: Scalar) -> Scalar:
    """τ = (B − A)/(A + B) from A + B and (B − A)², with derivative 0 at the circle.

    (B − A)² is a sum of squares that vanishes at the circle together with its gradient, and
    pressure and approach are even in τ: 0 is their true derivative there.
    """
    elongated = difference_squared > 0
    root = jnp.sqrt(jnp.where(elongated, difference_squared, 1.0))
    return jnp.where(elongated, root, 0.0) / total


@physics("hertz")
def hertz_contact(
    force: Scalar,
    total: Scalar,
    difference_squared: Scalar,
    modulus: Scalar,
    method: HertzMethod = "exact",
) -> HertzContact:
    """Elliptical Hertz contact of two bodies with the gap A x² + B y².

    With κ = b/a: `a = [3 F E / (2π E* κ² (A + B))]^{1/3}`, `p₀ = 3F/(2πab)`,
    `δ = p₀ b K / E*` (Johnson 1985, chapter 4). Values and gradients are finite everywhere,
    circular contact and zero load included.

    **Arguments:**

    - `force`: normal force F [N]; at or below zero there is no contact and all results are 0.
    - `total`: A + B [1/m].
    - `difference_squared`: (B − A)² [1/m²].
    - `modulus`: contact modulus E* [Pa].
    - `method`: `"exact"`, or a named approximation for κ, K and E.

    **Raises:** `ValueError` for an unknown method.
    """
    anisotropy = anisotropy_of(total, difference_squared)
    if method == "exact":
        axis_ratio, first, second = contact_ellipse(anisotropy)
    elif method in APPROXIMATIONS:
        axis_ratio, first, second = APPROXIMATIONS[method](anisotropy)
    else:
        raise ValueError(
            f"Hertz method is {method!r}; choose one of exact, {', '.join(APPROXIMATIONS)}"
        )
    root = _cube_root(force)
    axis_factor = jnp.cbrt(3 * second / (2 * jnp.pi * modulus * axis_ratio**2 * total))
    semi_major = axis_factor * root
    # In powers of F^{1/3} throughout, so that nothing is 0/0 without load.
    max_pressure = 3 * root / (2 * jnp.pi * axis_ratio * axis_factor**2)
    approach_factor = 3 * first / (2 * jnp.pi * modulus * axis_factor)
    stiffness = root / approach_factor
    return HertzContact(
        semi_major=semi_major,
        semi_minor=axis_ratio * semi_major,
        max_pressure=max_pressure,
        approach=approach_factor * root**2,
        stiffness=stiffness,
        stiffness_tangent=1.5 * stiffness,
        second_elliptic_integral=second,
    )
