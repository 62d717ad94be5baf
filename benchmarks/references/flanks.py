"""Flanks of one thread in plain floats, and where screw and roller touch, by SciPy."""

from math import cos, hypot, pi, sin, sqrt, tan
from typing import NamedTuple

from scipy.optimize import root


class Flanks(NamedTuple):
    """Lengths and slopes of one thread; p and L over 2π."""

    roller: float
    screw: float
    nut: float
    centre: float
    slope: float
    helical: float
    roller_helical: float
    arc_centre: float
    profile: float


def flanks_of(
    lead: float, contact_angle: float, roller: float, starts: float, profile: float | None = None
) -> Flanks:
    """Flanks of a screw with nominal radii; without a profile radius the roller's arc is a ball."""
    flank = pi / 2 - contact_angle
    radius = roller / cos(contact_angle) if profile is None else profile
    return Flanks(
        roller=roller,
        screw=(starts - 2) * roller,
        nut=starts * roller,
        centre=(starts - 1) * roller,
        slope=tan(flank),
        helical=lead / (2 * pi),
        roller_helical=lead / starts / (2 * pi),
        arc_centre=roller - radius * sin(flank),
        profile=radius,
    )


def contact_point(flanks: Flanks) -> tuple[float, float]:
    """Where screw and roller touch, x and y [m]: equal gradients, by Powell's hybrid method."""
    roller, screw, _, centre, slope, helical, roller_helical, arc_centre, profile = flanks

    def residual(point):
        x, y = point[0] * centre, point[1] * centre
        from_roller = x - centre
        screw_radius, roller_radius = hypot(x, y), hypot(from_roller, y)
        offset = roller_radius - arc_centre
        arc = -offset / sqrt(profile**2 - offset**2)
        return (
            (slope * x - helical * y / screw_radius) / screw_radius
            - (arc * from_roller - roller_helical * y / roller_radius) / roller_radius,
            (slope * y + helical * x / screw_radius) / screw_radius
            - (arc * y + roller_helical * from_roller / roller_radius) / roller_radius,
        )

    angle = (helical / screw + roller_helical / roller) / (slope * (1 + screw / roller))
    start = (screw * cos(angle) / centre, -screw * sin(angle) / centre)
    x, y = root(residual, start, tol=1e-14).x * centre
    return float(x), float(y)
