"""Findings on given masses and moments of inertia: can a body of these dimensions have them?"""

import contextlib
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

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


def _nominal_radius(stage: Stage, body: str) -> Scalar:
    thread = stage.thread
    radii: dict[str, Scalar] = {
        "screw": thread.screw_radius,
        "roller": thread.roller_radius,
        "nut": thread.nut_radius,
        "ring_gear": thread.nut_radius,
        "carrier": thread.centre_distance,
    }
    return radii[body]


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


class Expected(NamedTuple):
    """Numbers of a body from its dimensions; `None` where a dimension is missing."""

    #: Nominal radius [m].
    radius: Scalar
    #: ½ m (R² + r²) with the given mass [kg·m²].
    inertia: Scalar | None
    #: π ρ l (R² − r²) [kg], and the density used [kg/m³].
    mass: Scalar | None
    density: Scalar


#: Of a stage: by body, where mass is given.
ExpectedMasses = dict[str, Expected]


def _from_dimensions(stage: Stage, body: str) -> Expected:
    given = getattr(stage, body)
    material = given.material or stage.material
    if material is None or material.density is None:
        material = Material(as_scalar(210e9), as_scalar(0.3), as_scalar(_STEEL_DENSITY))
    assert material.density is not None
    inertia = mass = None
    with contextlib.suppress(MissingDataError):
        part = _changed(given, inertia=None, length=as_scalar(1.0))
        inertia = body_inertia(_changed(stage, **{body: part}), body)
    with contextlib.suppress(MissingDataError):
        part = _changed(given, mass=None, material=material)
        mass = body_mass(_changed(stage, **{body: part}), body)
    return Expected(_nominal_radius(stage, body), inertia, mass, material.density)


def expected_masses(mechanism: Mechanism) -> list[ExpectedMasses]:
    """Masses and moments of inertia from dimensions, for each stage; can be compiled."""
    return [
        {
            body: _from_dimensions(stage, body)
            for body in _SHAPES
            if (part := getattr(stage, body)) is not None and part.mass is not None
        }
        for stage in mechanism.stages
    ]


def _check_inertia(
    stage: Stage, body: str, number: int, from_dimensions: Expected
) -> Finding | None:
    part = getattr(stage, body)
    if part.inertia is None:
        return None
    mass, inertia = float(part.mass), float(part.inertia)
    radius = float(from_dimensions.radius)
    thin = mass * radius**2
    if thin <= 0:
        return None
    shape, (lower, upper) = _SHAPES[body]
    expected = None if from_dimensions.inertia is None else float(from_dimensions.inertia)
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


def _check_mass(stage: Stage, body: str, number: int, from_dimensions: Expected) -> Finding | None:
    if from_dimensions.mass is None or from_dimensions.mass <= 0:
        return None
    part = getattr(stage, body)
    mass, expected = float(part.mass), float(from_dimensions.mass)
    density = float(from_dimensions.density)
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


def _of_stage(stage: Stage, number: int, masses: ExpectedMasses) -> Iterator[Finding]:
    for body, expected in masses.items():
        for check in (_check_mass, _check_inertia):
            finding = check(stage, body, number, expected)
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
    return mass_findings_from(mechanism, expected_masses(mechanism))


def mass_findings_from(
    mechanism: Mechanism, masses: Sequence[ExpectedMasses]
) -> tuple[Finding, ...]:
    """As `mass_findings`, from `expected_masses` that are already computed."""
    return tuple(
        finding
        for number, (stage, of_stage) in enumerate(
            zip(mechanism.stages, masses, strict=True), start=1
        )
        for finding in _of_stage(stage, number, of_stage)
    )
