"""Contact points of the threads: points of common normal between roller, screw and nut."""

from typing import Annotated, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..fields import In, Scalar
from ..mechanism import Side, Thread, of_one_design
from ..numerics import find_root_of, inverse, inverse_root
from ..programs import one_program, physics
from ..results import Result
from ._curvature import FlankPoint, RelativeCurvature, along_gradient, relative_curvature
from ._flanks import FlankGeometry, SymmetricTensor, flanks_of

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
    #: Axial gap between the flanks of both sides when all teeth are half a pitch thick; there is
    #: one only where rollers slide: on the screw's side of a standard roller screw [m].
    axial_gap: Annotated[Scalar, In("m")]
    converged: Annotated[Bool[Array, ""], In("1")]


class ContactTriangle(eqx.Module):
    """Screw axis, roller axis and contact point, for a given slope s of the roller's profile."""

    roller_radius: Scalar
    screw_radius: Scalar
    #: 1/r of both [1/m].
    inverse_roller_radius: Scalar
    inverse_screw_radius: Scalar
    #: Slopes along both helices, (lead/2π)/r.
    roller_helix: Scalar
    screw_helix: Scalar
    #: 1/√(1 + s²).
    cosine: Scalar
    #: |∇z|² of the roller's flank.
    square: Scalar
    #: 1/|∇z|².
    flatness: Scalar


def starting_slope(flanks: FlankGeometry) -> Scalar:
    """Slope of the roller's profile at the contact, to second order in the helix angles.

    Both flanks are equally steep, `s² + tan²λ_R = tan²α + tan²λ_s`, at the nominal radii.
    """
    screw_helix = flanks.reduced_lead / flanks.screw_radius
    if flanks.carrying is None:
        # Rollers with grooves.
        return jnp.sqrt(flanks.slope**2 + screw_helix**2)
    # The roller has the helix angle of the other body, which carries it.
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
    cosine = inverse_root(1 + slope**2)
    roller = flanks.arc_centre + flanks.profile_radius * slope * cosine
    inverse_roller = inverse(roller)
    roller_helix = flanks.roller_reduced_lead * inverse_roller
    square = slope**2 + roller_helix**2
    flatness = inverse(square)

    # r_s'² + 2 r_s' half + r² − a² − twist = 0
    half = roller * steep * slope * flatness
    twist = 2 * flanks.reduced_lead * flanks.roller_reduced_lead * flatness
    # Beyond the screw axis there is no triangle; the floor keeps a search there finite.
    under_root = half**2 + (distance - roller) * (distance + roller) + twist
    root = jnp.sqrt(jnp.maximum(under_root, 1e-4 * distance**2))
    screw = root - half
    inverse_screw = inverse(screw)
    screw_helix = flanks.reduced_lead * inverse_screw
    residual = slope**2 - steep**2 + (roller_helix - screw_helix) * (roller_helix + screw_helix)

    roller_moves = flanks.profile_radius * cosine**3
    # d(|∇z|²)/ds / 2
    steepens = slope - roller_helix**2 * inverse_roller * roller_moves
    relative = -2 * steepens * flatness
    half_moves = half * relative + steep * flatness * (roller + slope * roller_moves)
    screw_moves = (twist * relative / 2 - screw * half_moves - roller * roller_moves) / root
    derivative = 2 * (steepens + screw_helix**2 * inverse_screw * screw_moves)
    triangle = ContactTriangle(
        roller_radius=roller,
        screw_radius=screw,
        inverse_roller_radius=inverse_roller,
        inverse_screw_radius=inverse_screw,
        roller_helix=roller_helix,
        screw_helix=screw_helix,
        cosine=cosine,
        square=square,
        flatness=flatness,
    )
    return triangle, residual, derivative


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


class _Touch(NamedTuple):
    """A thread contact, whether the search for it converged, and the gap of half teeth."""

    contact: ThreadContact
    #: `None` for a contact on the line of centres.
    converged: Bool[Array, ""] | None
    gap: Scalar | None


def _roller_bend(flanks: FlankGeometry, cosine: Scalar) -> Scalar:
    """(1 + s²)^(3/2)/ρ, the bend of the roller's profile from its 1/√(1 + s²) [1/m]."""
    return inverse(flanks.profile_radius * cosine**3)


def _contact(
    side: Side,
    radii: tuple[Scalar, Scalar],
    turns: tuple[Scalar, Scalar],
    gradient: tuple[Scalar, Scalar],
    squares: tuple[Scalar, Scalar],
    bend: SymmetricTensor,
) -> ThreadContact:
    """A contact of flanks (the mirrored ones for a nut) by what is known of it.

    **Arguments:**

    - `side`: whose.
    - `radii`, `turns`: distances from the axes of the body and of the roller [m], and angle
      positions on both [rad].
    - `gradient`, `squares`: (∂z/∂x, ∂z/∂y) of both flanks, and |∇z|² and 1/|∇z|².
    - `bend`: |∇z|² ∇∇z of the screw minus that of the roller, along the gradient and across it.
    """
    # The loaded flank of a screw faces −z, that of a nut +z.
    sign = 1.0 if side == "screw" else -1.0
    if side == "nut":
        bend = SymmetricTensor(-bend.xx, -bend.xy, -bend.yy)
    curvature, cosine = relative_curvature(bend, *squares)
    scale = sign * cosine
    return ThreadContact(
        contact_radius=radii[0],
        contact_angle_position=turns[0],
        roller_contact_radius=sign * radii[1],
        roller_angle_position=turns[1],
        normal_parts=(gradient[0] * scale, gradient[1] * scale, -scale),
        curvature=curvature,
    )


