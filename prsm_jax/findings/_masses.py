"""Findings on given masses and moments of inertia: can a body of these dimensions have them?"""

from collections.abc import Iterator
from typing import Any

import equinox as eqx

from .._errors import MissingDataError
from ..fields import Scalar, as_scalar
from ..geometry import Finding
from ..mechanism import Material, Mechanism, Stage, body_inertia, body_mass

#: Steel, where no density is given [kg/m³].
_STEEL_DENSITY = 7850.0
#: Limits of J/(m r²) with the nominal radius r. Screw and roller lie inside r: ½ if solid, up to
#: 1 with a bore, less with thinner journals. Nut and ring gear lie outside r, and the carrier is
#: centred on r. Beyond these limits a number is mistyped or in another unit.
_CYLINDER, _SLEEVE, _ANNULUS = (0.2, 1.0), (1.0, 10.0), (0.3, 3.0)
_SHAPES = {
    "screw": ("cylinder", _CYLINDER),
    "roller": ("cylinder", _CYLINDER),
    "nut": ("sleeve", _SLEEVE),
    "ring_gear": ("sleeve", _SLEEVE),
    "carrier": ("annulus", _ANNULUS),
}
#: J/(m r²) this close to 1 counts as m r²; printed numbers have three digits.
_THIN_RING = 0.02
#: Threads, journals and gears change the mass of the cylinder by less than this factor.
_MASS_RATIO = 2.0


def _nominal_radius(stage: Stage, body: str) -> float:
    thread = stage.thread
    radii: dict[str, Scalar] = {
        "screw": thread.screw_radius,
        "roller": thread.roller_radius,
        "nut": thread.nut_radius,
        "ring_gear": thread.nut_radius,
        "carrier": thread.centre_distance,
    }
    return float(radii[body])


def _label(body: str) -> str:
    return body.replace("_", " ")


def _changed(part: Any, **fields: Any) -> Any:
    """A part with some fields replaced, without the checks of its constructor."""
    return eqx.tree_at(
        lambda p: [getattr(p, name) for name in fields],
        part,
        list(fields.values()),
        is_leaf=lambda leaf: leaf is None,
    )


def _inertia_from_dimensions(stage: Stage, body: str) -> float | None:
    """½ m (R² + r²) for the given mass; `None` where a radius is missing."""
    part = _changed(getattr(stage, body), inertia=None, length=as_scalar(1.0))
    try:
        return float(body_inertia(_changed(stage, **{body: part}), body))
    except MissingDataError:
        return None


def _mass_from_dimensions(stage: Stage, body: str) -> tuple[float, float] | None:
    """Mass from dimensions and density, and the density; `None` where a dimension is missing."""
    part = getattr(stage, body)
    material = part.material or stage.material
    if material is None or material.density is None:
        material = Material(as_scalar(210e9), as_scalar(0.3), as_scalar(_STEEL_DENSITY))
    part = _changed(part, mass=None, material=material)
    try:
        mass = float(body_mass(_changed(stage, **{body: part}), body))
    except MissingDataError:
        return None
    assert material.density is not None
    return mass, float(material.density)


def _check_inertia(stage: Stage, body: str, number: int) -> Finding | None:
    part = getattr(stage, body)
    if part is None or part.mass is None or part.inertia is None:
        return None
    mass, inertia = float(part.mass), float(part.inertia)
    radius = _nominal_radius(stage, body)
    thin = mass * radius**2
    if thin <= 0:
        return None
    shape, (lower, upper) = _SHAPES[body]
    expected = _inertia_from_dimensions(stage, body)
    ratio = inertia / thin
    # A thin-walled tube or sleeve really has m r².
    may_be_thin = shape == "annulus" or (expected is not None and abs(expected / thin - 1) < 0.05)
    if abs(ratio - 1) < _THIN_RING:
        if may_be_thin:
            return None
        fault = "is m r², the value of a thin ring of the nominal radius"
    elif ratio > upper:
        fault = f"is {ratio:.3g} m r², more than any {shape} of this radius has"
        if shape == "sleeve":
            fault = (
                f"is {ratio:.3g} m r² with the nominal radius, which would need a very thick wall"
            )
    elif ratio < lower:
        fault = (
            f"is {ratio:.3g} m r² with the nominal radius, less than any {shape} of this radius has"
        )
    else:
        return None
    if expected is not None:
        plausible = f"½ m (R² + r²) = {expected:.4g} kg·m²"
    else:
        plausible = f"more than m r² = {thin:.4g} kg·m², depending on its wall"
    return Finding(
        "inertia",
        "warning",
        number,
        inertia,
        thin if expected is None else expected,
        f"the moment of inertia of the {_label(body)}, {inertia:.4g} kg·m², {fault}; a {shape} of "
        f"{mass:.4g} kg and {1e3 * radius:.4g} mm nominal radius has {plausible}: correct "
        f"inertia, or remove it and give {_dimensions(body)}",
    )


def _dimensions(body: str) -> str:
    more = {"nut": "wall_thickness", "ring_gear": "wall_thickness", "carrier": "radial_width"}
    names = ["length", *([more[body]] if body in more else [])]
    return " and ".join(f"stage.{body}.{name}" for name in names)


def _check_mass(stage: Stage, body: str, number: int) -> Finding | None:
    part = getattr(stage, body)
    if part is None or part.mass is None:
        return None
    derived = _mass_from_dimensions(stage, body)
    if derived is None or derived[0] <= 0:
        return None
    mass, (expected, density) = float(part.mass), derived
    if 1 / _MASS_RATIO <= mass / expected <= _MASS_RATIO:
        return None
    return Finding(
        "mass",
        "warning",
        number,
        mass,
        expected,
        f"the mass of the {_label(body)}, {mass:.4g} kg, is {mass / expected:.3g} times the "
        f"mass from its dimensions, {expected:.4g} kg with {1e3 * float(part.length):.4g} mm "
        f"length and {density:.0f} kg/m³: correct one of them, or remove mass to have it derived",
    )


def _of_stage(stage: Stage, number: int) -> Iterator[Finding]:
    for body in _SHAPES:
        for check in (_check_mass, _check_inertia):
            finding = check(stage, body, number)
            if finding is not None:
                yield finding


def mass_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Given masses and inertias that are implausible for the given dimensions.

    `inertia`: m r² for a body that is not a thin ring, more than a cylinder of that radius can
    have, or far too little. `mass`: implausible for length, radius and density (7850 kg/m³ if not
    given), where the length is given.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    """
    return tuple(
        finding
        for number, stage in enumerate(mechanism.stages, start=1)
        for finding in _of_stage(stage, number)
    )
