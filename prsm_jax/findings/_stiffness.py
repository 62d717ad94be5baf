"""Findings on given stiffnesses: negative springs, and a torsional support unlike a shaft."""

import math
from collections.abc import Iterator

import numpy as np

from .._errors import MissingDataError
from ..contact import load_of
from ..fields import Scalar
from ..geometry import Finding
from ..mechanism import Mechanism, Stage
from ..quantities import Analysis
from ..stiffness import stiffness_under_load
from ..vibration import dense_matrices, vibration_system
from ._margin import Margin, Reading, margin_source

#: Shortest and longest free length of a screw of unknown length, in diameters.
_SHORTEST, _LONGEST = 1.0, 30.0
#: Couplings and bearings in series, and journals, change the stiffness by less than this factor.
_SLACK = 3.0
#: Steel, where no material is given: Young's modulus [Pa] and Poisson's ratio.
_STEEL = (210e9, 0.3)


def _given_springs(stage: Stage) -> Iterator[tuple[str, Scalar, str]]:
    """Every stiffness that a user gives: its name in the file, value and unit."""
    for body in ("screw", "roller", "nut", "ring_gear", "carrier"):
        part = getattr(stage, body)
        support = None if part is None else part.support
        for name in ("radial_stiffness", "radial_stiffness_y", "torsional_stiffness"):
            value = None if support is None else getattr(support, name)
            if value is not None:
                yield f"stage.{body}.support.{name}", value, " N/m"
    for name in ("screw_roller", "nut_roller", "ring_roller"):
        value = None if stage.stiffness is None else getattr(stage.stiffness, name)
        if value is not None:
            yield f"stage.stiffness.{name}", value, " N/m"
    if stage.gear is not None:
        yield "stage.gear.mesh_factor", stage.gear.mesh_factor, ""
    for roller in stage.unequal_roller:
        if roller.stiffness_factor is not None:
            name = f"stage.unequal_roller.stiffness_factor of roller {roller.number}"
            yield name, roller.stiffness_factor, ""


def _negative_eigenvalues(mechanism: Mechanism, stage: Stage) -> int | None:
    """Number of negative eigenvalues of the stiffness matrix; `None` where data are missing."""
    try:
        threads = stiffness_under_load(stage, lambda: load_of(mechanism, None))
        matrix = np.asarray(dense_matrices(vibration_system(stage, threads))[0])
    except (MissingDataError, ValueError):
        return None
    if not np.all(np.isfinite(matrix)):
        return None
    values = np.linalg.eigvalsh(matrix)
    # Free bodies have zero eigenvalues; rounding makes them slightly positive or negative.
    return int(np.sum(values < -1e-12 * np.abs(values).max()))


@margin_source
def _signs(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """Negative springs, and their effect on the stiffness matrix."""
    for place, (name, _, unit) in enumerate(_given_springs(mechanism.stages[index])):

        def value(analysis: Analysis, place=place) -> Scalar:
            return list(_given_springs(analysis.mechanism.stages[index]))[place][1]

        def message(r: Reading, name=name, unit=unit) -> str:
            count = _negative_eigenvalues(r.mechanism, r.mechanism.stages[index])
            if count is None:
                effect = "the stiffness matrix can be indefinite"
            elif count == 0:
                effect = "the other springs still outweigh it"
            else:
                effect = (
                    f"the stiffness matrix is indefinite ({count} negative "
                    f"eigenvalue{'s' if count > 1 else ''}) and the mechanism unstable"
                )
            return (
                f"{name} is {r.value:.4g}{unit}, a negative stiffness: {effect}; make it 0 or more"
            )

        yield Margin(
            "negative_stiffness",
            index + 1,
            value,
            (("error", 0.0),),
            message,
            unit=unit.strip() or "1",
            kind="existence",
            reserve=0.0,
            subject=name,
        )


def _shear_modulus(stage: Stage) -> float:
    material = stage.screw.material or stage.material
    modulus, ratio = _STEEL
    if material is not None:
        modulus, ratio = float(material.youngs_modulus), float(material.poisson_ratio)
    return modulus / (2 * (1 + ratio))


def _check_shaft(stage: Stage, number: int) -> Finding | None:
    """G I_p/(l r²) of the screw against its given torsional support [N/m on u = r θ]."""
    screw, radius = stage.screw, float(stage.thread.screw_radius)
    if screw.support is None or screw.support.torsional_stiffness is None:
        return None
    stiffness = float(screw.support.torsional_stiffness)
    bore = 0.0 if screw.bore_radius is None else float(screw.bore_radius)
    if stiffness <= 0 or not 0 <= bore < radius:
        return None
    polar = math.pi / 2 * (radius**4 - bore**4)
    shortest = 2 * radius * _SHORTEST
    longest = 2 * radius * _LONGEST
    if screw.length is not None:
        longest = float(screw.length)
        shortest = min(shortest, longest)
    per_length = _shear_modulus(stage) * polar / radius**2
    soft, stiff = per_length / longest, per_length / shortest
    if soft / _SLACK <= stiffness <= stiff * _SLACK:
        return None
    below = stiffness < soft
    factor = soft / stiffness if below else stiffness / stiff
    converted = {"N·m/rad": stiffness / radius**2, "N/mm": stiffness * 1e3}
    readings = [
        f"{unit} ({value:.3g} N/m)"
        for unit, value in converted.items()
        if soft / _SLACK <= value <= stiff * _SLACK
    ]
    hint = f"; read in {' or '.join(readings)} it would be plausible" if readings else ""
    return Finding(
        "torsional_support",
        "warning",
        number,
        stiffness,
        soft if below else stiff,
        f"stage.screw.support.torsional_stiffness is {stiffness:.4g} N/m on u = r θ, {factor:.3g} "
        f"times {'softer' if below else 'stiffer'} than a shaft of {2e3 * radius:.4g} mm diameter "
        f"and {1e3 * (longest if below else shortest):.4g} mm length, G I_p/(l r²) = "
        f"{soft if below else stiff:.3g} N/m: correct it or its unit{hint}",
    )


def shaft_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """`torsional_support`: that of the screw is implausible for a shaft of its dimensions.

    Compared with G I_p/(l r²) for lengths from one diameter to the given length (30 diameters if
    none is given).

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    """
    findings = (
        _check_shaft(stage, number) for number, stage in enumerate(mechanism.stages, start=1)
    )
    return tuple(finding for finding in findings if finding is not None)
