"""Contact shape function paper: what closed forms can check of its line contact."""

from collections.abc import Iterator

import numpy as np

from ..contact import contact_modulus
from ..mechanism import material_of
from ._examples import example
from ._registry import rows_of
from ._row import Row, differs, misprint, number

_CITATION = (
    "Research on Contact Shape Function and Contact Model of Planetary Roller Screw Drive Pair "
    "(rollers of rings, line contact)"
)
#: Table 2: largest pressure [N/mm²] and half width [mm].
_PRESSURE, _HALF_WIDTH = 229.9, 0.059


@rows_of("shape_function", _CITATION)
def line_contact() -> Iterator[Row]:
    """Table 2 against the closures of a Hertz line contact, in mm and N."""
    stage = example("ring_roller").stages[0]
    contact = stage.line_contact
    assert contact is not None
    steel = material_of(stage, "screw")
    modulus = float(contact_modulus(steel, steel)) / 1e6
    per_length = np.pi / 2 * _PRESSURE * _HALF_WIDTH
    curvature = _PRESSURE / (_HALF_WIDTH * modulus)
    depth = 2 * per_length / (np.pi * modulus)
    given = (
        f"the printed pressure and half width imply a line load of {per_length:.1f} N/mm "
        "(p₀ = 2P/πB) and, for steel (E 210 GPa, ν 0.3, an assumption), cos ψ cos k a = "
        f"{curvature:.4f} /mm"
    )
    yield number(
        "Table 2: largest depth of contact",
        "0.00011",
        depth,
        "mm",
        tolerance=1e-5,
        note=f"by δ = 2P/(πE*); {given}. One unit of the last digit is allowed: the printed "
        "number seems cut off rather than rounded",
    )
    yield differs(
        "the closure δ = πP/E* against Table 2",
        "0.00011",
        np.pi * per_length / modulus,
        "mm",
        because="a B² with the B before it is 2P/(πE*), so the second equality is wrong by π²/2; "
        "it contradicts the table as well",
    )
    yield differs(
        "the closure P = (2E*/π) δ against the line load in Table 2's pressure",
        f"{per_length:.1f}",
        2 * modulus / np.pi * 1.1e-4,
        "N/mm",
        because="with the printed depth; P = (πE*/2) δ gives "
        f"{np.pi * modulus / 2 * 1.1e-4:.1f} N/mm",
    )
    for item, printed, model, reference in (
        ("largest depth of contact", "-8.3", 0.00011, 0.00012),
        ("half width", "-4.8", _HALF_WIDTH, 0.062),
        ("largest pressure", "-2.5", _PRESSURE, 235.7),
    ):
        yield number(
            f"Table 2: deviation of the model from finite elements, {item}",
            printed,
            100 * (model / reference - 1),
            "%",
            note="from the two printed numbers",
        )
    for item, printed, value, unit in (
        ("depth of contact", "0.00012", depth, "mm"),
        ("half width", "0.062", _HALF_WIDTH, "mm"),
        ("pressure", "235.7", _PRESSURE, "MPa"),
    ):
        yield differs(
            f"Table 2: finite elements, {item}",
            printed,
            value,
            unit,
            because="computed is the analytic model's; the element size and contact stiffness are "
            "not given",
        )


@rows_of("shape_function")
def geometry() -> Iterator[Row]:
    """Table 1, and the coefficient of the shape function."""
    stage = example("ring_roller").stages[0]
    contact = stage.line_contact
    assert contact is not None
    assert contact.lead_angle is not None
    distance = 1e3 * float(contact.centre_distance)
    screw, roller = (
        1e3 * float(contact.screw_major_radius),
        1e3 * float(contact.roller_major_radius),
    )
    overlap = screw + roller - distance
    yield misprint(
        "Table 1: radial width of the contact zone, g3 − g1, if 8 to 12 mm are diameters",
        "1",
        overlap,
        "mm",
        correct="2",
        note=f"as diameters the bodies would be {distance - (screw + roller) / 2:.0f} mm apart; as "
        f"radii they overlap by s3 + g3 − d = {overlap:.0f} mm, exactly the zone from g1 to g3",
    )
    material = material_of(stage, "screw")
    modulus = float(contact_modulus(material, material)) / 1e6
    middle = 1e3 * float(contact.roller_minor_radius + contact.roller_major_radius) / 2
    slope = np.tan(float(contact.screw_profile_angle))
    coefficient = slope * distance / (2 * middle * (distance - middle))
    projected = coefficient * np.cos(float(contact.lead_angle))
    projected = projected * np.cos(float(contact.roller_profile_angle))
    implied = _PRESSURE / (_HALF_WIDTH * modulus)
    yield differs(
        "coefficient cos ψ cos k a that Table 2 implies",
        f"{implied:.4f}",
        projected,
        "1/mm",
        because="Table 1's geometry by a = tan j d/(2r(d − r)) at the middle radius (ψ 5°, an "
        "assumption: Table 1 leaves it empty). No radius or lead angle in range reaches the "
        "implied value; a softer material would (none is given)",
    )
    printed = np.sin(2 * float(contact.lead_angle)) ** 2 / (8 * (distance - middle))
    printed = printed + 1 / (24 * middle * (distance - middle)) + slope / 2
    yield differs(
        "printed coefficient a at the middle radius, in mm",
        f"{printed:.4f}",
        coefficient,
        "1/mm",
        because="its last term, tan j/2, has no dimension, so the sum depends on the unit of "
        "length; second-order expansion of the gap gives the value beside",
    )
    largest = np.pi / 2 * _PRESSURE * _HALF_WIDTH * overlap
    yield differs(
        "load on one flank",
        "55",
        largest,
        "N",
        because="the largest line load that Table 2 implies, over the whole zone of "
        f"{overlap:.0f} mm, is an upper bound: the table's load and pressure do not belong "
        "together",
    )
