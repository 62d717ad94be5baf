r"""Contact ellipses that extend beyond the end of a flank: load on the remaining part.

A lamina model, calibrated to Hertz contacts. The contact is divided into laminae along the edge.
Each lamina keeps the Hertz pressure at the common approach of the bodies; laminae beyond the edge
carry no load. So at a given approach the contact loses the load of the part that is cut off,

$$F = F_H(\delta)\,\bigl(1 - \textstyle\sum f(t)\bigr),\qquad f(t) = \tfrac14 (1-t)^2 (2+t),$$

with $t$ the distance to the edge over the half-extent of the ellipse towards it. Under a given load
the bodies approach further and the largest pressure rises. The half-extent is proportional to the
Hertz pressure, so one number describes an end: the Hertz pressure at which the ellipse reaches it.
For flanks without ends none of this is traced.

The model does not include the pressure concentration at the edge itself: at a sharp edge it has no
finite value, and at a rounded edge it depends on the rounding (`docs/strength.md` gives both).
"""

import functools
import math
from collections.abc import Sequence
from typing import TypeAlias

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar
from ..geometry import FlankEnd, RelativeCurvature
from ..numerics import above_or_nan, below_or_nan, horner, root_or_zero
from ..programs import physics
from .hertz import HertzContact

#: Hertz pressures at which the ellipse reaches the nearest end, one per direction [Pa].
Onsets: TypeAlias = tuple[Scalar, ...]
Real = Float[Array, "*batch"]

#: Below this anisotropy (a² − b²)/(B − A) takes its value at the circle; the error of s² is of
#: second order.
_CIRCULAR = 1e-5
#: Least distance to an end over the half-extent, which keeps results finite. A contact point beyond
#: its flank has no pressure; the calling function sets a flag for it.
_LEAST = 0.01
#: Upper limit of this ratio; no ellipse reaches such an end.
_FAR = 1e3
#: A Hertz pressure that no contact has [Pa].
_NEVER_REACHED = 1e30
#: Integral of (1 − y²)^{9/2} from 0 to 1.
_HALF_INTEGRAL = 63 * math.pi / 512
#: ∫ cos¹⁰θ dθ = sin θ cos θ Σ c cosⁿθ + c₀ θ: c for n = 0, 2, 4, 6 and 8.
_BY_PARTS = (63 / 256, 21 / 128, 21 / 160, 9 / 80, 1 / 10)


def half_extents(
    hertz: HertzContact, curvature: RelativeCurvature, ends: Sequence[FlankEnd]
) -> list[Scalar]:
    """Halves of the extent of a contact ellipse towards ends of its flanks, √(nᵀ M n) [m].

    With c the gap's coefficient in the direction n,
    `s² = (a² + b²)/2 − (a² − b²)/(B − A) (c − (A + B)/2)`, regular at the circle. Only c differs
    between the ends of a flank.

    **Arguments:**

    - `hertz`, `curvature`: the contact under a load, and the curvatures of its gap.
    - `ends`: the ends; one without a coefficient lies across the rolling direction.

    **Returns:** one for each end.
    """
    total, squared = curvature.total, curvature.difference_squared
    major, minor = hertz.semi_major, hertz.semi_minor
    elongated = squared > (_CIRCULAR * total) ** 2
    difference = jnp.sqrt(jnp.where(elongated, squared, 1.0))
    rate = jnp.where(
        elongated, (major - minor) * (major + minor) / difference, 8 / 3 * major**2 / total
    )
    mean = (major**2 + minor**2) / 2
    # Crest and root of a body lie in one direction, and have the same coefficient.
    coefficients = {id(end.coefficient): end.coefficient for end in ends}
    across = total - curvature.rolling
    extents = {
        # Between b² and a², up to rounding.
        key: root_or_zero(mean - rate * ((across if c is None else c) - total / 2))
        for key, c in coefficients.items()
    }
    return [extents[id(end.coefficient)] for end in ends]


def half_extent(hertz: HertzContact, curvature: RelativeCurvature, end: FlankEnd) -> Scalar:
    """Half the extent of a contact ellipse towards one end, as `half_extents` [m]."""
    return half_extents(hertz, curvature, (end,))[0]


