"""From lead, contact angle and roller radius of the actuator to its frequencies, in mpmath.

Meshing of two helicoids, curvatures of their gap, Hertz contact, stiffness of one roller, gear
stiffness by ISO 6336-1, masses of cylinders, N + 10 degrees of freedom: all written apart from the
package, with the numbers of its example typed in again (SI).
"""

from typing import Any

import mpmath
import numpy as np

from .hertz import exact_hertz
from .meshing import Design, MeshPoint, mesh_point
from .vibration import DIGITS, frequencies

ROLLERS, STARTS, THREADS, LOAD = 10, 5, 20, 12e3
_YOUNG, _POISSON, _DENSITY = 210e9, 0.3, 7850
#: Length, bore or wall, of the bodies; carriers: two of 4 mm, 6 mm wide.
_SCREW_LENGTH, _SCREW_BORE, _ROLLER_LENGTH = 0.350, 0.004, 0.050
_NUT_LENGTH, _NUT_WALL, _RING_LENGTH, _RING_WALL = 0.080, 0.010, 0.006, 0.004
_CARRIERS, _CARRIER_LENGTH, _CARRIER_WIDTH = 2, 0.004, 0.006
#: Radial and torsional supports of screw, ring gear and nut; torsional support of the carriers.
_SUPPORTS = ((200e6, 50e6), (1000e6, 1000e6), (400e6, 100e6))
_CARRIER_SUPPORT = 1e6
_TEETH, _FACE_WIDTH = 16, 0.006


def _gradient_and_hessian(profile, reduced_lead, x, y, profile_bend=0):
    """First and second derivatives of z = f(r) + (L/2π) θ: f' and f'' given, about the axis."""
    radius = mpmath.hypot(x, y)
    radial, tangential = (x / radius, y / radius), (-y / radius, x / radius)
    turn = reduced_lead / radius
    gradient = [profile * e + turn * t for e, t in zip(radial, tangential, strict=True)]
    hessian = [
        [
            profile_bend * radial[i] * radial[j]
            + profile / radius * tangential[i] * tangential[j]
            - turn / radius * (radial[i] * tangential[j] + tangential[i] * radial[j])
            for j in range(2)
        ]
        for i in range(2)
    ]
    return gradient, hessian


def _curvatures(gradient, difference) -> tuple[Any, ...]:
    """A and B of the gap A x² + B y² in the tangent plane, A ≤ B, and the normal's z component.

    Roots k of det(H − k (I + g gᵀ)) = 0, over √(1 + g²), halved.
    """
    gx, gy = gradient
    metric = [[1 + gx * gx, gx * gy], [gx * gy, 1 + gy * gy]]
    (hxx, hxy), (_, hyy) = difference
    a = metric[0][0] * metric[1][1] - metric[0][1] ** 2
    b = -(hxx * metric[1][1] + hyy * metric[0][0] - 2 * hxy * metric[0][1])
    c = hxx * hyy - hxy**2
    root = mpmath.sqrt(b * b - 4 * a * c)
    upward = 1 / mpmath.sqrt(1 + gx * gx + gy * gy)
    ends = sorted(((-b - root) / (2 * a), (-b + root) / (2 * a)))
    return ends[0] * upward / 2, ends[1] * upward / 2, upward


def _roller_stiffness(lead, contact_angle, roller) -> tuple[Any, ...]:
    """Axial secant stiffness of one roller against screw and nut, threads in parallel [N/m]."""
    flank = mpmath.pi / 2 - contact_angle
    profile = roller / mpmath.sin(flank)
    point: MeshPoint = mesh_point(Design(lead, STARTS, roller, contact_angle, profile))
    slope, turn = mpmath.tan(flank), lead / (2 * mpmath.pi)
    centre = (STARTS - 1) * roller
    modulus = mpmath.mpf(_YOUNG) / (2 * (1 - mpmath.mpf(_POISSON) ** 2))
    force = mpmath.mpf(LOAD) / (ROLLERS * THREADS)
    found = []
    # Screw: its flank faces the roller's arc, whose slope is −d/√(ρ² − d²) with d from its centre.
    offset = point.roller_radius - (roller - profile * mpmath.sin(flank))
    height = mpmath.sqrt(profile**2 - offset**2)
    screw = _gradient_and_hessian(slope, turn, point.x, point.y)
    arc = _gradient_and_hessian(
        -offset / height, turn / STARTS, point.x - centre, point.y, -(profile**2) / height**3
    )
    # Nut: on the line of centres, both helix angles alike; the arc stands on the other side.
    nut_radius = STARTS * roller
    nut = _gradient_and_hessian(slope, turn, nut_radius, mpmath.mpf(0))
    offset = profile * mpmath.sin(flank)
    height = mpmath.sqrt(profile**2 - offset**2)
    outer = _gradient_and_hessian(
        offset / height, turn / STARTS, roller, mpmath.mpf(0), profile**2 / height**3
    )
    for upper, lower in ((screw, arc), (outer, nut)):
        difference = [
            [p - q for p, q in zip(*rows, strict=True)]
            for rows in zip(upper[1], lower[1], strict=True)
        ]
        smaller, larger, upward = _curvatures(upper[0], difference)
        _, approach, _, _ = exact_hertz(force / upward, smaller, larger, modulus)
        found.append(THREADS * force * upward / approach)
    return tuple(found)


