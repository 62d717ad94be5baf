"""Friction of a Hertz ellipse that slides and spins at once, from one dissipation potential.

The local slip is u = v + ω n × r, so |u| = |ω| |r − r₀| with the instantaneous centre r₀. The mean
of |r − r₀| under Hertz's pressure is the biharmonic potential of a ball of constant density,
pressed flat; as with the Newtonian one (Eshelby 1959; Mura 1987, section 11) its gradient is an
integral over confocal ellipses. In σ, ω² times their parameter, with the ellipse's matrix Σ,

    D = det(ω² Σ + σ),   U = 1 − (ω² v·Σv + σ v·v)/D,

    ∂Φ/∂v = ¾ ∫ U √σ (ω² Σ v + σ v) D^(−3/2) dσ,

    ∂Φ/∂ω = ¾ ω ∫ U √σ (v·Σv + (5/4 U − 1)(2 ω² det Σ + σ tr Σ)) D^(−3/2) dσ,

from the σ at which U vanishes, or from 0 where the centre lies in the ellipse, to infinity. They
are incomplete elliptic integrals, or complete ones in polynomials of the centre.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ..geometry import RelativeCurvature
from ..mechanism import Scalar
from .hertz import HertzContact, anisotropy_of

#: The centre counts as inside the ellipse up to this share of the axes past its edge, where the
#: limit of the integrals has a derivative without bound; the error of that is below 1e-12.
_EDGE = 1e-5
#: Near a circle (a² − b²)/(B − A) is its series.
_ROUND = 1e-5


class EllipseShape(eqx.Module):
    """Half-axes of a contact ellipse as a matrix, in two axes of the tangent plane.

    The ellipse is `rᵀ Σ⁻¹ r ≤ 1`. Σ is a smooth function of the curvatures also where the ellipse
    is a circle and has no principal axes.
    """

    #: Σ's entries [m²].
    first: Scalar
    second: Scalar
    mixed: Scalar
    #: a b [m²].
    product: Scalar


class Sliding(NamedTuple):
    """Gradient of the mean local slip speed Φ, which is Coulomb friction per μ F."""

    #: ∂Φ/∂v: force per unit of μ F, in both axes; at most 1 long.
    force: tuple[Scalar, Scalar]
    #: ∂Φ/∂ω: moment about the normal per unit of μ F [m].
    moment: Scalar


def ellipse_shape(hertz: HertzContact, curvature: RelativeCurvature) -> EllipseShape:
    """Matrix of a contact ellipse in the rolling direction and the tangent across it.

    `Σ = ½ (a² + b²) 1 − (a² − b²)/(B − A) · (S − ½ (A + B) 1)` with the tensor S of the gap: the
    ellipse is long where the gap is flat.
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
    homogeneous of degree one. Limits: pure sliding `v/|v|` and 0; pure spin 0 and `3/8 a E(m)`
    (Johnson 1985; Harris and Kotzalas 2006). Smooth at v = 0, at ω = 0 and at a circular ellipse,
    in forward and reverse mode; at rest both are 0.

    **Arguments:**

    - `shape`: the ellipse.
    - `slip`: slip velocity in the two axes of `shape` [m/s].
    - `spin`: angular velocity about the normal, from the first axis to the second [rad/s].
    - `order`: points of Gauss's rule. Wherever the centre lies, 16 give 2e-8 up to a/b = 5, 20
      give 3e-8 up to 10, and 32 give 1e-6 up to 50. The largest error is that of a small moment
      of a centre beside the ellipse; that of the force is a hundredth of it.
    """
    first, second = slip
    along = shape.first * first + shape.mixed * second
    aside = shape.mixed * first + shape.second * second
    turned, trace = spin**2, shape.first + shape.second
    square, across = first**2 + second**2, first * along + second * aside
    area = turned * shape.product

    # The least σ, the larger root of a quadratic in it.
    outside = across > (1 + 2 * _EDGE) * area * shape.product
    half = (turned * trace - square) / 2
    root = jnp.sqrt(jnp.where(outside, half**2 + turned * across - area**2, 1.0))
    least = jnp.sqrt(jnp.where(outside, root - half, 1.0))
    least = jnp.where(outside, least, 0.0)

    # 1/√σ = 2y/(1 − c y²), from y = 0: the poles √σ = ± iωa, ± iωb are far from both ends for
    # c of about 2 ω² a b. That is a choice, and has no derivative; at rest it is any other.
    scale = jax.lax.stop_gradient(jnp.where(turned + square > 0, 2 * area, 1.0))
    places, weights = np.polynomial.legendre.leggauss(order)
    upper = 1 / (least + jnp.sqrt(least**2 + scale))
    y = upper * jnp.asarray((places + 1) / 2, square.dtype)
    bend = scale * y**2
    slope = 2 / (1 - bend)
    x = (slope * y) ** 2
    determinant = 1 + x * (turned * trace + area**2 * x)
    inside = 1 - x * (square + turned * across * x) / determinant
    # Of ∫ U σ^(3/2) D^(−3/2) dσ, and x is 1/σ.
    weight = upper * jnp.asarray(weights / 2, square.dtype) * (1 + bend) * slope**2
    weight = weight * inside / (determinant * jnp.sqrt(determinant))

    far, near = jnp.sum(weight), jnp.sum(weight * x)
    ring = 2 * area * shape.product
    moment = across * x + (1.25 * inside - 1) * (ring * x + trace)
    return Sliding(
        force=(
            0.75 * (turned * near * along + far * first),
            0.75 * (turned * near * aside + far * second),
        ),
        moment=0.75 * spin * jnp.sum(weight * moment),
    )
