"""The rival: frequencies, efficiency and pressure of one design after another, with SciPy.

Plain floats, because arrays of two or three numbers are slower: meshing by `scipy.optimize.root`
(hybr), Hertz contacts by `brentq` and `ellipkm1`, frequencies by `scipy.linalg.eigh`, and the
steady state by its linear equation. The numbers of the example `actuator` are typed in again (SI).
Its threads share the load equally, and it has neither spin nor rolling losses: with them, stiffness
and steady state need root searches of many unknowns, which a loop in Python would take longer for.
"""

import math
from collections.abc import Iterator
from math import hypot, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1

from ..references.flanks import Flanks, contact_point, flanks_of
from ..references.vibration import mass_terms, stiffness_terms

_ROLLERS, _STARTS, _THREADS, _LOAD = 10, 5, 20, 12e3
_YOUNG, _POISSON, _DENSITY = 210e9, 0.3, 7850.0
_MODULUS = _YOUNG / (2 * (1 - _POISSON**2))
_THREAD_FRICTION, _BEARING_FRICTION, _BEARING_RADIUS, _DRAG = 0.06, 0.003, 0.015, 0.05
_TEETH, _FACE_WIDTH = 16, 0.006
#: Radial and torsional supports of screw, ring gear and nut; torsional support of the carriers.
_SUPPORTS = ((200e6, 50e6), (1000e6, 1000e6), (400e6, 100e6))
_CARRIER_SUPPORT = 1e6
_STIFFNESS, _MASS = stiffness_terms(_ROLLERS), mass_terms(_ROLLERS)
_PLACES = np.arange(_ROLLERS + 10)


class _Gap(NamedTuple):
    """A x² + B y² between two flanks [1/m], and normal over axial force."""

    smaller: float
    larger: float
    factor: float


def _hessian(x: float, y: float, first: float, second: float, helical: float):
    """Hessian of f(r) + c θ: its entries xx, xy and yy."""
    radius = hypot(x, y)
    e, f = x / radius, y / radius
    turned, twist = first / radius, helical / radius**2
    return (
        second * e * e + turned * f * f + 2 * twist * e * f,
        (second - turned) * e * f - twist * (e * e - f * f),
        second * f * f + turned * e * e - 2 * twist * e * f,
    )


def _gap(gradient: tuple[float, float], hessian: tuple[float, float, float]) -> _Gap:
    """Half the eigenvalues of cos γ G⁻¹ H, with the metric G = I + g gᵀ of the flank."""
    (p, q), (a, b, d) = gradient, hessian
    square = 1 + p * p + q * q
    trace = ((1 + q * q) * a - 2 * p * q * b + (1 + p * p) * d) / square
    determinant = (a * d - b * b) / square
    mean = trace / (4 * sqrt(square))
    spread = sqrt(mean**2 - determinant / (4 * square))
    return _Gap(mean - spread, mean + spread, sqrt(square))


def _arc(flanks: Flanks, radius: float) -> tuple[float, float]:
    """First and second derivative of the roller's arc."""
    offset = radius - flanks.arc_centre
    height = sqrt(flanks.profile**2 - offset**2)
    return -offset / height, -(flanks.profile**2) / height**3


def _gaps(flanks: Flanks, x: float, y: float) -> Iterator[_Gap]:
    """Screw side, then nut side."""
    roller, nut, slope, helical = flanks.roller, flanks.nut, flanks.slope, flanks.helical
    radius, from_roller = hypot(x, y), x - flanks.centre
    ours = _hessian(x, y, slope, 0.0, helical)
    arc = _arc(flanks, hypot(from_roller, y))
    theirs = _hessian(from_roller, y, *arc, flanks.roller_helical)
    gradient = (
        (slope * x - helical * y / radius) / radius,
        (slope * y + helical * x / radius) / radius,
    )
    yield _gap(gradient, _difference(ours, theirs))
    first, second = _arc(flanks, roller)
    ours = _hessian(roller, 0.0, -first, -second, flanks.roller_helical)
    theirs = _hessian(nut, 0.0, slope, 0.0, helical)
    yield _gap((slope, helical / nut), _difference(ours, theirs))


def _difference(one, other) -> tuple[float, float, float]:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]


def _axis_ratio_residual(log_ratio: float, target: float) -> float:
    square = math.exp(2 * log_ratio)
    k, e = ellipkm1(square), ellipe(1 - square)
    return math.log((k - e) / (e / square - k)) - target