@physics("truncation")
def onset_pressures(
    hertz: HertzContact, curvature: RelativeCurvature, ends: tuple[FlankEnd, ...]
) -> Onsets:
    """Hertz pressures at which the ellipse reaches the nearest end, one per direction.

    **Arguments:**

    - `hertz`: the contact under some load above 0.
    - `curvature`: of its gap.
    - `ends`: the ends of its flanks.
    """
    ways: dict[str, Scalar] = {}
    # Semi-axes and pressure are both proportional to the cube root of the load: any load will do.
    for end, extent in zip(ends, half_extents(hertz, curvature, ends), strict=True):
        onset = end.distance * hertz.max_pressure / extent
        ways[end.way] = jnp.minimum(ways[end.way], onset) if end.way in ways else onset
    return tuple(ways.values())


def _reach(pressure: Real, onset: Scalar) -> Real:
    """t: distance to the end over the half-extent of the ellipse."""
    loaded = above_or_nan(pressure)
    reach = jnp.where(loaded, onset / jnp.where(loaded, pressure, 1.0), _FAR)
    return jnp.clip(reach, _LEAST, _FAR)


def _two_reaches(pressure: Real, onsets: Onsets) -> tuple[Real, Real]:
    """Distances to the ends in both directions; `_FAR` where there is only one."""
    reaches = [_reach(pressure, onset) for onset in onsets]
    if len(reaches) == 1:
        reaches.append(jnp.full_like(reaches[0], _FAR))
    first, second = reaches
    return first, second


def truncation(pressure: Real, onsets: Onsets) -> Real:
    """Largest share of the ellipse's half-extent beyond an end, 1 − t; 0 if no end is reached.

    Continuous; its derivative has a step where the ellipse reaches the end, and is 0 before. Above
    1 where the contact point itself lies beyond the end.

    **Arguments:**

    - `pressure`: Hertz pressure of the load [Pa].
    - `onsets`: from `onset_pressures`.
    """
    shares = []
    for onset in onsets:
        passed = above_or_nan(pressure, onset) & above_or_nan(pressure)
        shares.append(jnp.where(passed, 1 - onset / jnp.where(passed, pressure, 1.0), 0.0))
    return functools.reduce(jnp.maximum, shares)


def load_beyond(reach: Real) -> Real:
    """Share of a Hertz contact's load beyond a line, f(t) = (1 − t)² (2 + t)/4.

    **Arguments:**

    - `reach`: t, distance of the line from the centre over the half-extent; 1 touches.
    """
    rest = 1 - jnp.minimum(reach, 1.0)
    return rest**2 * (3 - rest) / 4


@jax.custom_jvp
def risk_beyond(reach: Real) -> Real:
    r"""Share of a Hertz contact's fatigue risk beyond a line along the rolling direction.

    The risk of a lamina is proportional to $p^{c+1-h} = p^9$, so the share is
    $\int_t^1 (1-y^2)^{9/2} dy / \int_{-1}^1 (1-y^2)^{9/2} dy$: the summation over laminae of
    ISO/TS 16281 with the exponents of point contacts.

    **Arguments:**

    - `reach`: t, distance of the line from the centre over the half-extent; 1 touches.
    """
    inside = jnp.minimum(reach, 1.0)
    density = (1 - inside) * (1 + inside)
    # By parts: with y = sin θ it is ∫ cos¹⁰θ dθ.
    regular = inside * root_or_zero(density) * horner(_BY_PARTS, density)
    integral = regular + _BY_PARTS[0] * jnp.arcsin(inside)
    return jnp.where(below_or_nan(reach, 1.0), (1 - integral / _HALF_INTEGRAL) / 2, 0.0)


def _risk_density(reach: Real) -> Real:
    """−dw/dt of `risk_beyond`."""
    inside = jnp.minimum(reach, 1.0)
    density = (1 - inside) * (1 + inside)
    # Beyond the end both are 0, and the derivative of the root is infinite.
    return root_or_zero(density) * density**4 / (2 * _HALF_INTEGRAL)


@risk_beyond.defjvp
def _risk_beyond_jvp(primals, tangents):
    (reach,), (tangent,) = primals, tangents
    return risk_beyond(reach), -_risk_density(reach) * tangent


@jax.custom_jvp
def _ratio(first: Real, second: Real) -> Real:
    """σ of σ³ (1 − f(t₁/σ) − f(t₂/σ)) = 1, in closed form.

    With a cut at one end only: 2σ³ + 3tσ² − t³ = 4, a cubic with the root
    `σ = t cosh(arcosh(1 + 8/t³)/3) − t/2`. With cuts at both ends:
    `3 (t₁ + t₂) σ² = 4 + t₁³ + t₂³`.
    """
    near, far = jnp.minimum(first, second), jnp.maximum(first, second)
    # The cube root of w + √(w² − 1), with w² − 1 free of cancellation.
    steep = 8 / near**3
    root = jnp.cbrt(1 + steep + jnp.sqrt(steep * (2 + steep)))
    at_one = near / 2 * (root + 1 / root - 1)
    at_both = jnp.sqrt((4 + near**3 + far**3) / (3 * (near + far)))
    return jnp.where(below_or_nan(near, 1.0), jnp.where(at_one > far, at_both, at_one), 1.0)


