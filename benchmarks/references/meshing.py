"""Meshing of screw and roller in mpmath: common normal of two helicoids.

Condition: equal in-plane gradients
`f_s'(ρ_s) e_s + (L/2π)/ρ_s t_s = f_R'(ρ_R) e_R + (p/2π)/ρ_R t_R`
at a point (x, y), screw axis at the origin, roller axis at (a, 0).
"""

from typing import NamedTuple

import mpmath

#: Decimal digits of the root search.
DIGITS = 30


class Design(NamedTuple):
    """Thread geometry in SI; the profile radius is that of the roller's convex arc."""

    lead: float
    starts: float
    roller_radius: float
    contact_angle: float
    profile_radius: float


class MeshPoint(NamedTuple):
    """The contact point of the screw side, and what was found on the way (all mpf)."""

    x: mpmath.mpf
    y: mpmath.mpf
    screw_radius: mpmath.mpf
    screw_angle: mpmath.mpf
    roller_radius: mpmath.mpf
    roller_angle: mpmath.mpf


def mesh_point(design: Design) -> MeshPoint:
    """Contact of screw and roller. Call it under `mpmath.workdps(DIGITS)` or more."""
    lead, starts, roller, contact_angle, profile = (mpmath.mpf(value) for value in design)
    flank = mpmath.pi / 2 - contact_angle
    screw, centre = (starts - 2) * roller, (starts - 1) * roller
    screw_lead, roller_lead = lead / (2 * mpmath.pi), lead / starts / (2 * mpmath.pi)
    slope = mpmath.tan(flank)

    def residual(x, y):
        screw_radius, roller_radius = mpmath.hypot(x, y), mpmath.hypot(x - centre, y)
        offset = roller_radius - (roller - profile * mpmath.sin(flank))
        arc = -offset / mpmath.sqrt(profile**2 - offset**2)
        gradients = []
        for dx, radius, radial, helical in (
            (x, screw_radius, slope, screw_lead),
            (x - centre, roller_radius, arc, roller_lead),
        ):
            gradients.append(
                (
                    (radial * dx - helical * y / radius) / radius,
                    (radial * y + helical * dx / radius) / radius,
                )
            )
        (screw_x, screw_y), (roller_x, roller_y) = gradients
        return screw_x - roller_x, screw_y - roller_y

    start_angle = (lead / screw + lead / (starts * roller)) / (2 * mpmath.pi)
    start_angle /= slope * (1 + screw / roller)
    start = (screw * mpmath.cos(start_angle), -screw * mpmath.sin(start_angle))
    x, y = mpmath.findroot(residual, start, tol=mpmath.mpf(10) ** (4 - 2 * mpmath.mp.dps))
    return MeshPoint(
        x,
        y,
        mpmath.hypot(x, y),
        mpmath.atan2(y, x),
        mpmath.hypot(x - centre, y),
        mpmath.atan2(y, centre - x),
    )


class Frame(NamedTuple):
    """How screw and roller touch and move at the contact point of the screw side (mpf)."""

    #: Velocity of the screw's contact point per radian of screw turn [m].
    arm: tuple[mpmath.mpf, mpmath.mpf]
    #: Generalised arm of the carrier speed, ∂v_R/∂ω [m].
    drive: tuple[mpmath.mpf, mpmath.mpf]
    normal: tuple[mpmath.mpf, mpmath.mpf, mpmath.mpf]
    #: ζ∞: friction has no component along ∂v_R/∂ω.
    steady_ratio: mpmath.mpf


def frame_of(design: Design, point: MeshPoint) -> Frame:
    """The frame at the contact point of a design, at the digits that mpmath works with."""
    lead, starts, _, contact_angle, _ = (mpmath.mpf(value) for value in design)
    slope, radius = mpmath.tan(mpmath.pi / 2 - contact_angle), point.screw_radius
    cosine, sine = mpmath.cos(point.screw_angle), mpmath.sin(point.screw_angle)
    helical = lead / (2 * mpmath.pi) / radius
    gradient = (slope * cosine - helical * sine, slope * sine + helical * cosine)
    size = mpmath.sqrt(1 + gradient[0] ** 2 + gradient[1] ** 2)
    arm = (-radius * sine, radius * cosine)
    turned = starts * point.roller_radius
    drive = (
        arm[0] + turned * mpmath.sin(point.roller_angle),
        arm[1] + turned * mpmath.cos(point.roller_angle),
    )
    ratio = (arm[0] * drive[0] + arm[1] * drive[1]) / (drive[0] ** 2 + drive[1] ** 2)
    return Frame(arm, drive, (gradient[0] / size, gradient[1] / size, -1 / size), ratio)
