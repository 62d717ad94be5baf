"""Gap between the flanks of a screw and a ring: a helicoid against a cone.

The screw axis is the origin, the roller axis lies at (d, 0). A point is given by its distance r
from the roller axis and the arc y = r φ from the line of centres. The ring has no lead: its flank
is a cone with the profile angle k, and its height depends on r alone. The screw's flank is straight
in the axial section, with the profile angle j, and its lead follows from the lead angle ψ at the
mean radius of the flank.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from ..fields import Scalar
from ..mechanism import LineContact
from ..numerics import find_root
from ..programs import physics


class RingVertex(eqx.Module):
    """Smallest gap in a slice of ring and screw, and its growth from there."""

    #: Arc coordinate of the smallest gap, from the line of centres [m].
    arc: Scalar
    #: Axial gap there; only differences between slices are meaningful [m].
    gap: Scalar
    #: Quadratic coefficient of the axial gap along the arc, half its second derivative [1/m].
    coefficient: Scalar
    #: Axial component of the unit normal of the screw's flank there.
    normal: Scalar
    converged: Bool[Array, ""]


class ParabolaFit(eqx.Module):
    """A parabola fitted to the gap along the arc by least squares."""

    #: Quadratic coefficient of the axial gap [1/m].
    coefficient: Scalar
    #: Coefficient of determination R².
    determination: Scalar


def lead_per_radian(contact: LineContact) -> Scalar:
    """Lead of the screw over 2π, from ψ at the mean radius of its flank [m]."""
    mean = (contact.screw_minor_radius + contact.screw_major_radius) / 2
    if contact.lead_angle is None:
        return jnp.zeros_like(mean)
    return mean * jnp.tan(contact.lead_angle)


def ring_gap(contact: LineContact, radius: Scalar, arc: Scalar) -> Scalar:
    """Axial gap of the exact flanks, up to a constant; it opens away from its vertex [m].

    `Δz = tan j ρ + (L/2π) θ + tan k r` with `ρ² = d² + r² − 2 d r cos φ`, `φ = y/r`, and θ the
    angle of the point about the screw axis.

    **Arguments:**

    - `contact`: the flanks.
    - `radius`: distance from the roller axis, r [m].
    - `arc`: arc from the line of centres, y [m].
    """
    turn, distance = arc / radius, contact.centre_distance
    x, y = distance - radius * jnp.cos(turn), radius * jnp.sin(turn)
    # Not by `hypot`: XLA's CPU compiler gives a wrong second derivative in some slices of a batch
    # when its optimisation is off, as in the tests.
    return (
        jnp.tan(contact.screw_profile_angle) * jnp.sqrt(x**2 + y**2)
        + lead_per_radian(contact) * jnp.arctan2(y, x)
        + jnp.tan(contact.roller_profile_angle) * radius
    )


@physics("ring_vertex")
def ring_vertex(contact: LineContact, radius: Scalar) -> RingVertex:
    """Smallest gap of the slice at one distance from the roller axis.

    The root of the gap's slope, differentiable by the implicit function theorem.

    **Arguments:**

    - `contact`: the flanks.
    - `radius`: distance from the roller axis, r [m].
    """
    distance, slope = contact.centre_distance, jnp.tan(contact.screw_profile_angle)
    lead = lead_per_radian(contact)

    def residual(turn: Scalar) -> Scalar:
        # The slope of the gap times ρ²/(r d²), which has no singularity.
        rho = jnp.sqrt(distance**2 + radius**2 - 2 * distance * radius * jnp.cos(turn))
        pulled = slope * jnp.sin(turn) * rho / distance
        return pulled + lead * (distance * jnp.cos(turn) - radius) / distance**2

    tolerance = 1e-12 if distance.dtype == jnp.float64 else 1e-5
    start = -lead / (distance * slope)
    turn, converged = find_root(residual, start, tolerance=tolerance, max_steps=16)
    arc = radius * turn

    def along(y: Scalar) -> Scalar:
        return ring_gap(contact, radius, y)

    rho = jnp.sqrt(distance**2 + radius**2 - 2 * distance * radius * jnp.cos(turn))
    return RingVertex(
        arc=arc,
        gap=along(arc),
        coefficient=jax.grad(jax.grad(along))(arc) / 2,
        normal=1 / jnp.sqrt(1 + slope**2 + (lead / rho) ** 2),
        converged=converged,
    )


def fit_parabola(
    contact: LineContact, radius: Scalar, vertex: RingVertex, half_width: Scalar, points: int = 33
) -> ParabolaFit:
    """Fit a parabola to the exact gap of one slice over the width of its contact.

    **Arguments:**

    - `contact`, `radius`: flanks and slice.
    - `vertex`: its smallest gap.
    - `half_width`: half the range of the fit [m].
    - `points`: evenly spaced points.
    """
    along = jnp.linspace(-1.0, 1.0, points, dtype=radius.dtype)
    gap = jax.vmap(lambda share: ring_gap(contact, radius, vertex.arc + share * half_width))(along)
    # Subtract the height first: the gap is nanometres, the height centimetres.
    gap = gap - vertex.gap
    # Orthogonal on this grid: 1, u, and u² minus its mean.
    quadratic = along**2 - jnp.mean(along**2)
    linear = jnp.sum(along * gap) / jnp.sum(along**2)
    bend = jnp.sum(quadratic * gap) / jnp.sum(quadratic**2)
    rest = gap - jnp.mean(gap) - linear * along - bend * quadratic
    scatter = jnp.sum((gap - jnp.mean(gap)) ** 2)
    return ParabolaFit(bend / half_width**2, 1 - jnp.sum(rest**2) / scatter)


def contact_zone(contact: LineContact) -> tuple[Scalar, Scalar]:
    """Distances from the roller axis between which both flanks exist [m]."""
    distance = contact.centre_distance
    inner = jnp.maximum(contact.roller_minor_radius, distance - contact.screw_major_radius)
    return inner, jnp.minimum(contact.roller_major_radius, distance - contact.screw_minor_radius)


def matched_profile_angle(contact: LineContact) -> Scalar:
    """Profile angle k of a ring whose flank is parallel to the screw's, at the zone's middle [rad].

    A screw with a lead touches a ring away from the line of centres, where its flank is steeper
    along the ring's generator: `tan²k = tan²j + (L/2πρ)²`. With k = j a ring makes contact at its
    crest.

    **Arguments:**

    - `contact`: the flanks; their own k is not used.
    """
    inner, outer = contact_zone(contact)
    radius = (inner + outer) / 2
    vertex = ring_vertex(contact, radius)
    turn = jax.lax.stop_gradient(vertex.arc / radius)

    def screw_height(r: Scalar) -> Scalar:
        flat = eqx.tree_at(
            lambda c: c.roller_profile_angle, contact, jnp.zeros_like(contact.centre_distance)
        )
        return ring_gap(flat, r, turn * r)

    return jnp.arctan(-jax.grad(screw_height)(radius))
