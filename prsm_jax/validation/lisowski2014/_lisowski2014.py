"""Lisowski 2014: Hertz pressures of one pair of threads, compared with finite elements."""

from collections.abc import Iterator

import jax
import jax.numpy as jnp
import numpy as np

from ...contact import (
    axis_ratio_of,
    complete_elliptic_integrals,
    contact_modulus,
    hertz_contact,
    lisowski_coefficients,
)
from ...fields import as_scalar
from ...mechanism import CurvatureConvention, material_of
from .._difference import consistent, differs, formula, inconsistent, unexplained
from .._examples import example, given
from .._registry import rows_of
from .._row import Row, misprint, number
from .._thread_contacts import LOADS, pairs_of_threads

HERTZ = {"screw": ("999", "1259", "1585"), "nut": ("969", "1221", "1585")}
ELEMENTS = {"screw": ("608", "1480", "1586"), "nut": (None, "879", "1531")}
_ERRORS = {"screw": ("39.1", "17.6", "0.1"), "nut": (None, "28.0", "0.5")}
_DISPLACEMENTS = {"screw": ("0.00654", "0.01306", "0.02616"), "nut": (None, "0.01519", "0.03064")}
TABLES = {"screw": "Table 1", "nut": "Table 2"}
#: Relative error of pressures that are computed with three-digit tables of Hertz coefficients.
_COEFFICIENT_ERROR = 0.002
#: Expected values of the rows below: pressures with the flanks' curvatures and with those of
#: equations 1 to 3 [MPa], and axial approaches with the latter [mm].
BY_FLANKS = {"screw": (1350.9, 1702.0, 2144.4), "nut": (1138.1, 1434.0, 1806.7)}
_BY_THEIR_RADII = {"screw": (1000.2, 1260.2, 1587.8), "nut": (969.9, 1221.9, 1539.6)}
_APPROACHES = {
    "screw": (2.4488e-3, 3.8873e-3, 6.1707e-3),
    "nut": (2.4193e-3, 3.8405e-3, 6.0964e-3),
}
#: The printed 1585 MPa is the screw side's; see the rows of Table 2.
CORRECTED = {("nut", 100.0): "1540"}
_CITATION = (
    "F. Lisowski, Numerical computation of stresses and deformations in the planetary roller "
    "screw components, Cracow University of Technology 2014"
)


def _pressure(convention: CurvatureConvention, side: str) -> np.ndarray:
    """Largest pressures at the three loads [MPa]."""
    return pairs_of_threads("lisowski2014")[convention][side].pressure / 1e6


@rows_of("lisowski2014", _CITATION)
def hertz_pressures() -> Iterator[Row]:
    """Tables 1 and 2, analytic columns."""
    for side, pressures in HERTZ.items():
        for index, (load, printed) in enumerate(zip(LOADS, pressures, strict=True)):
            computed = float(_pressure("lisowski2014", side)[index])
            true = float(_pressure("exact", side)[index])
            item = f"{TABLES[side]}: Hertz pressure on the {side} side, {load:.0f} N"
            note = (
                "curvatures of equations 1 to 3 (nut concave), φ = 0; the paper interpolates the "
                "Hertz coefficients, so 0.2 % is allowed; with the curvatures of the flanks it is "
                f"{true:.1f} MPa"
            )
            if side == "nut" and load == 100.0:
                yield misprint(
                    item,
                    printed,
                    computed,
                    "MPa",
                    # Three digits, because the table's other entries are 0.1 % low.
                    correct="1.54e3",
                    note=f"{printed} is the screw's value; 969 and 1221 MPa grow with the cube "
                    f"root of the load to {969 * 4 ** (1 / 3):.0f} and {1221 * 2 ** (1 / 3):.0f} "
                    "MPa, and the printed 0.5 % to the finite elements' 1531 MPa requires "
                    f"{1531 / 0.9955:.0f} to {1531 / 0.9945:.0f}; with the curvatures of the "
                    f"flanks it is {true:.1f} MPa",
                )
            else:
                tolerance = _COEFFICIENT_ERROR * float(printed)
                yield number(item, printed, computed, "MPa", tolerance=tolerance, note=note)


