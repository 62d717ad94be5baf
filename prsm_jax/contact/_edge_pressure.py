r"""Pressure peak at a rounded edge that cuts a contact ellipse.

At a sharp edge the pressure of elastic half-spaces is unbounded: it varies as $K/\sqrt{y}$ with the
distance y from the edge. If the edge is rounded by ρ, the contact extends beyond it by l:

$$K\,(1 - l/g) = \frac{2 E^*}{3\pi\rho}\,l^{3/2},\qquad
p_\text{edge} = x \frac{E^*}{\pi\rho}\,l + \frac{2K}{g}\frac{\sqrt{l}}{x},\qquad x\tanh x = 1,$$

with g the part of the half-extent beyond the edge. This is the solution of a half-plane with the
slope of a parabola beyond the edge: at $y = l v^2$ from the end of the contact its pressure is
$E^* l/(\pi\rho)\,[v + \tfrac12(1-v^2)\ln\lvert(1+v)/(1-v)\rvert]$, largest at $v = 1/x$, in
addition to the pressure of the contact without an edge, $2K/g\,\sqrt{y}$. For a shallow cut K →
$p_0 g/\sqrt{2s}$, with s the half-extent. For deeper cuts, which are no longer long and narrow, K
has a factor that is fitted to elastic half-spaces; it is the only fit here. All pressures are
proportional to $p_0$, so load-independent numbers describe an edge: the Hertz pressure at which the
ellipse reaches it, the steepness $E^* s/p_0\rho$ and the shape of the ellipse.
"""

import functools
import math

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..fields import Scalar
from ..geometry import FlankEnd, RelativeCurvature, Way
from ..numerics import root_above_one
from ..programs import physics
from ._truncation import Onsets, half_extents, pressure_ratio
from .hertz import HertzContact

Real = Float[Array, "*batch"]

#: x of x tanh x = 1.
_PEAK = 1.1996786402577338
#: Fitted to 141 half-space contacts: steepness 20 to 500, cuts of 0.15 to 0.7 at one and both ends,
#: half-axes along the edge 0.6 to 1.6 times those across it. In this range the pressure is within
#: 3.5 %.
_DEPTH, _BLUNT, _OPPOSITE = 0.284, 3.02, 0.218


class RoundedEdge(eqx.Module):
    """One crest that a contact ellipse can extend beyond."""

    #: Hertz pressure at which the ellipse reaches the edge [Pa].
    onset: Scalar
    #: E* s/(p₀ ρ), the same for every load.
    steepness: Scalar
    #: Half-axis along the edge over that across it, a b/s².
    aspect: Scalar
    way: Way = eqx.field(static=True)


@physics("edge_pressure")
def rounded_edges(
    hertz: HertzContact,
    curvature: RelativeCurvature,
    ends: tuple[FlankEnd, ...],
    modulus: Scalar,
    edge_radius: Scalar,
) -> tuple[RoundedEdge, ...]:
    """The crests among the ends of the flanks of one side.

    A root is not an edge: the flank ends there in a fillet, which is not modelled.

    **Arguments:**

    - `hertz`: the contact under any load above 0.
    - `curvature`: curvatures of its gap.
    - `ends`: the ends of its flanks.
    - `modulus`: contact modulus E* [Pa].
    - `edge_radius`: ρ [m].
    """
    crests = [end for end in ends if end.kind == "crest"]
    return tuple(
        RoundedEdge(
            end.distance * hertz.max_pressure / extent,
            modulus * extent / (hertz.max_pressure * edge_radius),
            hertz.semi_major * hertz.semi_minor / extent**2,
            end.way,
        )
        for end, extent in zip(crests, half_extents(hertz, curvature, crests), strict=True)
    )


def _beyond(pressure: Real, onset: Scalar) -> tuple[Bool[Array, "*batch"], Real]:
    """Whether an edge is passed, and the share g/s of the half-extent beyond it, at most 1."""
    passed = (pressure > onset) & (pressure > 0)
    share = 1 - onset / jnp.where(passed, pressure, 1.0)
    return passed, jnp.where(passed, jnp.minimum(share, 1.0), 0.0)


def edge_ratio(pressure: Real, edge: RoundedEdge, opposite: Scalar | None = None) -> Real:
    """Pressure at a rounded edge over the Hertz pressure of the same load; 0 if it is not reached.

    **Arguments:**

    - `pressure`: Hertz pressure of the load [Pa].
    - `edge`: the edge.
    - `opposite`: Hertz pressure at which the ellipse reaches an end in the opposite direction [Pa].
    """
    passed, share = _beyond(pressure, edge.onset)
    root_share = jnp.sqrt(jnp.where(passed, share, 0.5))
    blunt = 1 + _BLUNT / (edge.steepness * root_share)
    intensity = 1 - _DEPTH * root_share / (jnp.sqrt(edge.aspect) * blunt)
    if opposite is not None:
        # A cut at the opposite end raises the pressure at this one.
        intensity = intensity * (1 + _OPPOSITE * _beyond(pressure, opposite)[1] ** 2)
    # With l = g/z² the first equation is z³ − z = κ.
    stiff = 2 * math.sqrt(2) / (3 * math.pi) * edge.steepness / intensity
    length = (root_share / root_above_one(stiff * root_share)) ** 2
    without_edge = math.sqrt(2) * intensity * jnp.sqrt(length) / _PEAK
    return jnp.where(passed, without_edge + _PEAK / math.pi * edge.steepness * length, 0.0)


def opposite_onset(edge: RoundedEdge, edges: tuple[RoundedEdge, ...]) -> Scalar | None:
    """Hertz pressure at which the ellipse reaches the nearest opposite edge [Pa]."""
    others = [other.onset for other in edges if other.way != edge.way]
    return functools.reduce(jnp.minimum, others) if others else None


def largest_pressure(pressure: Real, onsets: Onsets, edges: tuple[RoundedEdge, ...]) -> Real:
    """Largest pressure in a contact whose ellipse extends beyond rounded crests [Pa].

    The maximum of the pressure at the contact point (`pressure_ratio`) and the pressures at the
    edges; its derivative is discontinuous where the location of the maximum changes.

    **Arguments:**

    - `pressure`: Hertz pressure of the load [Pa].
    - `onsets`: onsets of all ends, from `onset_pressures`.
    - `edges`: from `rounded_edges`.
    """
    ratio = pressure_ratio(pressure, onsets)
    for edge in edges:
        ratio = jnp.maximum(ratio, edge_ratio(pressure, edge, opposite_onset(edge, edges)))
    return pressure * ratio