def _cylinder(length, inner, outer) -> tuple[Any, ...]:
    """Mass and moment of inertia about the axis."""
    mass = mpmath.pi * _DENSITY * mpmath.mpf(length) * (outer**2 - inner**2)
    return mass, mass * (outer**2 + inner**2) / 2


def _gear_stiffness():
    """Single-tooth stiffness of ISO 6336-1 without profile shift, times the face width [N/m]."""
    ring = STARTS * _TEETH
    q = mpmath.mpf("0.04723") + mpmath.mpf("0.15551") / _TEETH + mpmath.mpf("0.25791") / ring
    return mpmath.mpf("0.8") / q * _FACE_WIDTH * 10**9


def numbers(lead, contact_angle, roller) -> list[Any]:
    """The eighteen numbers of the vibration model, in the order of `references.vibration`."""
    lead, contact_angle, roller = (mpmath.mpf(one) for one in (lead, contact_angle, roller))
    screw, nut, centre = ((STARTS - 2) * roller, STARTS * roller, (STARTS - 1) * roller)
    screw_roller, nut_roller = _roller_stiffness(lead, contact_angle, roller)
    # Wu et al. 2022: along the thread's tangent, c² = cos² of the roller's helix angle.
    share = 1 / (1 + (lead / (2 * mpmath.pi * nut)) ** 2)
    wall, ring_wall, half = (
        mpmath.mpf(_NUT_WALL),
        mpmath.mpf(_RING_WALL),
        mpmath.mpf(_CARRIER_WIDTH) / 2,
    )
    bodies = (
        (*_cylinder(_SCREW_LENGTH, mpmath.mpf(_SCREW_BORE), screw), screw, screw_roller * share),
        (*_cylinder(_RING_LENGTH, nut, nut + ring_wall), nut, _gear_stiffness()),
        (*_cylinder(_NUT_LENGTH, nut, nut + wall), nut, nut_roller * share),
    )
    found: list[Any] = []
    for (mass, inertia, radius, mesh), (radial, torsional) in zip(bodies, _SUPPORTS, strict=True):
        found += [mass, inertia / radius**2, mesh, mpmath.mpf(radial), mpmath.mpf(torsional)]
    mass, inertia = _cylinder(_ROLLER_LENGTH, 0, roller)
    _, carrier = _cylinder(_CARRIER_LENGTH, centre - half, centre + half)
    carriers = _CARRIERS * carrier / centre**2 + ROLLERS * mass
    return [*found, inertia / roller**2, carriers, mpmath.mpf(_CARRIER_SUPPORT)]


def _distinct(values: np.ndarray, numbers_of_system) -> list[int]:
    """Places of one frequency each: carrier, torsional, transverse, roller; by multiplicity."""
    groups: list[list[int]] = []
    for place, value in enumerate(values):
        if groups and abs(value / values[groups[-1][0]] - 1) < 1e-9:
            groups[-1].append(place)
        else:
            groups.append([place])
    carrier = float(mpmath.sqrt(numbers_of_system[17] / numbers_of_system[16]) / (2 * mpmath.pi))
    single = [g[0] for g in groups if len(g) == 1]
    double = [g[0] for g in groups if len(g) == 2]
    (many,) = [g[0] for g in groups if len(g) == ROLLERS - 3]
    own = min(single, key=lambda place: abs(values[place] - carrier))
    return [own, *(place for place in single if place != own), *double, many]


def frequency_slopes(lead: float, contact_angle: float, roller: float) -> np.ndarray:
    """Derivatives of the ten distinct frequencies by the three variables, shape (10, 3).

    By the chain rule over the eighteen numbers: their elasticities from the eigenvectors, and
    differences of the numbers over a step that leaves 20 digits.
    """
    with mpmath.workdps(DIGITS):
        here = [mpmath.mpf(one) for one in (lead, contact_angle, roller)]
        system = numbers(*here)
        values, elasticities = frequencies(system, ROLLERS, elasticities=True)
        assert elasticities is not None
        places = _distinct(values, system)
        step = mpmath.mpf(10) ** (-DIGITS // 4)
        slopes = np.zeros((len(places), 3))
        for column, value in enumerate(here):
            ends = []
            for factor in (1 + step, 1 - step):
                moved = list(here)
                moved[column] = value * factor
                ends.append(numbers(*moved))
            relative = np.array(
                [
                    float((a - b) / (2 * step * value * c))
                    for a, b, c in zip(*ends, system, strict=True)
                ]
            )
            slopes[:, column] = [values[at] * (elasticities[at] @ relative) for at in places]
        return slopes