def _ratio_slopes(ratio: Real, reaches: tuple[Real, Real]) -> tuple[Real, Real]:
    """Derivatives of `_ratio` by both distances."""
    # σ³ f(t/σ) = (2σ³ − 3σ²t + t³)/4 past an end.
    past = [jnp.maximum(ratio - reach, 0.0) for reach in reaches]
    slope = 3 * ratio**2 - 1.5 * ratio * (past[0] + past[1])
    first, second = (
        -0.75 * one * (ratio + reach) / slope for one, reach in zip(past, reaches, strict=True)
    )
    return first, second


@_ratio.defjvp
def _ratio_jvp(primals, tangents):
    ratio = _ratio(*primals)
    first, second = _ratio_slopes(ratio, primals)
    return ratio, first * tangents[0] + second * tangents[1]


@jax.custom_jvp
def _risk_ratio(first: Real, second: Real) -> Real:
    """`risk_ratio` by the distances to both ends."""
    ratio = _ratio(first, second)
    return ratio**10 * (1 - risk_beyond(first / ratio) - risk_beyond(second / ratio))


@_risk_ratio.defjvp
def _risk_ratio_jvp(primals, tangents):
    # With u = t/σ and −w′ the density of the risk:
    # ∂(σ¹⁰ S)/∂t = σ⁹ ((10 S + Σ u w′) ∂σ/∂t − w′).
    ratio = _ratio(*primals)
    first, second = (reach / ratio for reach in primals)
    share = 1 - risk_beyond(first) - risk_beyond(second)
    densities = _risk_density(first), _risk_density(second)
    power, grown = ratio**9, 10 * share - first * densities[0] - second * densities[1]
    changes = [
        (grown * slope + density) * tangent
        for slope, density, tangent in zip(
            _ratio_slopes(ratio, primals), densities, tangents, strict=True
        )
    ]
    return power * ratio * share, power * (changes[0] + changes[1])


def pressure_ratio(pressure: Real, onsets: Onsets) -> Real:
    """Largest pressure of the truncated contact over the Hertz pressure of the same load, σ ≥ 1.

    The approach is σ² times as large. An untruncated ellipse has the same pressure at σ³ times the
    load. Value and first derivative are continuous where the ellipse reaches an end; exactly 1
    before.

    **Arguments:**

    - `pressure`: Hertz pressure of the load [Pa].
    - `onsets`: from `onset_pressures`.
    """
    return _ratio(*_two_reaches(pressure, onsets))


def share_within(pressure: Real, onsets: Onsets) -> Real:
    """Share of a Hertz contact's load within the flanks, 1 − Σ f(t), at this pressure.

    The load of the truncated contact over the load of the full ellipse, at equal largest pressure.

    **Arguments:**

    - `pressure`: largest pressure of both contacts [Pa].
    - `onsets`: from `onset_pressures`.
    """
    share = jnp.ones_like(pressure)
    for onset in onsets:
        share = share - load_beyond(_reach(pressure, onset))
    return share


def risk_ratio(pressure: Real, onsets: Onsets) -> Real:
    """Fatigue risk of the truncated contact over the risk of the full ellipse under the same load.

    `σ¹⁰ (1 − Σ w(t))`: the risk of a full ellipse is proportional to p¹⁰, and the part cut off has
    none.

    **Arguments:**

    - `pressure`: Hertz pressure of the load [Pa].
    - `onsets`: from `onset_pressures`.
    """
    return _risk_ratio(*_two_reaches(pressure, onsets))


def padded_onsets(onsets: Sequence[Onsets]) -> list[Onsets]:
    """Onsets of several contacts, all with the same number of ends: added ones are never reached.

    **Arguments:**

    - `onsets`: from `onset_pressures`, at least one for each contact.
    """
    most = max(len(one) for one in onsets)
    return [
        one + tuple(jnp.full_like(one[0], _NEVER_REACHED) for _ in range(most - len(one)))
        for one in onsets
    ]
