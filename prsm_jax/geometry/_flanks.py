"""The thread flanks as helicoids z = f(r) + (lead / 2π) θ, in the transverse plane.

The screw axis is the origin, the roller axis lies at (a, 0). On the screw side the loaded screw
flank faces −z and the loaded roller flank +z; on the nut side it is the other way round. The
screw and nut flanks are straight in the axial section, with the flank angle α measured from the
transverse plane; the roller flank is a convex arc of radius ρ that passes through the nominal
radius with the slope tan α. Heights are counted from the flanks at the nominal radii.
"""

from typing import NamedTuple, TypeAlias

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool

from ..fields import Scalar
from ..mechanism import Side, Thread

#: Gradient (∂z/∂x, ∂z/∂y) of a height over the transverse plane. Plain numbers rather than an
#: array, like `SymmetricTensor`: a batch of designs then runs in one fused loop without a copy.
Slope: TypeAlias = tuple[Scalar, Scalar]


#: Value of (ρ² − d²)/ρ² at which the roller's arc is taken to end.
_ARC_END = 1e-4


class SymmetricTensor(NamedTuple):
    """A symmetric 2×2 tensor, like the second derivatives of a height [1/m]."""

    xx: Scalar
    xy: Scalar
    yy: Scalar


class FlankGeometry(eqx.Module):
    """Numbers that describe the flanks of one stage."""

    #: Slope tan α of screw and nut in the axial section, and of the roller at its nominal radius.
    slope: Scalar
    #: Lead of the screw over 2π [m/rad].
    reduced_lead: Scalar
    #: Lead of the roller over 2π; negative for the other hand than the screw's [m/rad].
    roller_reduced_lead: Scalar
    centre_distance: Scalar
    screw_radius: Scalar
    nut_radius: Scalar
    #: Radius ρ of the roller's profile arc [m].
    profile_radius: Scalar
    #: Distance of the arc's centre from the roller axis, r_R − ρ sin α [m].
    arc_centre: Scalar
    #: Lead of the nut over 2π, unless it is that of the screw [m/rad].
    own_nut_lead: Scalar | None = None
    #: The body that has the helix angle of the roller; `None` if both bodies have another.
    carrying: Side | None = eqx.field(static=True, default="nut")

    @property
    def nut_reduced_lead(self) -> Scalar:
        """Lead of the nut over 2π [m/rad]."""
        return self.reduced_lead if self.own_nut_lead is None else self.own_nut_lead

    @property
    def mirrored_nut(self) -> "FlankGeometry":
        """Flanks of a screw whose contact equations are those of the nut.

        The gradients of the nut's side are equal where those of a screw of the nut's radius and
        lead are, with the roller at negative distances from its axis.
        """
        return FlankGeometry(
            slope=self.slope,
            reduced_lead=self.nut_reduced_lead,
            roller_reduced_lead=self.roller_reduced_lead,
            centre_distance=self.centre_distance,
            screw_radius=self.nut_radius,
            nut_radius=self.screw_radius,
            profile_radius=-self.profile_radius,
            arc_centre=-self.arc_centre,
            carrying=None if self.carrying is None else "nut",
        )


class _Polar(NamedTuple):
    """A point about an axis: 1/r and the radial unit vector (the tangential one is (−y, x))."""

    inverse_radius: Scalar
    x: Scalar
    y: Scalar


