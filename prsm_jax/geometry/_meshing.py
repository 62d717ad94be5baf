"""Contact points of the threads: points of common normal between roller, screw and nut."""

from typing import Annotated

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..fields import In, Scalar
from ..mechanism import Thread, of_one_design
from ..numerics import find_root_of
from ..programs import one_program, physics
from ..results import Result
from ._curvature import RelativeCurvature, relative_curvature
from ._flanks import (
    FlankGeometry,
    Slope,
    flanks_of,
    helicoid_slope,
    nut_contact_hessian,
    screw_side_gap,
    screw_side_hessian,
)

#: Newton steps allowed; from the starting value below three are enough over the whole range.
_MAXIMUM_STEPS = 32


class ThreadContact(Result):
    """Geometry of one thread contact of a roller.

    `contact_radius` and `contact_angle_position` are those on the screw (or nut); the roller's
    are `roller_contact_radius` and `roller_angle_position`, measured from the line of centres.
    """

    contact_radius: Annotated[Scalar, In("m")]
    contact_angle_position: Annotated[Scalar, In("rad")]
    roller_contact_radius: Annotated[Scalar, In("m")]
    roller_angle_position: Annotated[Scalar, In("rad")]
    #: Parts of `normal`: plain numbers, because XLA recomputes the inputs of an array for each of
    #: its entries (six times the run time of a Hessian).
    normal_parts: tuple[Scalar, Scalar, Scalar]
    curvature: RelativeCurvature

    @property
    def normal(self) -> Float[Array, "*batch 3"]:
        """Unit normal at the contact, pointing into the roller [x, y, z]."""
        return jnp.stack(self.normal_parts, axis=-1)


class Meshing(Result):
    """Contacts of one roller with screw and nut.

    `converged` is the result code of the root search; for a design without a common normal it is
    `False`, and the numbers must not be used.
    """

    screw: ThreadContact
    nut: ThreadContact
    #: Axial gap of the screw-side flanks when all teeth are half a pitch thick [m].
    axial_gap: Annotated[Scalar, In("m")]
    converged: Annotated[Bool[Array, ""], In("1")]


class ContactTriangle(eqx.Module):
    """Screw axis, roller axis and contact point, for a given slope s of the roller's profile."""

    roller_radius: Scalar
    screw_radius: Scalar
    #: 1/|∇z|² of the roller's flank.
    flatness: Scalar


def starting_slope(flanks: FlankGeometry) -> Scalar:
    """Slope of the roller's profile at the contact, to second order in the helix angles.

    Both flanks are equally steep, `s² + tan²λ_R = tan²α + tan²λ_s`, at the nominal radii.
    """
    screw_helix = flanks.reduced_lead / flanks.screw_radius
    roller_helix = flanks.reduced_lead / flanks.nut_radius
    return jnp.sqrt(flanks.slope**2 + screw_helix**2 - roller_helix**2)


def _triangle(flanks: FlankGeometry, slope: Scalar) -> tuple[ContactTriangle, Scalar, Scalar]:
    """The triangle of the axes and the contact; the residual in s, and its derivative.

    The arc has the slope s at the roller radius `r = r_R + ρ (s/√(1 + s²) − sin α)`. Where both
    gradients are equal, the angle T between the radii of screw and roller has
    `cos T = (s tan α − h h_R/(r r_s'))/|∇z|²` with the reduced leads h and h_R, so that the law of
    cosines is a quadratic equation for the screw radius r_s'. The remaining condition is that both
    flanks are equally steep, `s² + (h_R/r)² = tan²α + (h/r_s')²`.
    """
    distance, steep = flanks.centre_distance, flanks.slope
    cosine = 1 / jnp.sqrt(1 + slope**2)
    roller = flanks.arc_centre + flanks.profile_radius * slope * cosine
    roller_moves = flanks.profile_radius * cosine**3
    roller_helix = flanks.roller_reduced_lead / roller
    flatness = 1 / (slope**2 + roller_helix**2)
    # d(|∇z|²)/ds / 2
    steepens = slope - roller_helix**2 / roller * roller_moves

    # r_s'² + 2 r_s' half + r² − a² − twist = 0
    half = roller * steep * slope * flatness
    twist = 2 * flanks.reduced_lead * flanks.roller_reduced_lead * flatness
    # Beyond the screw axis there is no triangle; the floor keeps a search there finite.
    square = half**2 + (distance - roller) * (distance + roller) + twist
    root = jnp.sqrt(jnp.maximum(square, 1e-4 * distance**2))
    screw = root - half
    relative = -2 * steepens * flatness
    half_moves = half * relative + steep * flatness * (roller + slope * roller_moves)
    screw_moves = (twist * relative / 2 - screw * half_moves - roller * roller_moves) / root

    screw_helix = flanks.reduced_lead / screw
    residual = slope**2 - steep**2 + (roller_helix - screw_helix) * (roller_helix + screw_helix)
    derivative = 2 * (steepens + screw_helix**2 / screw * screw_moves)
    return ContactTriangle(roller, screw, flatness), residual, derivative