@rows_of("lisowski2014")
def flank_curvatures() -> Iterator[Row]:
    """Tables 1 and 2 in the other convention: the curvatures that the flanks have."""
    for side, pressures in HERTZ.items():
        for index, (load, printed) in enumerate(zip(LOADS, pressures, strict=True)):
            theirs = float(_pressure("lisowski2014", side)[index])
            ratio = float(_pressure("exact", side)[index]) / theirs
            expected, correct = BY_FLANKS[side][index], float(CORRECTED.get((side, load), printed))
            allowed = _COEFFICIENT_ERROR * correct
            yield differs(
                f"{TABLES[side]}: Hertz pressure with the curvatures of the flanks, {side} side, "
                f"{load:.0f} N",
                printed,
                float(_pressure("exact", side)[index]),
                "MPa",
                between=(expected - 1.0, expected + 1.0),
                evidence=theirs,
                evidence_between=(correct - allowed, correct + allowed),
                because="equations 1 to 3 take ((d/2)² + p²)/p, the inverse torsion of a helix "
                "with the lead 2πp, as the radius of the flank in the rolling direction; the "
                f"flank's own radius, about d/(2 sin α₀), is smaller, and the pressure {ratio:.2f} "
                "times as high at every load. The evidence is the pressure with their radii; it "
                f"must be the printed one ({correct:.0f} MPa) within 0.2 %",
            )


@rows_of("lisowski2014")
def finite_elements() -> Iterator[Row]:
    """Tables 1 and 2, finite elements, and their printed deviations; Table 3."""
    for side, pressures in ELEMENTS.items():
        for index, (load, printed) in enumerate(zip(LOADS, pressures, strict=True)):
            if printed is None:
                continue
            contact = _pressure("lisowski2014", side)
            item = f"{TABLES[side]}: finite elements on the {side} side, {load:.0f} N"
            previous = pressures[0] if side == "screw" else pressures[1]
            growth = float(given(pressures[-1])) / float(given(previous))
            start = LOADS[0] if side == "screw" else LOADS[1]
            expected = _BY_THEIR_RADII[side][index]
            yield unexplained(
                item,
                printed,
                float(contact[index]),
                "MPa",
                between=(expected - 1.0, expected + 1.0),
                note=f"from {start:.0f} to 100 N the elements' pressure grows {growth:.2f} "
                f"times, against {(100.0 / start) ** (1 / 3):.2f} for any Hertz contact, "
                "whose pressure is proportional to the cube root of the load. The size of the "
                "elements does not explain it, see section 4 below",
            )
            error = given(_ERRORS[side][index])
            hertz = float(HERTZ[side][index])
            deviation = 100 * abs(float(printed) / hertz - 1)
            item = f"{TABLES[side]}: deviation of the finite elements, {side} side, {load:.0f} N"
            if side == "nut" and load == 100.0:
                yield number(
                    item,
                    error,
                    100 * abs(float(printed) / float(contact[index]) - 1),
                    "%",
                    tolerance=0.1,
                    note=f"from the computed pressure; the printed 1585 MPa would give "
                    f"{deviation:.1f} %, so 0.5 % belongs to about {1531 / 0.995:.0f} MPa and "
                    "confirms the misprint",
                )
            else:
                yield consistent(item, error, deviation, "%", note="from the two printed pressures")
    contacts = pairs_of_threads("lisowski2014")["lisowski2014"]
    flanks = pairs_of_threads("lisowski2014")["exact"]
    for side, displacements in _DISPLACEMENTS.items():
        for load, displacement in zip(LOADS, displacements, strict=True):
            if displacement is None:
                continue
            index = LOADS.index(load)
            by_flanks = 1e3 * load / float(flanks[side].axial_stiffness[index])
            low, high, rest = _hertz_and_springs(side)
            expected = _APPROACHES[side][index]
            yield unexplained(
                f"Table 3: axial displacement by finite elements, {side} side, {load:.0f} N",
                displacement,
                1e3 * load / float(contacts[side].axial_stiffness[index]),
                "mm",
                between=(0.999 * expected, 1.001 * expected),
                note="the computed number is the Hertz approach of the two flanks in axial "
                f"direction ({by_flanks:.5f} mm with the curvatures of the flanks); the elements "
                "add the elastic bodies between the contact and the supports of the model. But a "
                f"Hertz approach and a linear spring ({low:.3f} to {high:.3f} µm/N from each "
                f"printed displacement) leave {100 * rest:.0f} % of them unexplained: they are "
                "proportional to the load, as if the contact did not grow",
            )
    for load, printed in ((50.0, "1.16"), (100.0, "1.17")):
        nut, screw = (given(_DISPLACEMENTS[side][LOADS.index(load)]) for side in ("nut", "screw"))
        yield consistent(
            f"Table 3: displacement factor, {load:.0f} N",
            printed,
            float(nut) / float(screw),
            note="from the two printed displacements",
        )
    approach = {side: np.array(LOADS) / contacts[side].axial_stiffness for side in HERTZ}
    screw = 1e3 * approach["screw"]
    for index, load, printed in ((1, 50.0, "1.16"), (2, 100.0, "1.17")):
        yield unexplained(
            f"Table 3: axial displacement, nut over screw, {load:.0f} N",
            printed,
            float(approach["nut"][index] / approach["screw"][index]),
            between=(0.9875, 0.9885),
            note="the finite elements' displacements double with the load (0.00654, 0.01306, "
            "0.02616 mm), as those of elastic bodies do; the Hertz approach grows with "
            f"its 2/3 power ({screw[0]:.5f}, {screw[1]:.5f}, {screw[2]:.5f} mm on the screw side)",
        )


