"""Friction of a Hertz ellipse with simultaneous slip and spin, from one dissipation potential.

The local slip is u = v + ω n × r, so |u| = |ω| |r − r₀| with the instantaneous centre r₀. The mean
of |r − r₀| under Hertz's pressure is the biharmonic potential of a homogeneous ellipsoid flattened
to the ellipse. Like the gradient of the Newtonian potential (Eshelby 1959; Mura 1987, section 11),
its gradient is an integral over confocal ellipses. With σ, ω² times the parameter of these
ellipses, and the matrix Σ of the contact ellipse,

    D = det(ω² Σ + σ),   U = 1 − (ω² v·Σv + σ v·v)/D,

    ∂Φ/∂v = ¾ ∫ U √σ (ω² Σ v + σ v) D^(−3/2) dσ,

    ∂Φ/∂ω = ¾ ω ∫ U √σ (v·Σv + (5/4 U − 1)(2 ω² det Σ + σ tr Σ)) D^(−3/2) dσ,

integrated from the σ at which U vanishes, or from 0 if the centre lies in the ellipse, to infinity.
These are incomplete elliptic integrals; for a centre in the ellipse they are complete ones, with
polynomials of its coordinates.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ..fields import Scalar
from ..geometry import RelativeCurvature
from .hertz import HertzContact, anisotropy_of

#: A centre counts as inside the ellipse up to this share of the axes beyond its edge: at the edge
#: the derivative of the limit of the integrals is unbounded. The error of this is below 1e-12.
_EDGE = 1e-5
#: Below this anisotropy (a² − b²)/(B − A) is evaluated by its series.
_ROUND = 1e-5


class EllipseShape(eqx.Module):
    """Matrix of the half-axes of a contact ellipse, in two axes of the tangent plane.

    The ellipse is `rᵀ Σ⁻¹ r ≤ 1`. Σ is a smooth function of the curvatures also where the ellipse
    is a circle and has no principal axes.
    """

    #: Entries of Σ [m²].
    first: Scalar
    second: Scalar
    mixed: Scalar
    #: a b [m²].
    product: Scalar


class Sliding(NamedTuple):
    """Gradient of the mean local slip speed Φ: Coulomb friction per unit of μ F."""

    #: ∂Φ/∂v: force per unit of μ F, in both axes; its magnitude is at most 1.
    force: tuple[Scalar, Scalar]
    #: ∂Φ/∂ω: moment about the normal per unit of μ F [m].
    moment: Scalar


def ellipse_shape(hertz: HertzContact, curvature: RelativeCurvature) -> EllipseShape:
    """Matrix of a contact ellipse in the rolling direction and the tangent across it.

    `Σ = ½ (a² + b²) 1 − (a² − b²)/(B − A) · (S − ½ (A + B) 1)` with the tensor S of the gap: the
    ellipse is longest in the direction in which the gap is flattest.
    """
    anisotropy = anisotropy_of(curvature.total, curvature.difference_squared)
    major, minor = hertz.semi_major**2, hertz.semi_minor**2
    elongated = anisotropy > _ROUND
    # 1 − κ² = 1 − e^{−x} with x = 8/3 τ to third order.
    x = 8 / 3 * anisotropy
    series = 8 / 3 * (1 - x / 2 + x**2 / 6) * major
    ratio = jnp.where(elongated, (major - minor) / jnp.where(elongated, anisotropy, 1.0), series)
    ratio = ratio / curvature.total
    deviation = ratio * (curvature.rolling - curvature.total / 2)
    mean = (major + minor) / 2
    return EllipseShape(
        first=mean - deviation,
        second=mean + deviation,
        mixed=-ratio * curvature.twist,
        product=hertz.semi_major * hertz.semi_minor,
    )


def slip_and_spin(
    shape: EllipseShape, slip: tuple[Scalar, Scalar], spin: Scalar, order: int = 32
) -> Sliding:
    """Gradient of `Φ(v, ω) = ∫ p |v + ω n × r| dA / F` over a Hertz ellipse.

    `μ F Φ` is the dissipation potential of Coulomb friction: friction force and moment are μ F
    times the gradient, and the power lost is `F_t·v + M ω = μ F Φ` (Euler), for Φ is convex and
    homogeneous of degree one. Limits of force and moment: `v/|v|` and 0 for pure sliding; 0 and
    `3/8 a E(m)` for pure spin (Johnson 1985; Harris and Kotzalas 2006). Smooth at v = 0, at ω = 0
    and at a circular ellipse, in forward and reverse mode; at rest both are 0.

    **Arguments:**

    - `shape`: the ellipse.
    - `slip`: slip velocity in the two axes of `shape` [m/s].
    - `spin`: angular velocity about the normal, from the first axis to the second [rad/s].
    - `order`: number of Gauss points. For any position of the centre the error is 2e-8 with 16
      points up to a/b = 5, 3e-8 with 20 up to 10, and 1e-6 with 32 up to 50. The error is largest
      for the small moment of a centre beside the ellipse; the error of the force is a hundredth of
      it.
    """
    first, second = slip
    along = shape.first * first + shape.mixed * second
    aside = shape.mixed * first + shape.second * second
    spin_squared, trace = spin**2, shape.first + shape.second
    square, across = first**2 + second**2, first * along + second * aside
    area = spin_squared * shape.product

    # Lower limit of σ, the larger root of a quadratic equation.
    outside = across > (1 + 2 * _EDGE) * area * shape.product
    half = (spin_squared * trace - square) / 2
    root = jnp.sqrt(jnp.where(outside, half**2 + spin_squared * across - area**2, 1.0))
    least = jnp.sqrt(jnp.where(outside, root - half, 1.0))
    least = jnp.where(outside, least, 0.0)

    # 1/√σ = 2y/(1 − c y²), from y = 0: the poles √σ = ± iωa, ± iωb are far from both ends for c of
    # about 2 ω² a b. c is free to choose and needs no derivative; at rest any value will do.
    scale = jax.lax.stop_gradient(jnp.where(spin_squared + square > 0, 2 * area, 1.0))
    places, weights = np.polynomial.legendre.leggauss(order)
    upper = 1 / (least + jnp.sqrt(least**2 + scale))
    y = upper * jnp.asarray((places + 1) / 2, square.dtype)
    bend = scale * y**2
    slope = 2 / (1 - bend)
    x = (slope * y) ** 2
    determinant = 1 + x * (spin_squared * trace + area**2 * x)
    inside = 1 - x * (square + spin_squared * across * x) / determinant
    # Weights of ∫ U σ^(3/2) D^(−3/2) dσ; x is 1/σ.
    weight = upper * jnp.asarray(weights / 2, square.dtype) * (1 + bend) * slope**2
    weight = weight * inside / (determinant * jnp.sqrt(determinant))

    far, near = jnp.sum(weight), jnp.sum(weight * x)
    ring = 2 * area * shape.product
    moment = across * x + (1.25 * inside - 1) * (ring * x + trace)
    return Sliding(
        force=(
            0.75 * (spin_squared * near * along + far * first),
            0.75 * (spin_squared * near * aside + far * second),
        ),
        moment=0.75 * spin * jnp.sum(weight * moment),
    )