def _where_it_slides(thread_flanks: FlankGeometry, side: Side) -> _Touch:
    """The contact with a body on which the roller slides: aside of the line of centres."""
    on_screw = side == "screw"
    flanks = thread_flanks if on_screw else thread_flanks.mirrored_nut
    distance, steep = flanks.centre_distance, flanks.slope
    start = jax.lax.stop_gradient(starting_slope(flanks))
    root, converged = find_root_of(
        _steepness,
        flanks,
        start,
        tolerance=1e-12 if distance.dtype == jnp.float64 else 1e-5,
        max_steps=_MAXIMUM_STEPS,
    )
    slope = jnp.where(converged, root, start)
    triangle, x, y = contact_point(flanks, slope)
    # ∇z = tan α e + (lead/2π)/r t of the body, with e = (x, y)/r.
    along, turning = x * triangle.inverse_screw_radius, y * triangle.inverse_screw_radius
    helix = triangle.screw_helix
    gradient = steep * along - helix * turning, steep * turning + helix * along
    turn = jnp.arctan2(y, x)
    roller_turn = jnp.arctan2(y, distance - x if on_screw else x - distance)
    square = triangle.square
    on_body = FlankPoint(steep, helix, triangle.inverse_screw_radius, None)
    on_roller = FlankPoint(
        slope=-slope,
        helix=triangle.roller_helix,
        inverse_radius=triangle.inverse_roller_radius,
        bend=-_roller_bend(flanks, triangle.cosine),
    )
    bends = zip(along_gradient(on_body, square), along_gradient(on_roller, square), strict=True)
    contact = _contact(
        side,
        radii=(triangle.screw_radius, triangle.roller_radius),
        turns=(turn, roller_turn),
        gradient=gradient,
        squares=(square, triangle.flatness),
        bend=SymmetricTensor(*(body - roller for body, roller in bends)),
    )

    # Heights at the contact above those at the nominal points.
    body = steep * (triangle.screw_radius - flanks.screw_radius) + flanks.reduced_lead * turn
    profile = flanks.profile_radius * (triangle.cosine - inverse_root(1 + steep**2))
    helical = flanks.roller_reduced_lead * roller_turn
    # The screw's flank is above the roller's, the roller's above that of the nut.
    gap = body - profile + helical if on_screw else profile + helical - body
    return _Touch(contact, converged, gap)


def _where_it_rolls(thread_flanks: FlankGeometry, side: Side, roller_radius: Scalar) -> _Touch:
    """The contact with a body of the roller's helix angle: at the nominal radii, exactly."""
    on_screw = side == "screw"
    flanks = thread_flanks if on_screw else thread_flanks.mirrored_nut
    steep, radius = flanks.slope, flanks.screw_radius
    roller = roller_radius if on_screw else -roller_radius
    inverse_radius = inverse(radius)
    helix = flanks.reduced_lead * inverse_radius
    square, cosine = steep**2 + helix**2, inverse_root(1 + steep**2)
    # Both flanks have the slopes tan α and tan λ, so the difference of their bends is that of one
    # flank with the sum of the curvatures.
    both = FlankPoint(steep, helix, inverse_radius + inverse(roller), _roller_bend(flanks, cosine))
    on_line = jnp.zeros_like(radius)
    contact = _contact(
        side,
        radii=(radius, roller),
        turns=(on_line, on_line),
        gradient=(steep, helix),
        squares=(square, inverse(square)),
        bend=along_gradient(both, square),
    )
    return _Touch(contact, None, None)


@of_one_design
@one_program
@physics("meshing")
def mesh(thread: Thread) -> Meshing:
    """Contact points, normals and relative curvatures of one roller with screw and nut.

    Where rollers slide (on the screw of a standard roller screw), the flanks touch where their
    gradients over the transverse plane are equal: same direction and same steepness. The direction
    is solved in closed form, which leaves one equation, for the slope of the roller's profile,
    regular down to zero lead. Derivatives go through its root by the implicit function theorem.
    Where they roll (in the nut of a standard roller screw), both bodies have the same helix angle,
    so the contact lies on the line of centres at the nominal radii, exactly.
    Equations: common normal of two helicoids, as in Fu et al. 2017 and Jones and Velinsky 2013,
    with one unknown; those of a nut are those of a screw with the roller at negative radii.

    **Arguments:**

    - `thread`: the thread geometry.

    **Returns:** a `Meshing`; `converged` is false where the flanks do not touch in a point (the
    roller's profile is too flat for so steep a helix); the numbers are then finite but must not be
    used.
    """
    flanks, family = flanks_of(thread), thread.family
    sides: tuple[Side, ...] = ("screw", "nut")
    screw, nut = (
        _where_it_slides(flanks, side)
        if side in family.sliding
        else _where_it_rolls(flanks, side, thread.roller_radius)
        for side in sides
    )
    meshed: Bool[Array, ""] | None = None
    gap: Scalar | None = None
    for touch in (screw, nut):
        if touch.converged is None or touch.gap is None:
            continue
        # A root beyond the screw axis has no triangle, and where the gap has a saddle point, the
        # flanks intersect.
        bend = touch.contact.curvature
        touches = touch.contact.roller_contact_radius < flanks.centre_distance
        touches = touches & (bend.total**2 > bend.difference_squared)
        possible = (flanks.slope > 0) & (bend.total > 0)
        own = touch.converged & touches & possible
        meshed = own if meshed is None else meshed & own
        gap = touch.gap if gap is None else gap + touch.gap
    assert meshed is not None
    assert gap is not None
    return Meshing(screw.contact, nut.contact, gap, meshed)