def _steepness(flanks: FlankGeometry, slope: Scalar) -> tuple[Scalar, Scalar]:
    """Squared steepness of the roller minus that of the screw, and its derivative in s."""
    _, residual, derivative = _triangle(flanks, slope)
    return residual, derivative


def contact_point(flanks: FlankGeometry, slope: Scalar) -> tuple[ContactTriangle, Scalar, Scalar]:
    """Where the roller's profile has the slope s and both gradients the same direction.

    **Arguments:**

    - `flanks`: of the stage.
    - `slope`: slope s of the roller's profile; at the root of `_steepness` it is a contact point.

    **Returns:** the radii there, and (x, y) about the screw axis, roller axis at (a, 0) [m].
    """
    triangle, _, _ = _triangle(flanks, slope)
    distance = flanks.centre_distance
    roller, screw = triangle.roller_radius, triangle.screw_radius
    # sin T = (tan α tan λ_R + s tan λ_s)/|∇z|², and r_s' r sin T = a |y|.
    aside = flanks.slope * flanks.roller_reduced_lead * screw + slope * flanks.reduced_lead * roller
    along = distance + (screw - roller) * (screw + roller) / distance
    return triangle, along / 2, -aside * triangle.flatness / distance


def _unit_normal(slope: Slope, sign: float) -> tuple[Scalar, Scalar, Scalar]:
    """Unit vector along ±(∂z/∂x, ∂z/∂y, −1)."""
    x, y = slope
    scale = sign / jnp.sqrt(1 + x**2 + y**2)
    return x * scale, y * scale, -scale


@of_one_design
@one_program
@physics("meshing")
def mesh(thread: Thread) -> Meshing:
    """Contact points, normals and relative curvatures of one roller with screw and nut.

    On the screw side the flanks touch where their gradients over the transverse plane are equal:
    same direction and same steepness. The direction is solved in closed form, which leaves one
    equation, for the slope of the roller's profile, regular down to zero lead. Derivatives go
    through its root by the implicit function theorem. On the nut side, roller and nut have the same
    helix angle, so the contact lies on the line of centres at the nominal radii, exactly.
    Equations: common normal of two helicoids, as in Fu et al. 2017 and Jones and Velinsky 2013,
    with one unknown.

    **Arguments:**

    - `thread`: the thread geometry.

    **Returns:** a `Meshing`; `converged` is false where the flanks do not touch in a point (the
    roller's profile is too flat for so steep a helix); the numbers are then finite but must not be
    used.
    """
    flanks = flanks_of(thread)
    distance = flanks.centre_distance
    start = starting_slope(flanks)
    profile_slope, converged = find_root_of(
        _steepness,
        flanks,
        start,
        tolerance=1e-12 if distance.dtype == jnp.float64 else 1e-5,
        max_steps=_MAXIMUM_STEPS,
    )
    triangle, x, y = contact_point(flanks, jnp.where(converged, profile_slope, start))
    slope = helicoid_slope(flanks.slope, flanks.reduced_lead, x, y)
    screw = ThreadContact(
        contact_radius=triangle.screw_radius,
        contact_angle_position=jnp.arctan2(y, x),
        roller_contact_radius=triangle.roller_radius,
        roller_angle_position=jnp.arctan2(y, distance - x),
        normal_parts=_unit_normal(slope, 1.0),
        curvature=relative_curvature(slope, screw_side_hessian(flanks, x, y)),
    )

    nut_slope = flanks.slope, flanks.reduced_lead / flanks.nut_radius
    on_line = jnp.zeros_like(distance)
    nut = ThreadContact(
        contact_radius=flanks.nut_radius,
        contact_angle_position=on_line,
        roller_contact_radius=thread.roller_radius,
        roller_angle_position=on_line,
        normal_parts=_unit_normal(nut_slope, -1.0),
        curvature=relative_curvature(nut_slope, nut_contact_hessian(flanks)),
    )
    # A root beyond the screw axis has no triangle, and where the gap has a saddle point, the flanks
    # intersect.
    bend = screw.curvature
    touches = (screw.roller_contact_radius < distance) & (bend.total**2 > bend.difference_squared)
    possible = (flanks.slope > 0) & (bend.total > 0)
    return Meshing(screw, nut, screw_side_gap(flanks, x, y), converged & touches & possible)