def _hertz_and_springs(side: str) -> tuple[float, float, float]:
    """Least and largest compliance [µm/N] of a linear spring in series with the Hertz approach.

    The spring accounts for the rest of the displacement at each load. The third number is the
    difference between the two, as a share of the largest displacement over its load.
    """
    contact = pairs_of_threads("lisowski2014")["lisowski2014"][side]
    compliances = [
        (load, float(printed) / load - 1e3 / float(contact.axial_stiffness[index]))
        for index, (load, printed) in enumerate(zip(LOADS, _DISPLACEMENTS[side], strict=True))
        if printed is not None
    ]
    springs = [1e3 * spring for _, spring in compliances]
    last = float(_DISPLACEMENTS[side][-1] or 0) / LOADS[-1] * 1e3
    return min(springs), max(springs), (max(springs) - min(springs)) / last


def _exact_coefficients(angle: float) -> tuple[float, float]:
    """Hertz coefficients m_H and n_H at the auxiliary angle θ [rad]."""
    ratio = axis_ratio_of(jnp.asarray(np.cos(angle)))
    _, second = complete_elliptic_integrals(ratio)
    major = float(jnp.cbrt(2 * second / (jnp.pi * ratio**2)))
    return major, major * float(ratio)


def fitted_coefficients(angle: float) -> tuple[float, float]:
    """m_H and n_H by equations 8 and 9, the leading coefficient of the first corrected."""
    major, minor = lisowski_coefficients(jnp.asarray(angle))
    return float(major), float(minor)


