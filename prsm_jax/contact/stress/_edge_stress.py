r"""Stress at the edge of an elliptical Hertz contact with friction, in closed form.

On the surface w = −iσ, so that J₀ = 1 − σ artanh σ + iπσ/2 (see `_subsurface`). At the edge σ =
cos(t − φ), for the point (a cos φ, b sin φ), and the integrals over the direction t are elementary
for the pressure and complete elliptic integrals for the friction. With q = (1 − κ)/(1 + κ) and s =
√q e^{iφ} the pressure alone gives

    σ_yy − σ_xx − 2i τ_xy ∝ (1 − q²)/q · ((s + 1/s) artanh s − 1)

The pressure is 0 there, so the state of stress is plane.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from ...fields import Scalar
from ...numerics import root_or_zero
from ..special_functions import associated_elliptic_integrals, jacobi_of_fraction

#: Nodes in a quarter period; the trapezoidal rule has no error above rounding for κ > 1e-4.
_NODES = 32
#: Below this q a series in q replaces the closed form, which there is a quotient of zeros.
_NEAR_CIRCLE = 0.05
#: Number of its terms; the next is 1e-17.
_TERMS = 12

#: σ_x, σ_y and τ_xy over p₀.
PlaneStress = tuple[Scalar, Scalar, Scalar]
#: ∫cos²t/g, ∫sin²t/g and ∫cos²t sin²t/g³ over the directions, divided by π.
Integrals = tuple[Scalar, Scalar, Scalar]


def edge_integrals(axis_ratio: Scalar) -> Integrals:
    """The complete elliptic integrals of `edge_stress` for κ in (0, 1]."""
    # The integral does not depend on the nodes, so neither do its derivatives.
    fixed = jax.lax.stop_gradient(axis_ratio)
    fraction = jnp.asarray((np.arange(_NODES) + 0.5) / _NODES, fixed.dtype)
    along = jacobi_of_fraction(fraction, fixed)
    quarter_period, _, _ = associated_elliptic_integrals(fixed)
    weights = quarter_period * along.dn * (2 / (np.pi * _NODES))
    # sn = cos t, cn = sin t.
    growth = jnp.sqrt((axis_ratio * along.sn) ** 2 + along.cn**2)
    return (
        jnp.sum(weights * along.sn**2 / growth),
        jnp.sum(weights * along.cn**2 / growth),
        jnp.sum(weights * (along.sn * along.cn) ** 2 / growth**3),
    )


def _of_pressure(angle: Scalar, axis_ratio: Scalar) -> Complex[Array, ""]:
    """(σ_yy − σ_xx)/2 − i τ_xy of the pressure, over p₀ (1 − 2ν)/2, with its sign reversed."""
    q = (1 - axis_ratio) / (1 + axis_ratio)
    near = q < _NEAR_CIRCLE
    turn = jax.lax.complex(jnp.cos(angle), jnp.sin(angle))

    def as_complex(value: Scalar) -> Complex[Array, ""]:
        return value.astype(turn.dtype)

    # Σ 4m/(4m² − 1) q^{m−1} e^{2imφ}
    power = as_complex(jnp.where(near, q, 0.0)) * turn**2
    series = jnp.zeros_like(turn)
    for m in range(_TERMS, 0, -1):
        series = 4 * m / (4 * m**2 - 1) + power * series
    far = jnp.where(near, 0.5, q)
    root = as_complex(jnp.sqrt(far)) * turn
    closed = ((root + 1 / root) * jnp.arctanh(root) - 1) / as_complex(far)
    return as_complex(-(1 - q**2) / 2) * jnp.where(near, turn**2 * series, closed)


def edge_stress(
    angle: Scalar,
    axis_ratio: Scalar,
    poisson_ratio: Scalar,
    traction: Float[Array, "2"],
    integrals: Integrals,
) -> PlaneStress:
    """Stress over p₀ at the edge point (a cos φ, b sin φ), a ≥ b.

    **Arguments:**

    - `angle`: φ.
    - `axis_ratio`: κ = b/a.
    - `poisson_ratio`: ν.
    - `traction`: shear stress over pressure along a and along b.
    - `integrals`: `edge_integrals` of κ.
    """
    cosine, sine = jnp.cos(angle), jnp.sin(angle)
    along, across = traction[0] * jnp.pi, traction[1] * jnp.pi
    first, second = axis_ratio * integrals[0], integrals[1]
    # Those with Poisson's ratio.
    mixed = poisson_ratio * axis_ratio * integrals[2]
    other = axis_ratio * mixed
    x = -along * (first + mixed) * cosine - across * (poisson_ratio * second - other) * sine
    y = -across * (second + other) * sine - along * (poisson_ratio * first - mixed) * cosine
    shear = -across * (first / 2 - mixed) * cosine - along * (second / 2 - other) * sine
    pressed, share = _of_pressure(angle, axis_ratio), (1 - 2 * poisson_ratio) / 2
    radial = share * jnp.real(pressed)
    return x - radial, y + radial, shear - share * jnp.imag(pressed)


def _mean_and_radius(stress: PlaneStress) -> tuple[Scalar, Scalar]:
    """Middle and radius of Mohr's circle in the surface."""
    x, y, shear = stress
    return (x + y) / 2, root_or_zero(((x - y) / 2) ** 2 + shear**2)


def plane_von_mises(stress: PlaneStress) -> Scalar:
    """`von_mises_stress` of a state of plane stress."""
    mean, radius = _mean_and_radius(stress)
    return root_or_zero(mean**2 + 3 * radius**2)


def plane_max_shear(stress: PlaneStress) -> Scalar:
    """`max_shear_stress` of a state of plane stress."""
    mean, radius = _mean_and_radius(stress)
    return jnp.maximum(radius, (jnp.abs(mean) + radius) / 2)


def plane_tension(stress: PlaneStress) -> Scalar:
    """Largest principal stress of a state of plane stress."""
    mean, radius = _mean_and_radius(stress)
    return jnp.maximum(mean + radius, 0.0)
