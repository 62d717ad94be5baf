r"""Stress tensor below an elliptical Hertz contact with Coulomb friction.

The load is a superposition of plane waves. In the direction of each wave the half-space is in plane
strain (and antiplane shear), where its solution is elementary, and the wave numbers integrate in
closed form:

    p̂ ∝ (sin κ − κ cos κ)/κ³,   ∫ … e^{−κw} dκ → J₀ = 1 − w arccot w,  J₁ = arccot w − w/(1 + w²)

with w = g z − iσ, σ = (x cos t)/a + (y sin t)/b and g² = cos²t/a² + sin²t/b². There remains one
integral of an analytic function over the direction t. Its variable spreads the poles evenly for
every axis ratio (t = π/2 + am u). It runs between the two directions normal to the direction of the
point, where the edge of the contact makes it singular, by a double exponential rule. The path is
shifted into the complex plane, away from the singularities caused by the surface outside the
contact. So one rule serves every point.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from ...fields import Scalar
from ...numerics import above_or_nan
from ...programs import physics
from ..special_functions import (
    Jacobi,
    associated_elliptic_integrals,
    jacobi_complex,
    jacobi_of_direction,
    jacobi_of_fraction,
    jacobi_sum,
)

#: Nodes of the rule; its error is given in the documentation.
NODES = 64

#: Share of the range that the double exponential rule omits at the ends.
_END = 1e-12
#: Shift of the path for points far from the contact: sn of the imaginary part, 1 at the pole.
_SHIFT = 0.85


def _rule(nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes v and weights of ∫₀¹ f(v) dv by v = ½ (1 + tanh(½ sinh x)).

    The nodes are those of the lower half; the upper half is its mirror image, kept separately so
    that the distance to the upper end keeps all digits.
    """
    step = 2 * np.arcsinh(-np.log(_END)) / nodes
    x = -step * (np.arange(nodes // 2) + 0.5)
    inner = np.sinh(x)
    lower = 1 / (1 + np.exp(-inner))
    return lower, step * np.cosh(x) * lower * (1 - lower)


def _directions(
    x: Scalar, y: Scalar, axis_ratio: Scalar, nodes: int
) -> tuple[Complex[Array, " n"], Complex[Array, " n"], Complex[Array, " n"]]:
    """cos t and sin t along the path of integration over half the directions, and the weights dt.

    **Arguments:** the point over the semi-axes, κ, and the number of nodes.
    """
    lower, weights = _rule(nodes)
    dtype = axis_ratio.dtype
    # Two quarter periods 2K; the lower half of the range is one of them.
    quarter = jacobi_of_fraction(2 * jnp.asarray(lower, dtype), axis_ratio)
    along = Jacobi(
        jnp.concatenate([quarter.sn, quarter.sn]),
        jnp.concatenate([quarter.cn, -quarter.cn]),
        jnp.concatenate([quarter.dn, quarter.dn]),
    )
    quarter_period, _, _ = associated_elliptic_integrals(axis_ratio)
    measure = 2 * quarter_period * jnp.asarray(np.concatenate([weights, weights]), dtype)

    square = x**2 + y**2
    off_axis = above_or_nan(square)
    radius = jnp.sqrt(jnp.where(off_axis, square, 1.0))
    cosine, sine = jnp.where(off_axis, x, 1.0) / radius, jnp.where(off_axis, y, 0.0) / radius
    start = jacobi_of_direction(sine, -cosine, axis_ratio)
    real = jacobi_sum(Jacobi(*(part[None] for part in start)), along, axis_ratio)
    # sn of the imaginary part, proportional to the slope of σ along the path; points over the
    # middle of the contact have no singularity to avoid.
    size = _SHIFT * square / (square + 0.25)
    shift = size * (real.cn * start.sn - real.sn * start.cn)
    slope = -size * real.dn * (real.sn * start.sn + real.cn * start.cn)
    imaginary = Jacobi(shift, jnp.sqrt(1 - shift**2), jnp.sqrt(1 - (axis_ratio * shift) ** 2))
    sn, cn, dn = jacobi_complex(real, imaginary, axis_ratio)
    step = jax.lax.complex(measure, measure * slope / (imaginary.cn * imaginary.dn))
    return -sn, cn, dn * step


def _radial_integrals(
    below: Complex[Array, " n"],
) -> tuple[Complex[Array, " n"], Complex[Array, " n"]]:
    """J₀ = 1 − w arccot w and J₁ = arccot w − w/(1 + w²) for Re w ≥ 0."""
    real, imaginary = jnp.real(below), jnp.imag(below)
    # At the edge of the contact w = ±i: integrable; the floor keeps log and division finite.
    floor = jnp.finfo(real.dtype).eps ** 2
    upper = real**2 + (imaginary - 1) ** 2 + floor
    lower = real**2 + (imaginary + 1) ** 2 + floor
    angle = jnp.arctan2(2 * real, real**2 + imaginary**2 - 1) / 2
    inverse = jax.lax.complex(angle, (jnp.log(upper) - jnp.log(lower)) / 4)
    # w/(1 + w²) as half the sum of 1/(w − i) and 1/(w + i).
    quotient = jax.lax.complex(
        real / upper + real / lower, -(imaginary - 1) / upper - (imaginary + 1) / lower
    )
    return 1 - below * inverse, inverse - quotient / 2


def reduced_stress(
    point: Float[Array, "3"],
    axis_ratio: Scalar,
    poisson_ratio: Scalar,
    traction: Float[Array, "2"] | None,
    nodes: int,
) -> Float[Array, "3 3"]:
    """Stress over p₀ at the point (x/a, y/b, z/b), a ≥ b; see `subsurface_stress`."""
    # The integral does not depend on the path, so neither do its derivatives.
    path = jax.lax.stop_gradient((point[0], point[1], axis_ratio))
    cos_t, sin_t, weights = _directions(*path, nodes)

    def as_complex(value: Scalar) -> Complex[Array, ""]:
        return value.astype(cos_t.dtype)

    ratio, poisson = as_complex(axis_ratio), as_complex(poisson_ratio)
    x, y, depth = (as_complex(point[i]) for i in range(3))
    growth = jnp.sqrt((ratio * cos_t) ** 2 + sin_t**2)
    # Direction of the wave.
    cosine, sine = ratio * cos_t / growth, sin_t / growth
    decay = depth * growth
    first, second = _radial_integrals(decay - 1j * (x * cos_t + y * sin_t))
    second = decay * second

    # In the direction of the wave (l), normal to it (t) and in depth (z).
    ll, tt, zz = second - first, -2 * poisson * first, -first - second
    lz = 1j * second
    lt = tz = None
    if traction is not None:
        along, across = as_complex(traction[0]), as_complex(traction[1])
        drag, side = along * cosine + across * sine, across * cosine - along * sine
        ll = ll + 1j * drag * (2 * first - second)
        tt = tt + 2j * poisson * drag * first
        zz = zz + 1j * drag * second
        lz = lz - drag * (first - second)
        lt, tz = 1j * side * first, -side * first

    xx = cosine**2 * ll + sine**2 * tt
    yy = sine**2 * ll + cosine**2 * tt
    xy = cosine * sine * (ll - tt)
    xz, yz = cosine * lz, sine * lz
    if lt is not None and tz is not None:
        xx, yy = xx - 2 * cosine * sine * lt, yy + 2 * cosine * sine * lt
        xy = xy + (cosine**2 - sine**2) * lt
        xz, yz = xz - sine * tz, yz + cosine * tz
    # The other half of the directions is the complex conjugate.
    parts = jnp.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz])
    return (jnp.sum(jnp.real(weights[None] * parts), axis=-1) / jnp.pi).reshape(3, 3)