def flanks_of(thread: Thread) -> FlankGeometry:
    """The flanks of a thread geometry.

    **Arguments:**

    - `thread`: the thread geometry.
    """
    # By a division: XLA's CPU compiler evaluates a tangent, a slow call, again in every loop over a
    # batch that uses it, but a quotient once.
    slope = 1 / jnp.tan(thread.contact_angle)
    family, reduced_lead = thread.family, thread.lead / (2 * jnp.pi)
    no_lead = None if family.roller_hand else jnp.zeros_like(slope)
    profile_radius = thread.roller_profile_radius
    sine = slope / jnp.sqrt(1 + slope**2)
    if profile_radius is None:
        # The arc is centred on the axis.
        profile_radius, arc_centre = thread.roller_radius / sine, jnp.zeros_like(sine)
    else:
        arc_centre = thread.roller_radius - profile_radius * sine
    return FlankGeometry(
        slope=slope,
        reduced_lead=reduced_lead,
        roller_reduced_lead=_roller_lead(thread, reduced_lead) if no_lead is None else no_lead,
        centre_distance=thread.centre_distance,
        screw_radius=thread.screw_radius,
        nut_radius=thread.nut_radius,
        profile_radius=profile_radius,
        arc_centre=arc_centre,
        own_nut_lead=None if family.nut_has_thread else no_lead,
        carrying=family.carrying if family.roller_hand else None,
    )


def _roller_lead(thread: Thread, reduced_lead: Scalar) -> Scalar:
    """Lead of a threaded roller over 2π [m/rad]."""
    lead = reduced_lead / thread.starts
    return lead if thread.family.roller_hand == 1 else -lead


def _arc(flanks: FlankGeometry, radius: Scalar) -> tuple[Scalar, Scalar]:
    """Height √(ρ² − d²) of the roller's profile arc and its offset d from the arc's centre [m].

    Beyond the end of the arc (|d| > ρ) there is no flank; there the height is limited to 0.01 ρ.
    """
    offset = radius - flanks.arc_centre
    # A hundredth of ρ above its end the arc is already steeper than any thread flank.
    floor = _ARC_END * flanks.profile_radius**2
    return jnp.sqrt(jnp.maximum(flanks.profile_radius**2 - offset**2, floor)), offset


def past_roller_arc(flanks: FlankGeometry, x: Scalar, y: Scalar) -> Bool[Array, ""]:
    """Whether the roller's profile arc ends before the point (x, y); addenda are not considered.

    **Arguments:**

    - `flanks`: of the stage.
    - `x`, `y`: transverse coordinates about the screw axis, roller axis at (a, 0) [m].
    """
    offset = jnp.hypot(x - flanks.centre_distance, y) - flanks.arc_centre
    return offset**2 >= (1 - _ARC_END) * flanks.profile_radius**2


def _depth(flanks: FlankGeometry, radius: Scalar) -> Scalar:
    """Depth of the roller's profile below its height at the nominal radius [m]."""
    # √(ρ² − d²) = ρ cos α there.
    nominal = flanks.profile_radius / jnp.sqrt(1 + flanks.slope**2)
    return nominal - _arc(flanks, radius)[0]


def _polar(x: Scalar, y: Scalar) -> tuple[Scalar, _Polar]:
    """Distance from an axis, and the point about it."""
    radius = jnp.sqrt(x**2 + y**2)
    inverse = 1 / radius
    return radius, _Polar(inverse, x * inverse, y * inverse)


def _helicoid_hessian(
    point: _Polar, profile_slope: Scalar, profile_bend: Scalar | float, reduced_lead: Scalar
) -> SymmetricTensor:
    """∇∇z = f'' e eᵀ + f'/r t tᵀ − (lead/2π)/r² (e tᵀ + t eᵀ) of a helicoid."""
    along, mixed, across = point.x**2, point.x * point.y, point.y**2
    turn = profile_slope * point.inverse_radius
    shear = reduced_lead * point.inverse_radius**2
    return SymmetricTensor(
        profile_bend * along + turn * across + 2 * shear * mixed,
        (profile_bend - turn) * mixed - shear * (along - across),
        profile_bend * across + turn * along - 2 * shear * mixed,
    )


def _hessians(
    flanks: FlankGeometry, x: Scalar, y: Scalar, reduced_lead: Scalar, roller_reduced_lead: Scalar
) -> tuple[SymmetricTensor, SymmetricTensor]:
    """Hessians of a straight flank with a lead, and of the roller flank measured as a depth."""
    _, straight = _polar(x, y)
    radius, roller = _polar(x - flanks.centre_distance, y)
    height, offset = _arc(flanks, radius)
    # f = √(ρ² − d²): −f' = d/f, −f'' = ρ²/f³.
    inverse = 1 / height
    bend = flanks.profile_radius**2 * inverse**3
    return (
        _helicoid_hessian(straight, flanks.slope, 0.0, reduced_lead),
        _helicoid_hessian(roller, offset * inverse, bend, roller_reduced_lead),
    )


