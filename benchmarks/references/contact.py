"""Largest Hertz pressure and efficiency of one stage in mpmath, from the exact flanks."""

import mpmath
import numpy as np

from .hertz import hertz
from .meshing import DIGITS, Design, MeshPoint, frame_of, mesh_point

Vector = tuple[mpmath.mpf, mpmath.mpf]


def _helicoid_hessian(offset: Vector, first, second, helical) -> mpmath.matrix:
    """Hessian of f(r) + c θ: f'' e eᵀ + (f'/r) t tᵀ − (c/r²)(e tᵀ + t eᵀ)."""
    radius = mpmath.hypot(*offset)
    e = mpmath.matrix([offset[0] / radius, offset[1] / radius])
    t = mpmath.matrix([-e[1], e[0]])
    return (
        second * (e * e.T) + first / radius * (t * t.T) - helical / radius**2 * (e * t.T + t * e.T)
    )


def _gap_coefficients(slope: Vector, hessian: mpmath.matrix):
    """A, B and F_n/F_a: eigenvalues of ½ cos γ G⁻¹ H with the metric G = I + g gᵀ."""
    steepness = slope[0] ** 2 + slope[1] ** 2
    g = mpmath.matrix(slope)
    tensor = (mpmath.eye(2) - g * g.T / (1 + steepness)) * hessian / mpmath.sqrt(1 + steepness)
    mean = (tensor[0, 0] + tensor[1, 1]) / 4
    root = mpmath.sqrt(mean**2 - mpmath.det(tensor) / 4)
    return mean - root, mean + root, mpmath.sqrt(1 + steepness)


def gaps(design: Design, point: MeshPoint):
    """A, B and F_n/F_a of screw side and nut side, at the digits that mpmath works with."""
    lead, starts, roller, contact_angle, profile = (mpmath.mpf(value) for value in design)
    flank = mpmath.pi / 2 - contact_angle
    slope, centre = mpmath.tan(flank), (starts - 1) * roller
    helical, roller_helical = lead / (2 * mpmath.pi), lead / starts / (2 * mpmath.pi)

    def arc(radius):
        offset = radius - (roller - profile * mpmath.sin(flank))
        height = mpmath.sqrt(profile**2 - offset**2)
        return -offset / height, -(profile**2) / height**3

    on_screw, on_roller = (point.x, point.y), (point.x - centre, point.y)
    first, second = arc(point.roller_radius)
    hessian = _helicoid_hessian(on_screw, slope, 0, helical)
    hessian -= _helicoid_hessian(on_roller, first, second, roller_helical)
    gradient = (
        (slope * point.x - helical * point.y / point.screw_radius) / point.screw_radius,
        (slope * point.y + helical * point.x / point.screw_radius) / point.screw_radius,
    )
    yield _gap_coefficients(gradient, hessian)

    nut = starts * roller
    first, second = arc(roller)
    hessian = _helicoid_hessian((roller, mpmath.mpf(0)), -first, -second, roller_helical)
    hessian -= _helicoid_hessian((nut, mpmath.mpf(0)), slope, 0, helical)
    yield _gap_coefficients((slope, helical / nut), hessian)


def largest_pressure(design: Design, axial_force, modulus) -> float:
    """p₀ of the worse side [Pa]; F_a of one contact [N], E* [Pa]."""
    with mpmath.workdps(DIGITS):
        pressures = []
        for smaller, larger, factor in gaps(design, mesh_point(design)):
            force = mpmath.mpf(axial_force) * factor
            pressures.append(hertz(force, smaller, larger, modulus)[0])
        return max(pressures)


def forward_efficiency(design: Design, friction) -> float:
    """Efficiency of one stage with Coulomb friction in its threads, screw driving."""
    with mpmath.workdps(DIGITS):
        return float(_efficiency(design, friction))


def efficiency_slopes(numbers, starts, friction) -> np.ndarray:
    """Derivatives of that efficiency by lead, contact angle and roller radius.

    By differences of fourth order, good to 1e-15; the profile radius of the roller follows from its
    radius and the contact angle.
    """
    with mpmath.workdps(DIGITS):
        step = mpmath.mpf(10) ** -4
        slopes = []
        for column in range(3):
            ends = []
            for sign in (1, -1, 2, -2):
                lead, angle, radius = (
                    mpmath.mpf(value) * (1 + sign * step * (place == column))
                    for place, value in enumerate(map(float, numbers))
                )
                profile = radius / mpmath.cos(angle)
                ends.append(_efficiency(Design(lead, starts, radius, angle, profile), friction))
            slopes.append(
                float(
                    (8 * (ends[0] - ends[1]) - ends[2] + ends[3])
                    / (12 * step * mpmath.mpf(float(numbers[column])))
                )
            )
        return np.array(slopes)


def _efficiency(design: Design, friction):
    """As many digits as mpmath works with.

    `η = 1/(1 + 2π μ ‖v‖/(Ω L (1/Q − μ v_z/‖v‖)))`, `Q = √(1 + tan²α + tan²λ)` at the contact.
    """
    arm, drive, normal, ratio = frame_of(design, mesh_point(design))
    friction = mpmath.mpf(friction)
    axial = mpmath.mpf(design.lead) / (2 * mpmath.pi)
    slip = (arm[0] - ratio * drive[0], arm[1] - ratio * drive[1], axial)
    size = mpmath.sqrt(sum(component**2 for component in slip))
    return 1 / (1 + friction * size / (axial * (-normal[2] - friction * axial / size)))
