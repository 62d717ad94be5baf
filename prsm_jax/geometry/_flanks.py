"""The thread flanks as helicoids z = f(r) + (lead / 2π) θ, in the transverse plane.

The screw axis is the origin, the roller axis lies at (a, 0). On the screw side the loaded screw
flank faces −z and the loaded roller flank +z; on the nut side it is the other way round. The
screw and nut flanks are straight in the axial section, with the flank angle α measured from the
transverse plane; the roller flank is a convex arc of radius ρ that passes through the nominal
radius with the slope tan α. Heights are counted from the flanks at the nominal radii.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..mechanism import Scalar, Thread


def _arc(thread: Thread, radius: Scalar) -> tuple[Scalar, Scalar]:
    """Height √(ρ² − d²) of the roller's profile arc and its offset d = r − (r_R − ρ sin α) [m].

    Beyond the end of the arc (|d| > ρ) there is no flank; there the height is that of the
    shallowest arc that still rises, whose steep but finite slope sends a root search back.
    """
    profile_radius = thread.profile_radius
    offset = radius - thread.roller_radius + profile_radius * jnp.sin(thread.flank_angle)
    # A hundredth of ρ above its end the arc is already steeper than any thread flank.
    floor = 1e-4 * profile_radius**2
    return jnp.sqrt(jnp.maximum(profile_radius**2 - offset**2, floor)), offset


def _arc_height(thread: Thread, radius: Scalar) -> Scalar:
    return _arc(thread, radius)[0]


def _arc_top(thread: Thread) -> Scalar:
    return thread.profile_radius * jnp.cos(thread.flank_angle)


def _polar(x: Scalar, y: Scalar) -> tuple[Scalar, Float[Array, "2"], Float[Array, "2"]]:
    """Radius and the radial and tangential unit vectors of a point."""
    radius = jnp.hypot(x, y)
    return radius, jnp.stack([x, y]) / radius, jnp.stack([-y, x]) / radius


def _helicoid_slope(point, profile_slope: Scalar, lead: Scalar) -> Float[Array, "2"]:
    """∇z = f' e + (lead/2π)/r t of a helicoid."""
    radius, radial, tangential = point
    return profile_slope * radial + lead / (2 * jnp.pi * radius) * tangential


def _helicoid_hessian(
    point, profile_slope: Scalar, profile_bend: Scalar | float, lead: Scalar
) -> Float[Array, "2 2"]:
    """∇∇z = f'' e eᵀ + f'/r t tᵀ − (lead/2π)/r² (e tᵀ + t eᵀ) of a helicoid."""
    radius, radial, tangential = point
    mixed = jnp.outer(radial, tangential)
    return (
        profile_bend * jnp.outer(radial, radial)
        + profile_slope / radius * jnp.outer(tangential, tangential)
        - lead / (2 * jnp.pi * radius**2) * (mixed + mixed.T)
    )


def screw_side_slopes(
    thread: Thread, x: Scalar, y: Scalar
) -> tuple[Float[Array, "2"], Float[Array, "2"]]:
    """Gradients of the loaded screw and roller flanks over the point (x, y).

    They are equal where the flanks touch: common normal.

    **Arguments:**

    - `thread`: the thread geometry.
    - `x`, `y`: transverse coordinates about the screw axis, roller axis at (a, 0) [m].
    """
    screw = _polar(x, y)
    roller = _polar(x - thread.centre_distance, y)
    height, offset = _arc(thread, roller[0])
    return (
        _helicoid_slope(screw, jnp.tan(thread.flank_angle), thread.lead),
        _helicoid_slope(roller, -offset / height, thread.pitch),
    )


def screw_side_hessian(thread: Thread, x: Scalar, y: Scalar) -> Float[Array, "2 2"]:
    """Hessian of `screw_side_gap` over the transverse plane [1/m]."""
    screw = _polar(x, y)
    roller = _polar(x - thread.centre_distance, y)
    height, offset = _arc(thread, roller[0])
    # f = √(ρ² − d²): f' = −d/f, f'' = −ρ²/f³.
    bend = -(thread.profile_radius**2) / height**3
    return _helicoid_hessian(
        screw, jnp.tan(thread.flank_angle), 0.0, thread.lead
    ) - _helicoid_hessian(roller, -offset / height, bend, thread.pitch)


def nut_side_hessian(thread: Thread, x: Scalar, y: Scalar) -> Float[Array, "2 2"]:
    """Hessian of `nut_side_gap` over the transverse plane [1/m]."""
    nut = _polar(x, y)
    roller = _polar(x - thread.centre_distance, y)
    height, offset = _arc(thread, roller[0])
    bend = thread.profile_radius**2 / height**3
    return _helicoid_hessian(roller, offset / height, bend, thread.pitch) - _helicoid_hessian(
        nut, jnp.tan(thread.flank_angle), 0.0, thread.lead
    )


def screw_side_heights(thread: Thread, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
    """Axial heights of the loaded screw and roller flanks over the point (x, y) [m].

    Both are zero at the nominal point (r_s, 0) when both teeth are half a pitch thick; the screw's
    is above.

    **Arguments:**

    - `thread`: the thread geometry.
    - `x`, `y`: transverse coordinates about the screw axis, roller axis at (a, 0) [m].
    """
    centre = thread.centre_distance
    screw_radius = jnp.hypot(x, y)
    roller_radius = jnp.hypot(x - centre, y)
    screw_turn, roller_turn = jnp.arctan2(y, x), -jnp.arctan2(y, centre - x)
    screw = jnp.tan(thread.flank_angle) * (screw_radius - thread.screw_radius)
    screw = screw + thread.lead / (2 * jnp.pi) * screw_turn
    roller = _arc_height(thread, roller_radius) - _arc_top(thread)
    roller = roller + thread.pitch / (2 * jnp.pi) * roller_turn
    return screw, roller


def screw_side_gap(thread: Thread, x: Scalar, y: Scalar) -> Scalar:
    """Axial gap between the loaded screw and roller flanks over the point (x, y) [m].

    Zero at the nominal point (r_s, 0) when both teeth are half a pitch thick; negative is
    interference.

    **Arguments:**

    - `thread`: the thread geometry.
    - `x`, `y`: transverse coordinates about the screw axis, roller axis at (a, 0) [m].
    """
    screw, roller = screw_side_heights(thread, x, y)
    return screw - roller


def nut_side_heights(thread: Thread, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
    """Axial heights of the loaded roller and nut flanks over the point (x, y); roller above [m].

    **Arguments:**

    - `thread`: the thread geometry.
    - `x`, `y`: transverse coordinates about the nut (and screw) axis, roller axis at (a, 0) [m].
    """
    centre = thread.centre_distance
    nut_radius = jnp.hypot(x, y)
    roller_radius = jnp.hypot(x - centre, y)
    nut = jnp.tan(thread.flank_angle) * (nut_radius - thread.nut_radius)
    nut = nut + thread.lead / (2 * jnp.pi) * jnp.arctan2(y, x)
    roller = _arc_top(thread) - _arc_height(thread, roller_radius)
    roller = roller + thread.pitch / (2 * jnp.pi) * jnp.arctan2(y, x - centre)
    return roller, nut


def nut_side_gap(thread: Thread, x: Scalar, y: Scalar) -> Scalar:
    """Axial gap between the loaded roller and nut flanks over the point (x, y) [m].

    **Arguments:**

    - `thread`: the thread geometry.
    - `x`, `y`: transverse coordinates about the nut (and screw) axis, roller axis at (a, 0) [m].
    """
    roller, nut = nut_side_heights(thread, x, y)
    return roller - nut