@physics("subsurface_stress")
def subsurface_stress(
    point: Float[Array, "3"],
    semi_axes: Float[Array, "2"],
    max_pressure: Scalar,
    poisson_ratio: Scalar,
    traction: Float[Array, "2"] | None = None,
    *,
    nodes: int = NODES,
) -> Float[Array, "3 3"]:
    r"""Stress tensor in a half-space under a Hertz pressure and its friction.

    The pressure `p = p₀ √(1 − x²/a² − y²/b²)` and the shear traction `q = (t_x, t_y) p` act on the
    surface z = 0 of the body z ≥ 0. Tension is positive. Any axis ratio from a circle to a needle,
    any point in the body and on its surface; differentiable in everything except at the edge of the
    contact, where the stress has an infinite slope. For batches use `jax.vmap`.

    The two bodies of a contact carry opposite tractions; each is this half-space, seen in its own
    coordinates. If the bodies have equal elastic constants, friction does not change the pressure.

    **Arguments:**

    - `point`: (x, y, z) [m], z ≥ 0 into the body.
    - `semi_axes`: semi-axes of the contact along x and along y [m]; either may be the longer one.
    - `max_pressure`: p₀ [Pa].
    - `poisson_ratio`: ν of this body.
    - `traction`: shear traction per pressure that acts on this body in x and y: under full sliding
      its magnitude is μ, opposite to this body's velocity relative to the other. Without it no
      friction is traced.
    - `nodes`: nodes of the quadrature, even.

    **Returns:** the symmetric stress tensor [Pa]; 0 without a load (semi-axes 0).

    **Raises:** `ValueError` for an odd number of nodes or fewer than 8.

    Source: half-space under waves of pressure and shear, Johnson 1985, chapters 2 and 3; checked
    against Hamilton 1983, Thomas and Hoersch 1930, and direct integration.
    """
    if nodes < 8 or nodes % 2:
        raise ValueError(f"nodes is {nodes}; the rule needs an even number, at least 8")
    unloaded = jnp.min(semi_axes) <= 0
    semi_axes = jnp.where(unloaded, 1.0, semi_axes)
    max_pressure = jnp.where(unloaded, 0.0, max_pressure)
    # In the frame of the longer axis, κ ≤ 1.
    turned = semi_axes[1] > semi_axes[0]
    major, minor = jnp.max(semi_axes), jnp.min(semi_axes)

    def swapped(vector: Array) -> Array:
        return jnp.where(turned, vector[..., jnp.asarray([1, 0])], vector)

    flat, inwards = swapped(point[:2]), point[2] / minor
    reduced = jnp.stack([flat[0] / major, flat[1] / minor, inwards])
    pulled = None if traction is None else swapped(traction)
    stress = reduced_stress(reduced, minor / major, poisson_ratio, pulled, nodes)
    order = jnp.asarray([1, 0, 2])
    return max_pressure * jnp.where(turned, stress[order][:, order], stress)
