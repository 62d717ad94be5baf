"""From lead, contact angle and roller radius of the actuator to its frequencies, in mpmath.

Meshing of two helicoids, curvatures of their gap, Hertz contact, stiffness of one roller, gear
stiffness by ISO 6336-1, masses of cylinders, N + 10 degrees of freedom: all written apart from the
package, with the numbers of its example typed in again (SI).
"""

from typing import Any

import mpmath
import numpy as np

from .contact import gaps
from .hertz import exact_hertz
from .meshing import Design, mesh_point
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


def _roller_stiffness(lead, contact_angle, roller) -> tuple[Any, ...]:
    """Axial secant stiffness of one roller against screw and nut, threads in parallel [N/m]."""
    design = Design(lead, STARTS, roller, contact_angle, roller / mpmath.cos(contact_angle))
    modulus = mpmath.mpf(_YOUNG) / (2 * (1 - mpmath.mpf(_POISSON) ** 2))
    force = mpmath.mpf(LOAD) / (ROLLERS * THREADS)
    found = []
    for smaller, larger, factor in gaps(design, mesh_point(design)):
        _, approach, _, _ = exact_hertz(force * factor, smaller, larger, modulus)
        found.append(THREADS * force / factor / approach)
    return tuple(found)


def cylinder(length, inner, outer, density=_DENSITY) -> tuple[Any, ...]:
    """Mass and moment of inertia about the axis."""
    mass = mpmath.pi * density * mpmath.mpf(length) * (outer**2 - inner**2)
    return mass, mass * (outer**2 + inner**2) / 2


def gear_stiffness(teeth, ring_teeth, face_width):
    """Single-tooth stiffness of ISO 6336-1 without profile shift, times the face width [N/m]."""
    q = mpmath.mpf("0.04723") + mpmath.mpf("0.15551") / teeth + mpmath.mpf("0.25791") / ring_teeth
    return mpmath.mpf("0.8") / q * face_width * 10**9


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
    gear = gear_stiffness(_TEETH, STARTS * _TEETH, _FACE_WIDTH)
    bodies = (
        (*cylinder(_SCREW_LENGTH, mpmath.mpf(_SCREW_BORE), screw), screw, screw_roller * share),
        (*cylinder(_RING_LENGTH, nut, nut + ring_wall), nut, gear),
        (*cylinder(_NUT_LENGTH, nut, nut + wall), nut, nut_roller * share),
    )
    found: list[Any] = []
    for (mass, inertia, radius, mesh), (radial, torsional) in zip(bodies, _SUPPORTS, strict=True):
        found += [mass, inertia / radius**2, mesh, mpmath.mpf(radial), mpmath.mpf(torsional)]
    mass, inertia = cylinder(_ROLLER_LENGTH, 0, roller)
    _, carrier = cylinder(_CARRIER_LENGTH, centre - half, centre + half)
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
