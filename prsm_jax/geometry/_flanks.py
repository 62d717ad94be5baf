"""The thread flanks as helicoids z = f(r) + (lead / 2π) θ, in the transverse plane.

The screw axis is the origin, the roller axis lies at (a, 0). On the screw side the loaded screw
flank faces −z and the loaded roller flank +z; on the nut side it is the other way round. The
screw and nut flanks are straight in the axial section, with the flank angle α measured from the
transverse plane; the roller flank is a convex arc of radius ρ that passes through the nominal
radius with the slope tan α. Heights are counted from the flanks at the nominal radii.
"""

import jax.numpy as jnp

from ..mechanism import Scalar, Thread


def _arc_height(thread: Thread, radius: Scalar) -> Scalar:
    """√(ρ² − d²) with d = r − (r_R − ρ sin α): height of the roller's profile arc [m].

    Beyond the end of the arc (|d| > ρ) there is no flank; the height is continued by a constant,
    whose zero slope keeps a diverging root search finite.
    """
    profile_radius = thread.profile_radius
    offset = radius - thread.roller_radius + profile_radius * jnp.sin(thread.flank_angle)
    square = profile_radius**2 - offset**2
    on_arc = square > 0
    return jnp.where(on_arc, jnp.sqrt(jnp.where(on_arc, square, 1.0)), 0.0)


def _arc_top(thread: Thread) -> Scalar:
    return thread.profile_radius * jnp.cos(thread.flank_angle)


def screw_side_gap(thread: Thread, x: Scalar, y: Scalar) -> Scalar:
    """Axial gap between the loaded screw and roller flanks over the point (x, y) [m].

    Zero at the nominal point (r_s, 0) when both teeth are half a pitch thick; negative is
    interference.

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
    return screw - roller


def nut_side_gap(thread: Thread, x: Scalar, y: Scalar) -> Scalar:
    """Axial gap between the loaded roller and nut flanks over the point (x, y) [m].

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
    return roller - nut
