"""Friction of a Hertz ellipse that slides and spins at once, from one dissipation potential.

The pressure of a Hertz ellipse is that of a ball of constant density, pressed flat. So the mean of
|u| over the contact, u = v + ω n × r, is an integral over directions e in the tangent plane,
because `|u| = ¼ ∮ |u·e| dθ` and because u·e has the density ¾ (1 − t²) of a coordinate in a ball:

    Φ(v, ω) = ¼ ∮ s g(k) dθ,   k = v·e/s,   s = ω × half-width of the ellipse across e,
    g(k) = 3/8 + 3/4 k² − k⁴/8 for |k| < 1, else |k|.

k = ±1 only where the contact's instantaneous centre lies outside the ellipse; integration by parts
then leaves an integral over −1 < k < 1 alone, whose integrand is analytic.
"""

import math
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..geometry import RelativeCurvature
from ..mechanism import Scalar
from ._hertz import HertzContact, anisotropy_of

#: From this order on one transformation more spreads the nodes.
_MANY = 25
#: Past the edge of the ellipse by less than this, the centre counts as inside: the error of that is
#: below 1e-12, and the other form has a derivative without bound at the edge itself.
_EDGE = 1e-5
#: Half-angle below which series are exact to rounding and no node has to be spread.
_NARROW = 1e-4
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


class _Root(NamedTuple):
    """Inverse of the symmetric root of the ellipse's matrix, turned by a right angle [1/m]."""

    xx: Scalar
    xy: Scalar
    yy: Scalar


def _inverse_root(shape: EllipseShape) -> _Root:
    # Across e the ellipse is as wide as along n × e: the matrix turned by a right angle.
    scale = jnp.sqrt(shape.first + shape.second + 2 * shape.product) * shape.product
    return _Root(
        (shape.first + shape.product) / scale,
        shape.mixed / scale,
        (shape.second + shape.product) / scale,
    )


class _Spread(NamedTuple):
    """Where directions have to be dense: axis ratio and axis of the ellipse, never differentiated.

    Directions are counted from the middle between two of those in which the ellipse is widest.
    """

    quotients: tuple[Scalar, ...]
    origin: Scalar

    def flattened(self, angle):
        """The variable in which the integrand is smooth, by ascending Landen transformations."""
        for quotient in self.quotients:
            ratio = (1 - quotient) / (1 + quotient)
            sine, cosine = jnp.sin(angle), jnp.cos(angle)
            behind = jnp.arctan2((1 - ratio) * sine * cosine, cosine**2 + ratio * sine**2)
            angle = 2 * angle - behind
        return angle

    def restored(self, variable):
        """Angles of the variable, and their derivative."""
        slope = jnp.ones_like(variable)
        for quotient in reversed(self.quotients):
            sine = quotient * jnp.sin(variable)
            root = jnp.sqrt(1 - sine**2)
            slope = slope * (0.5 + 0.5 * quotient * jnp.cos(variable) / root)
            variable = 0.5 * (variable + jnp.arcsin(sine))
        return variable, slope


def _spread(shape: EllipseShape, order: int) -> _Spread:
    shape = jax.lax.stop_gradient(shape)
    difference, mean = shape.second - shape.first, (shape.first + shape.second) / 2
    larger = mean + jnp.sqrt((difference / 2) ** 2 + shape.mixed**2)
    arithmetic, geometric = jnp.ones_like(mean), shape.product / larger
    quotients = []
    for _ in range(3 if order >= _MANY else 2):
        quotients.append((arithmetic - geometric) / (arithmetic + geometric))
        arithmetic, geometric = (arithmetic + geometric) / 2, jnp.sqrt(arithmetic * geometric)
    widest = 0.5 * jnp.arctan2(-2 * shape.mixed, difference)
    return _Spread(tuple(quotients), widest - jnp.pi / 2)


class _Nodes(NamedTuple):
    """Directions of the rule by their angle ψ, and what they weigh."""

    cosine: Float[Array, " nodes"]
    sine: Float[Array, " nodes"]
    #: 1 − k².
    left: Float[Array, " nodes"]
    #: Weights of an integral over k, and over ψ.
    over_share: Float[Array, " nodes"]
    over_angle: Float[Array, " nodes"]


def _around(spread, order, first, second) -> _Nodes:
    """The rule where the instantaneous centre lies in the ellipse, at (first, second) of its radii.

    Equal weights in the flattened variable over half a turn converge geometrically.
    """
    period = math.pi if spread is None else math.pi * 2 ** len(spread.quotients)
    angle = jnp.asarray((np.arange(order) + 0.5) * (period / order), first.dtype)
    weights = jnp.full_like(angle, period / order)
    if spread is not None:
        angle, slope = spread.restored(angle)
        angle, weights = jax.lax.stop_gradient((angle + spread.origin, weights * slope))
    cosine, sine = jnp.cos(angle), jnp.sin(angle)
    k = first * cosine + second * sine
    return _Nodes(cosine, sine, 1 - k**2, weights * (first * sine - second * cosine), weights)


