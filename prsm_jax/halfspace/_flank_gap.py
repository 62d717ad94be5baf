"""Gap of two real flanks along their common normal, over the tangent plane at the contact."""

from collections.abc import Callable
from typing import Literal, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..fields import Scalar
from ..geometry import (
    Meshing,
    flanks_of,
    nut_side_heights,
    nut_side_hessian,
    past_roller_arc,
    screw_side_heights,
    screw_side_hessian,
    tangent_tensor,
)
from ..mechanism import Thread
from ..programs import physics
from ._grid import Grid

Side: TypeAlias = Literal["screw", "nut"]
_SURFACES = {
    "screw": (screw_side_heights, screw_side_hessian),
    "nut": (nut_side_heights, nut_side_hessian),
}
#: Newton steps along the normal. Slopes differ by less than a tenth over a contact, so the error is
#: some hundredths of a micrometre after the first and rounding after the third.
_STEPS = 3
#: Largest distance from a flank of a point on it, over the distance from the contact point.
_LARGEST_MISS = 1e-4
#: The same at the contact point, over the rounding of its coordinates.
_ROUNDING = 16.0


class TangentPlane(eqx.Module):
    """The tangent plane at a thread contact, with axes along the principal directions of the gap.

    Coordinates [x, y, z] about the axis of screw and nut, roller axis at (a, 0).
    """

    #: The contact point; z is on the flank, independent of the axial play [m].
    origin: Float[Array, "3"]
    #: Direction of the least relative curvature, in which the contact is longest.
    major: Float[Array, "3"]
    #: Direction of the largest relative curvature.
    minor: Float[Array, "3"]
    #: Common normal, towards positive z.
    normal: Float[Array, "3"]
    #: Second derivatives of the gap: along the major direction, along the minor one, mixed [1/m].
    curvatures: Float[Array, "3"]


class FlankGap(eqx.Module):
    """Gap of two flanks on a grid in their tangent plane."""

    #: Distance along the common normal, 0 at the contact point [m].
    gap: Float[Array, "nx ny"]
    #: Where both flanks exist: within the crests of both threads and on the roller's profile arc.
    material: Bool[Array, "nx ny"]
    #: Distance from the crest of screw or nut, positive on the flank; None without addendum [m].
    body_edge: Float[Array, "nx ny"] | None
    #: Distance from the roller's crest, positive on the flank; None without addendum [m].
    roller_edge: Float[Array, "nx ny"] | None


def checked_side(side: str) -> Side:
    """A side of the roller by name.

    **Raises:** `ValueError` for anything except `"screw"` and `"nut"`.
    """
    if side not in _SURFACES:
        raise ValueError(f"the side is {side!r}; choose 'screw' or 'nut'")
    return side  # type: ignore[return-value]


def tangent_plane(thread: Thread, meshing: Meshing, side: Side) -> TangentPlane:
    """Tangent plane and principal directions at the contact of one side.

    The directions are constant in derivatives: rotating the grid does not change a result, and at a
    circular contact they are arbitrary.

    **Arguments:**

    - `thread`, `meshing`: the thread geometry and its meshing.
    - `side`: `"screw"` or `"nut"`.
    """
    heights, hessian = _SURFACES[side]
    flanks = flanks_of(thread)
    contact = getattr(meshing, side)
    x = contact.contact_radius * jnp.cos(contact.contact_angle_position)
    y = contact.contact_radius * jnp.sin(contact.contact_angle_position)
    slope_x, slope_y = (
        -contact.normal[0] / contact.normal[2],
        -contact.normal[1] / contact.normal[2],
    )
    tensor, whitening = tangent_tensor((slope_x, slope_y), hessian(flanks, x, y))
    constant = jax.lax.stop_gradient(tensor)
    # Half the angle of the deviator; 0 at a circle, as arctan2 returns.
    steep = jnp.arctan2(2 * constant.xy, constant.xx - constant.yy) / 2

    def direction(angle):
        cosine, sine = jnp.cos(angle), jnp.sin(angle)
        flat_x = whitening.xx * cosine + whitening.xy * sine
        flat_y = whitening.xy * cosine + whitening.yy * sine
        return jnp.stack([flat_x, flat_y, slope_x * flat_x + slope_y * flat_y])

    cosine, sine = jnp.cos(steep), jnp.sin(steep)
    mean, half = (tensor.xx + tensor.yy) / 2, (tensor.xx - tensor.yy) / 2
    # cos and sin of twice the angle. The major direction is a quarter of a turn behind the minor.
    double_cosine, double_sine = cosine**2 - sine**2, 2 * cosine * sine
    half_difference = half * double_cosine + tensor.xy * double_sine
    mixed = half * double_sine - tensor.xy * double_cosine
    upper, lower = heights(flanks, x, y)
    upwards = jnp.stack([-slope_x, -slope_y, jnp.ones_like(slope_x)])
    return TangentPlane(
        origin=jnp.stack([x, y, (upper + lower) / 2]),
        major=direction(steep - jnp.pi / 2),
        minor=direction(steep),
        normal=upwards / jnp.sqrt(1 + slope_x**2 + slope_y**2),
        curvatures=jnp.stack([mean - half_difference, mean + half_difference, mixed]),
    )