@rows_of("lisowski2014")
def coefficients() -> Iterator[Row]:
    """Equations 7 to 9."""
    right = np.pi / 2
    corrected = 1 / fitted_coefficients(right)[0]
    others = corrected + 0.072576 * right**4
    negative = others - 0.72576 * right**4
    angles = np.radians(np.linspace(15.0, 90.0, 76))
    ratio = axis_ratio_of(jnp.asarray(np.cos(angles)))
    _, second = complete_elliptic_integrals(ratio)
    exact = np.asarray(jnp.cbrt(2 * second / (jnp.pi * ratio**2)))
    fitted = np.asarray(jax.vmap(lisowski_coefficients)(jnp.asarray(angles))[0])
    worst = float(np.max(np.abs(fitted / exact - 1)))
    minor = np.asarray(jax.vmap(lisowski_coefficients)(jnp.asarray(angles))[1])
    least = float(np.max(np.abs(minor / (exact * np.asarray(ratio)) - 1)))
    yield misprint(
        "equation 8: leading coefficient",
        "-0.72576",
        (1 - others) / right**4,
        correct="-0.072",
        note=f"a circle (90°) has m_H = 1; as printed, the formula gives 1/m_H = {negative:.3f}. "
        f"With −0.072576 it is within {100 * worst:.1f} % over 15° to 90°",
    )
    for degrees in (1.0, 45.0, 68.25, 90.0):
        angle = float(np.radians(degrees))
        for name, fit, true in zip(
            ("equation 8 (corrected): m_H", "equation 9: n_H"),
            fitted_coefficients(angle),
            _exact_coefficients(angle),
            strict=True,
        ):
            item = f"{name} at {degrees:g}°"
            if degrees < 15.0:
                within = 100 * (worst if name.endswith("m_H") else least)
                expected = 36.93 if name.endswith("m_H") else 0.1313
                yield differs(
                    item,
                    f"{fit:.5g}",
                    true,
                    between=(0.999 * expected, 1.001 * expected),
                    evidence=within,
                    evidence_between=(0.5, 0.7) if name.endswith("m_H") else (1.2, 1.3),
                    because="the polynomial fit fails for slender ellipses, below about 15°: from "
                    "15° to 90° its error is the percentage in evidence, and at 0°, where m_H "
                    "grows without limit and n_H vanishes, it ends at "
                    f"{fitted_coefficients(0.0)[0]:.4g} and {fitted_coefficients(0.0)[1]:.4g}",
                )
            else:
                yield formula(
                    item,
                    f"{fit:.5g}",
                    true,
                    tolerance=0.006 * fit,
                    note="the formula's value; its error here is at most 0.6 %",
                )
    first, second = _curvatures("screw")
    yield inconsistent(
        "equation 7: sign of the difference of A and B",
        "A - B = root of squares, so at least 0",
        -abs(first - second) / 2,
        "1/m",
        between=(-40.7, -40.5),
        note="with A ≤ B, as equation 6 and the tables of coefficients need, the root is B − A; "
        "the computed number is A − B by equations 1, 2 and 6 on the screw side",
    )


def _curvatures(side: str, sign: float = -1.0) -> tuple[float, float]:
    """Summed curvatures of equations 1 to 3 in the two principal planes [1/m].

    **Arguments:**

    - `side`: `"screw"` or `"nut"`.
    - `sign`: of the nut's radius.
    """
    thread = example("lisowski2014").stages[0].thread
    pitch = float(thread.pitch)

    def helix(radius) -> float:
        return pitch / (float(radius) ** 2 + pitch**2)

    profile = float(jnp.sin(thread.flank_angle) / thread.roller_radius)
    other = helix(thread.screw_radius) if side == "screw" else sign * helix(thread.nut_radius)
    return profile + other, helix(thread.roller_radius)


def _nut_pressure(sign: float) -> float:
    """Hertz pressure on the nut side at 25 N, its radius positive or negative [MPa]."""
    stage = example("lisowski2014").stages[0]
    first, second = _curvatures("nut", sign)
    material = material_of(stage, "nut")
    contact = hertz_contact(
        LOADS[0] / jnp.cos(stage.thread.flank_angle),
        as_scalar((first + second) / 2),
        as_scalar(((first - second) / 2) ** 2),
        contact_modulus(material, material),
    )
    return float(contact.max_pressure) / 1e6


@rows_of("lisowski2014")
def nut_curvature() -> Iterator[Row]:
    """Equation 3."""
    pressures = [_nut_pressure(sign) for sign in (1.0, -1.0)]
    allowed = _COEFFICIENT_ERROR * 969
    yield differs(
        "equation 3: pressure of the nut at 25 N with its curvature radius as printed, positive",
        "969",
        pressures[0],
        "MPa",
        between=(985.7, 986.7),
        evidence=pressures[1],
        evidence_between=(969 - allowed, 969 + allowed),
        because="the nut's thread is concave; only the negative radius gives the pressure of Table "
        "2, the evidence",
    )