def _across(spread, order, cosine, sine, ratio) -> _Nodes:
    """The rule where the instantaneous centre lies outside, seen at an angle of this cosine.

    `ratio` is the ellipse's radius over the distance of the centre. Gauss's rule over those
    directions e across which the centre is seen within the ellipse, |k| < 1.
    """
    places, weights = np.polynomial.legendre.leggauss(order)
    # Pure sliding is then exact.
    weights = weights / np.sum(0.75 * weights * (1 - places**2))
    places, weights = jnp.asarray(places, ratio.dtype), jnp.asarray(weights, ratio.dtype)
    half = jnp.arcsin(ratio)
    if spread is not None:
        # Where the nodes are needs no derivative; between which limits they lie does.
        places, weights = jax.lax.stop_gradient(
            _dense(spread, half, jnp.arctan2(sine, cosine), places, weights)
        )
    narrow = jnp.abs(half) < _NARROW
    safe = jnp.where(narrow, 1.0, ratio)
    along, across = jnp.cos(half * places), jnp.sin(half * places)
    # k = −sin(δ)/sin(half), and its series.
    k = jnp.where(narrow, places * (1 + half**2 / 6 * (1 - places**2)), across / safe)
    whole = jnp.where(narrow, 1 + half**2 / 6, half / safe)
    return _Nodes(
        -sine * along - cosine * across,
        cosine * along - sine * across,
        1 - k**2,
        weights * along * whole,
        weights * half,
    )


def _dense(spread, half, middle, places, weights):
    """Places of nodes within the limits, in units of the half-angle, and their weights."""
    wide = jnp.abs(half) > _NARROW
    safe = jnp.where(wide, half, 1.0)
    middle = middle + jnp.pi / 2 - spread.origin
    lower, upper = spread.flattened(middle - safe), spread.flattened(middle + safe)
    angle, slope = spread.restored((lower + upper) / 2 + (upper - lower) / 2 * places)
    weights = weights * jnp.where(wide, slope * (upper - lower) / (2 * safe), 1.0)
    return jnp.where(wide, (angle - middle) / safe, places), weights


def slip_and_spin(
    shape: EllipseShape,
    slip: tuple[Scalar, Scalar],
    spin: Scalar,
    order: int = 32,
    elongated: bool = True,
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
    - `order`: points of the rule. 32 give 1e-7 up to a/b = 50 wherever the centre lies.
    - `elongated`: spread the points for long ellipses. Without, 24 points give 1e-11 up to
      a/b = 1.3, and up to 3 where the centre lies two radii away; five times cheaper.
    """
    root = _inverse_root(shape)
    spread = _spread(shape, order) if elongated else None
    # The slip where the ellipse is a disc: the instantaneous centre, times the spin.
    first = root.xx * slip[0] + root.xy * slip[1]
    second = root.xy * slip[0] + root.yy * slip[1]
    square = first**2 + second**2
    inside = (square <= ((1 + _EDGE) * spin) ** 2) & (spin != 0)
    moves = inside | (square > 0)
    # The sense of the spin only mirrors where the centre is; it must not hide a derivative.
    size = jnp.where(inside, jnp.abs(spin), 1.0)
    distance = jnp.sqrt(jnp.where(inside | ~moves, 1.0, square))
    within = _around(spread, order, first / size, second / size)
    beyond = _across(
        spread, order, first / distance, second / distance, jnp.where(inside, 0.0, spin) / distance
    )
    nodes = jax.tree.map(lambda near, far: jnp.where(inside, near, far), within, beyond)
    # Half-widths of the ellipse across directions e, and these; dθ = width²/(a b) dψ.
    x = root.xx * nodes.cosine + root.xy * nodes.sine
    y = root.xy * nodes.cosine + root.yy * nodes.sine
    width = 1 / jnp.sqrt(x**2 + y**2)
    force = 0.75 * nodes.left * nodes.over_share * width
    moment = jnp.sum(nodes.over_angle * nodes.left**2 * width**3) * (3 / 16) / shape.product
    sense = jnp.where(inside, jnp.sign(jax.lax.stop_gradient(spin)), 1.0)
    found = Sliding((jnp.sum(force * y), -jnp.sum(force * x)), sense * moment)
    return jax.tree.map(lambda part: jnp.where(moves, part, 0.0), found)
