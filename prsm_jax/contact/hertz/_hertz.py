"""Elliptical Hertz contact: pressure, semi-axes, approach and stiffness."""

from typing import Annotated, TypeAlias

import jax
import jax.numpy as jnp

from ...fields import In, Scalar
from ...mechanism import ContactMethod, Material
from ...numerics import above_or_nan
from ...programs import physics
from ...results import Result
from ._methods import ellipse_by

#: A name, or a function of τ = (B − A)/(A + B) that returns κ = b/a, K and E.
HertzMethod: TypeAlias = ContactMethod

#: Cube of a semi-axis below which there is no contact [m³]; `_inverse_cube_root` is valid above
#: 1e-142.
_LEAST_CUBE = 1e-140


class HertzContact(Result):
    """Result of an elliptical Hertz contact under a normal force."""

    semi_major: Annotated[Scalar, In("m")]
    semi_minor: Annotated[Scalar, In("m")]
    max_pressure: Annotated[Scalar, In("Pa")]
    #: Normal approach of the two bodies δ [m].
    approach: Annotated[Scalar, In("m")]
    #: Secant stiffness F/δ [N/m].
    stiffness: Annotated[Scalar, In("N/m")]
    #: Tangent stiffness dF/dδ = 3/2 F/δ [N/m].
    stiffness_tangent: Annotated[Scalar, In("N/m")]
    #: Complete elliptic integral of the second kind E(1 − κ²), used by the spin moment.
    second_elliptic_integral: Scalar


def contact_modulus(first: Material, second: Material) -> Scalar:
    """Contact modulus E*, 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂ [Pa]."""
    compliance = (1 - first.poisson_ratio**2) / first.youngs_modulus
    return 1 / (compliance + (1 - second.poisson_ratio**2) / second.youngs_modulus)


def anisotropy_of(total: Scalar, difference_squared: Scalar) -> Scalar:
    """τ = (B − A)/(A + B) from A + B and (B − A)², with derivative 0 at the circle.

    (B − A)² is a sum of squares that vanishes at the circle together with its gradient, and
    pressure and approach are even in τ: 0 is their true derivative there.
    """
    elongated = above_or_nan(difference_squared)
    root = jnp.sqrt(jnp.where(elongated, difference_squared, 1.0))
    return jnp.where(elongated, root, 0.0) / total


@jax.custom_jvp
def _inverse_cube_root(cube: Scalar) -> Scalar:
    """1/∛ of a number above 1e-142: a power in single precision and one step of third order.

    Takes a third of the run time of `jnp.cbrt` and a division. Small numbers (the cube of a
    semi-axis in metres) are scaled into the range of single precision; numbers below 1e-142 give a
    finite result.
    """
    scale, shrink = jnp.ones_like(cube), jnp.ones_like(cube)
    # The range of single precision needs only the first scale.
    double = cube.dtype == jnp.float64
    for below, power in ((-100, 40), (-220, 80), (-340, 120))[: 3 if double else 1]:
        scale = jnp.where(cube < 2.0**below, 2.0 ** (3 * power), scale)
        shrink = jnp.where(cube < 2.0**below, 2.0**power, shrink)
    single = jnp.maximum((cube * scale).astype(jnp.float32), jnp.finfo(jnp.float32).tiny)
    root = jnp.exp(jnp.log(single) * (-1 / 3)).astype(cube.dtype) * shrink
    excess = 1 - cube * root**3
    return root * (1 + excess * (1 / 3 + excess * (2 / 9)))


@_inverse_cube_root.defjvp
def _inverse_cube_root_jvp(primals, tangents):
    (cube,), (tangent,) = primals, tangents
    root = _inverse_cube_root(cube)
    return root, root / cube * tangent * (-1 / 3)


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
    circular contact and zero load included. At a circle the semi-axes have no derivative by
    (B − A)²; there that of all results is set to 0, which leaves out a part of second derivatives
    by A and B.

    **Arguments:**

    - `force`: normal force F [N]; at or below zero, or so small that the ellipse is shorter than
      1e-46 m, there is no contact and all results are 0.
    - `total`: A + B [1/m]; results are NaN where it or E* is not above 0 and finite.
    - `difference_squared`: (B − A)² [1/m²].
    - `modulus`: contact modulus E* [Pa].
    - `method`: `"exact"`, the name of an approximation for κ, K and E, or a function of your own
      that takes τ = (B − A)/(A + B) and returns these three.

    **Raises:** `ValueError` for an unknown method.
    """
    # Two concave bodies, points, and bodies without a modulus have no contact ellipse.
    possible = (total > 0) & (total < jnp.inf) & (modulus > 0) & (modulus < jnp.inf)
    total = jnp.where(possible, total, jnp.nan)
    anisotropy = anisotropy_of(total, difference_squared)
    axis_ratio, first, second = ellipse_by(method, anisotropy)
    # Without a load (or in tension, which a contact cannot carry) everything is 0, and so are the
    # derivatives: those with respect to the load are infinite there, and must not become NaN.
    cube = jax.lax.stop_gradient(force * second / (modulus * axis_ratio**2 * total))
    loaded = above_or_nan(force) & above_or_nan(cube, _LEAST_CUBE)
    carried = jnp.where(loaded, force, 1.0)
    per_axis = 3 / (2 * jnp.pi) * carried
    cube = per_axis * second / (modulus * axis_ratio**2 * total)
    inverse_major = _inverse_cube_root(cube)
    semi_major = cube * inverse_major**2
    inverse = per_axis * inverse_major
    approach = inverse * first / modulus
    stiffness = jnp.where(loaded, carried / approach, 0.0)
    semi_major_loaded = jnp.where(loaded, semi_major, 0.0)
    return HertzContact(
        semi_major=semi_major_loaded,
        semi_minor=axis_ratio * semi_major_loaded,
        max_pressure=jnp.where(loaded, inverse * inverse_major / axis_ratio, 0.0),
        approach=jnp.where(loaded, approach, 0.0),
        stiffness=stiffness,
        stiffness_tangent=1.5 * stiffness,
        second_elliptic_integral=second,
    )