def screw_side_hessian(flanks: FlankGeometry, x: Scalar, y: Scalar) -> SymmetricTensor:
    """Hessian of `screw_side_gap` over the transverse plane [1/m]."""
    screw, depth = _hessians(flanks, x, y, flanks.reduced_lead, -flanks.roller_reduced_lead)
    return SymmetricTensor(screw.xx + depth.xx, screw.xy + depth.xy, screw.yy + depth.yy)


def nut_side_hessian(flanks: FlankGeometry, x: Scalar, y: Scalar) -> SymmetricTensor:
    """Hessian of `nut_side_gap` over the transverse plane [1/m]."""
    nut, roller = _hessians(flanks, x, y, flanks.nut_reduced_lead, flanks.roller_reduced_lead)
    return SymmetricTensor(roller.xx - nut.xx, roller.xy - nut.xy, roller.yy - nut.yy)


def screw_side_heights(flanks: FlankGeometry, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
    """Axial heights of the loaded screw and roller flanks over the point (x, y) [m].

    Both are zero at the nominal point (r_s, 0) when both teeth are half a pitch thick; the screw's
    is above.

    **Arguments:**

    - `flanks`: of the stage.
    - `x`, `y`: transverse coordinates about the screw axis, roller axis at (a, 0) [m].
    """
    from_roller = flanks.centre_distance - x
    screw_radius = jnp.sqrt(x**2 + y**2)
    roller_radius = jnp.sqrt(from_roller**2 + y**2)
    screw = flanks.slope * (screw_radius - flanks.screw_radius)
    screw = screw + flanks.reduced_lead * jnp.arctan2(y, x)
    roller = -_depth(flanks, roller_radius)
    return screw, roller - flanks.roller_reduced_lead * jnp.arctan2(y, from_roller)


def screw_side_gap(flanks: FlankGeometry, x: Scalar, y: Scalar) -> Scalar:
    """Axial gap between the loaded screw and roller flanks over the point (x, y) [m].

    Zero at the nominal point (r_s, 0) when both teeth are half a pitch thick; negative is
    interference.

    **Arguments:**

    - `flanks`: of the stage.
    - `x`, `y`: transverse coordinates about the screw axis, roller axis at (a, 0) [m].
    """
    screw, roller = screw_side_heights(flanks, x, y)
    return screw - roller


def nut_side_heights(flanks: FlankGeometry, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
    """Axial heights of the loaded roller and nut flanks over the point (x, y); roller above [m].

    **Arguments:**

    - `flanks`: of the stage.
    - `x`, `y`: transverse coordinates about the nut (and screw) axis, roller axis at (a, 0) [m].
    """
    from_roller = x - flanks.centre_distance
    nut_radius = jnp.sqrt(x**2 + y**2)
    roller_radius = jnp.sqrt(from_roller**2 + y**2)
    nut = flanks.slope * (nut_radius - flanks.nut_radius)
    nut = nut + flanks.nut_reduced_lead * jnp.arctan2(y, x)
    roller = _depth(flanks, roller_radius)
    return roller + flanks.roller_reduced_lead * jnp.arctan2(y, from_roller), nut


def nut_side_gap(flanks: FlankGeometry, x: Scalar, y: Scalar) -> Scalar:
    """Axial gap between the loaded roller and nut flanks over the point (x, y) [m].

    **Arguments:**

    - `flanks`: of the stage.
    - `x`, `y`: transverse coordinates about the nut (and screw) axis, roller axis at (a, 0) [m].
    """
    roller, nut = nut_side_heights(flanks, x, y)
    return roller - nut