def _hertz(force: float, gap: _Gap) -> tuple[float, float]:
    """Largest pressure [Pa] and approach [m]."""
    target = math.log(gap.smaller / gap.larger)
    found: Any = brentq(
        _axis_ratio_residual, 1.2 * target, 0.4 * target, args=(target,), xtol=1e-14
    )
    ratio = math.exp(found)
    k, e = ellipkm1(ratio**2), ellipe(1 - ratio**2)
    total = gap.smaller + gap.larger
    major = math.cbrt(3 * force * e / (2 * pi * _MODULUS * ratio**2 * total))
    pressure = 3 * force / (2 * pi * ratio * major**2)
    return pressure, pressure * ratio * major * k / _MODULUS


def _efficiency(flanks: Flanks, x: float, y: float) -> float:
    """Output over input power of the steady state: friction of threads and bearing, and drag."""
    slope, helical, radius = flanks.slope, flanks.helical, hypot(x, y)
    p = (slope * x - helical * y / radius) / radius
    q = (slope * y + helical * x / radius) / radius
    normal = 1 / sqrt(1 + p * p + q * q)
    arm = (-y, x)
    from_roller = flanks.centre - x
    drive = (arm[0] + _STARTS * y, arm[1] + _STARTS * from_roller)
    ratio = (arm[0] * drive[0] + arm[1] * drive[1]) / (drive[0] ** 2 + drive[1] ** 2)
    size = sqrt((arm[0] - ratio * drive[0]) ** 2 + (arm[1] - ratio * drive[1]) ** 2 + helical**2)
    lost = _THREAD_FRICTION * size / (helical * (normal - _THREAD_FRICTION * helical / size))
    bearing = _BEARING_FRICTION * _LOAD * _BEARING_RADIUS
    return _LOAD * helical / (_LOAD * helical * (1 + lost) + bearing + _DRAG)


def _cylinder(length: float, inner: float, outer: float) -> tuple[float, float]:
    """Mass and moment of inertia about the axis."""
    mass = pi * _DENSITY * length * (outer**2 - inner**2)
    return mass, mass * (outer**2 + inner**2) / 2


def _system(flanks: Flanks, screw_roller: float, nut_roller: float) -> np.ndarray:
    """The numbers of the vibration model, in the order of `references.vibration`."""
    screw, nut, centre = flanks.screw, flanks.nut, flanks.centre
    # Wu et al. 2022: along the thread's tangent.
    share = 1 / (1 + (flanks.helical / nut) ** 2)
    gear = 0.8e9 / (0.04723 + 0.15551 / _TEETH + 0.25791 / (_STARTS * _TEETH)) * _FACE_WIDTH
    bodies = (
        (*_cylinder(0.350, 0.004, screw), screw, screw_roller * share),
        (*_cylinder(0.006, nut, nut + 0.004), nut, gear),
        (*_cylinder(0.080, nut, nut + 0.010), nut, nut_roller * share),
    )
    found: list[float] = []
    for (mass, inertia, radius, mesh), supports in zip(bodies, _SUPPORTS, strict=True):
        found += [mass, inertia / radius**2, mesh, *supports]
    mass, inertia = _cylinder(0.050, 0.0, flanks.roller)
    _, carrier = _cylinder(0.004, centre - 0.003, centre + 0.003)
    found += [inertia / flanks.roller**2, 2 * carrier / centre**2 + _ROLLERS * mass]
    return np.array([*found, _CARRIER_SUPPORT])


def _frequencies(system: np.ndarray) -> np.ndarray:
    """All N + 10 natural frequencies, ascending [Hz]; only the matrices are NumPy's."""
    stiffness = np.tensordot(system, _STIFFNESS, axes=1)
    inertia = np.zeros_like(stiffness)
    inertia[_PLACES, _PLACES] = system @ _MASS
    values = eigh(
        stiffness,
        inertia,
        eigvals_only=True,
        overwrite_a=True,
        overwrite_b=True,
        check_finite=False,
    )
    return np.sqrt(np.maximum(values, 0.0)) / (2 * pi)


def design(lead: float, contact_angle: float, roller: float) -> tuple[np.ndarray, float, float]:
    """Natural frequencies [Hz], efficiency, and largest Hertz pressure [Pa] of one design.

    **Arguments:** SI units; the other numbers are those of the actuator.
    """
    flanks = flanks_of(lead, contact_angle, roller, _STARTS)
    x, y = contact_point(flanks)
    axial = _LOAD / (_ROLLERS * _THREADS)
    pressures, stiffnesses = [], []
    for gap in _gaps(flanks, x, y):
        pressure, approach = _hertz(axial * gap.factor, gap)
        pressures.append(pressure)
        stiffnesses.append(_THREADS * axial / gap.factor / approach)
    system = _system(flanks, stiffnesses[0], stiffnesses[1])
    return _frequencies(system), _efficiency(flanks, x, y), max(pressures)
