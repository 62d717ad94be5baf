"""Where the threads touch: the points of common normal between roller, screw and nut."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .._physics import physics
from .._root import find_root
from ..mechanism import Scalar, Thread
from ._curvature import RelativeCurvature, relative_curvature
from ._flanks import nut_side_hessian, screw_side_gap, screw_side_hessian, screw_side_slopes

#: Newton steps allowed; from the starting values below four are enough over the whole range.
_MAXIMUM_STEPS = 32


class ThreadContact(eqx.Module):
    """Geometry of one thread contact of a roller.

    `contact_radius` and `contact_angle_position` are those on the screw (or nut); the roller's
    are `roller_contact_radius` and `roller_angle_position`, measured from the line of centres.
    """

    contact_radius: Scalar
    contact_angle_position: Scalar
    roller_contact_radius: Scalar
    roller_angle_position: Scalar
    #: Unit normal at the contact, pointing into the roller [x, y, z].
    normal: Float[Array, "3"]
    curvature: RelativeCurvature


class Meshing(eqx.Module):
    """Contacts of one roller with screw and nut.

    `converged` is the result code of the root search; a design without a common normal leaves it
    `False` and its numbers are not to be used.
    """

    screw: ThreadContact
    nut: ThreadContact
    #: Axial gap of the screw-side flanks when all teeth are half a pitch thick [m].
    axial_gap: Scalar
    converged: Bool[Array, ""]


def starting_angles(thread: Thread) -> tuple[Scalar, Scalar]:
    """Small-angle estimate of the contact positions on screw and roller (magnitudes) [rad].

    φ_s ≈ (tan λ_s + tan λ_R) / (tan α (1 + r_s/r_R)), φ_R = φ_s r_s/r_R; one to two per cent high.
    """
    helix_slopes = jnp.tan(thread.screw_helix_angle) + jnp.tan(thread.roller_helix_angle)
    ratio = thread.screw_radius / thread.roller_radius
    screw_angle = helix_slopes / (jnp.tan(thread.flank_angle) * (1 + ratio))
    return screw_angle, screw_angle * ratio


def _slope_difference(unknown: Float[Array, "2"], thread: Thread) -> Float[Array, "2"]:
    x, y = unknown * thread.centre_distance
    screw, roller = screw_side_slopes(thread, x, y)
    return screw - roller


def _solve(thread: Thread) -> tuple[Float[Array, "2"], Bool[Array, ""]]:
    """Common-normal point (x, y) of the screw side, by Newton with implicit derivatives."""
    centre = thread.centre_distance
    # The unknowns are in units of the centre distance, so that one tolerance fits every size.
    # A roller profile radius off the axis changes the arc's curvature but not its slope at the
    # nominal radius, so the same estimate serves as a start.
    angle, _ = starting_angles(thread)
    start = jnp.stack([thread.screw_radius * jnp.cos(angle), -thread.screw_radius * jnp.sin(angle)])
    unknown, found = find_root(
        lambda unknown: _slope_difference(unknown, thread),
        start / centre,
        tolerance=1e-12 if centre.dtype == jnp.float64 else 1e-5,
        max_steps=_MAXIMUM_STEPS,
    )
    return unknown * centre, found


def _unit_normal(slope: Float[Array, "2"], sign: float) -> Float[Array, "3"]:
    """Unit vector along ±(∂z/∂x, ∂z/∂y, −1)."""
    length = jnp.sqrt(1 + jnp.sum(slope**2))
    return sign * jnp.concatenate([slope, -jnp.ones_like(slope[:1])]) / length


@physics("meshing")
def mesh(thread: Thread) -> Meshing:
    """Contact points, normals and relative curvatures of one roller with screw and nut.

    On the screw side the flanks touch where the gradient of their axial gap over the transverse
    plane vanishes: two equations for (x, y), regular down to zero lead. Derivatives go through
    the root by the implicit function theorem. On the nut side, roller and nut have the same helix
    angle, so the contact lies on the line of centres at the nominal radii, exactly. Equations:
    common normal of two helicoids, as in Fu et al. 2017 and Jones and Velinsky 2013, in Cartesian
    form.

    **Arguments:**

    - `thread`: the thread geometry.

    **Returns:** a `Meshing`; `converged` is false where no common normal was found (for example
    a profile arc that ends before the contact).
    """
    centre = thread.centre_distance
    point, converged = _solve(thread)
    x, y = point[0], point[1]
    slope, _ = screw_side_slopes(thread, x, y)
    screw = ThreadContact(
        contact_radius=jnp.hypot(x, y),
        contact_angle_position=jnp.arctan2(y, x),
        roller_contact_radius=jnp.hypot(x - centre, y),
        roller_angle_position=jnp.arctan2(y, centre - x),
        normal=_unit_normal(slope, 1.0),
        curvature=relative_curvature(slope, screw_side_hessian(thread, x, y)),
    )

    nut_slope = jnp.stack(
        [jnp.tan(thread.flank_angle), thread.lead / (2 * jnp.pi * thread.nut_radius)]
    )
    nut_hessian = nut_side_hessian(thread, thread.nut_radius, jnp.zeros_like(centre))
    nut = ThreadContact(
        contact_radius=thread.nut_radius,
        contact_angle_position=jnp.zeros_like(centre),
        roller_contact_radius=thread.roller_radius,
        roller_angle_position=jnp.zeros_like(centre),
        normal=_unit_normal(nut_slope, -1.0),
        curvature=relative_curvature(nut_slope, nut_hessian),
    )
    # XLA's CPU compiler (jaxlib 0.10.2, pass reshape-mover) computes wrong reverse derivatives, by
    # some per cent, when it optimises the root's derivative together with what uses the contact.
    return jax.lax.optimization_barrier(
        Meshing(screw, nut, screw_side_gap(thread, x, y), converged)
    )