def _height_along_normal(
    surface: Callable[[Scalar, Scalar], Scalar], plane: TangentPlane, foot: Float[Array, "3"]
) -> Scalar:
    """Distance along the normal from a point of the tangent plane to a surface z(x, y) [m]."""
    shift = surface(plane.origin[0], plane.origin[1]) - plane.origin[2]

    def above(distance):
        point = foot + distance * plane.normal
        return surface(point[0], point[1]) - shift - point[2]

    def search(residual, distance):
        for _ in range(_STEPS):
            value, slope = jax.jvp(residual, (distance,), (jnp.ones_like(distance),))
            distance = distance - value / slope
        return distance

    # Derivatives are those of the root: differentiating the steps makes the program four times as
    # large.
    height = jax.lax.custom_root(
        above,
        jnp.zeros_like(foot[0]),
        search,
        lambda linear, right: right / linear(jnp.ones_like(right)),
    )
    # Beyond the end of the roller's arc, or where it bends too much for so few steps, the gap is
    # NaN.
    offset = jnp.max(jnp.abs(jax.lax.stop_gradient(foot - plane.origin)))
    # At the contact point itself only rounding of the coordinates remains.
    rounding = _ROUNDING * jnp.finfo(foot.dtype).eps * jnp.max(jnp.abs(plane.origin))
    allowed = _LARGEST_MISS * offset + jax.lax.stop_gradient(rounding)
    missed = jnp.abs(above(jax.lax.stop_gradient(height))) > allowed
    return jnp.where(missed, jnp.nan, height)


def _paraboloid(
    plane: TangentPlane, x: Float[Array, "nx ny"], y: Float[Array, "nx ny"]
) -> Float[Array, "nx ny"]:
    """Gap to second order [m]."""
    major, minor, mixed = plane.curvatures
    return (major * x**2 + minor * y**2) / 2 + mixed * x * y


def _is_minute(plane: TangentPlane, grid: Grid) -> Bool[Array, ""]:
    """Whether the paraboloid is more accurate than the difference of two rounded heights.

    Relative to the gap κL²/2, the error of the paraboloid is about κL, and that of the difference
    of heights about ε|r|/κL².
    """
    half = jnp.maximum(grid.shape[0] * grid.spacing_x, grid.shape[1] * grid.spacing_y) / 2
    rounding = jnp.finfo(half.dtype).eps * jnp.max(jnp.abs(plane.origin))
    curvature = jnp.max(jnp.abs(plane.curvatures))
    return half < jnp.cbrt(rounding / curvature**2)


def _crests(thread: Thread, side: Side, x: Scalar, y: Scalar) -> tuple[Scalar | None, ...]:
    """Radial distances from the crests of screw or nut and of the roller [m]."""
    body = roller = None
    if thread.screw_addendum is not None:
        radius = jnp.hypot(x, y)
        if side == "screw":
            body = thread.screw_radius + thread.screw_addendum - radius
        else:
            # The nut's thread is as high above its nominal radius, inwards, as the screw's.
            body = radius - (thread.nut_radius - thread.screw_addendum)
    if thread.roller_addendum is not None:
        roller = thread.roller_radius + thread.roller_addendum
        roller = roller - jnp.hypot(x - thread.centre_distance, y)
    return body, roller


@physics("flank_gap")
def flank_gap(thread: Thread, plane: TangentPlane, side: Side, grid: Grid) -> FlankGap:
    """Gap of the loaded flanks of one side over a grid in their tangent plane.

    Both flanks are intersected with the same normals, exactly: no parabola, no small angles. The
    bodies are shifted along their axes until they touch. On a very small grid (tens of nanometres),
    where rounding of the flanks' heights exceeds the terms beyond second order, it is the
    osculating paraboloid; both errors are then about 1e-6 of the gap.

    **Arguments:**

    - `thread`: the thread geometry; flanks end at the crests where addenda are given.
    - `plane`: of that side, from `tangent_plane`.
    - `side`: `"screw"` or `"nut"`.
    - `grid`: x along the plane's major and y along its minor direction.
    """
    heights, _ = _SURFACES[side]
    flanks = flanks_of(thread)
    # Distances on the flank over distances of radii.
    stretch = 1 / jnp.cos(thread.flank_angle)

    def at(x, y):
        foot = plane.origin + x * plane.major + y * plane.minor
        upper, lower = (
            _height_along_normal(lambda u, v, i=i: heights(flanks, u, v)[i], plane, foot)
            for i in (0, 1)
        )
        body, roller = _crests(thread, side, foot[0], foot[1])
        edges = tuple(None if edge is None else stretch * edge for edge in (body, roller))
        on_roller = foot + (lower if side == "screw" else upper) * plane.normal
        # Where there is no gap, the gap is NaN in any case.
        past = past_roller_arc(flanks, on_roller[0], on_roller[1])
        return upper - lower, ~past, *edges

    x, y = grid.points
    gap, material, body, roller = jax.vmap(jax.vmap(at))(x, y)
    gap = jnp.where(_is_minute(plane, grid) & jnp.isfinite(gap), _paraboloid(plane, x, y), gap)
    for edge in (body, roller):
        if edge is not None:
            material = material & (edge > 0)
    return FlankGap(gap, material, body, roller)
