"""Wu et al. 2022: dimensions and parameters, Tables 3 and 4."""

import dataclasses
from collections.abc import Iterator

import numpy as np

from ...mechanism import body_inertia
from ...stiffness import gear_mesh_stiffness
from .._difference import differs, fault, inconsistent, not_comparable, unexplained
from .._examples import example, given
from .._registry import rows_of
from .._row import Row, misprint, number
from .._thread_contacts import LOADS, pairs_of_threads
from ._cylinders import sleeve_radius, solid_length

#: Axial force on one thread at which contact stiffnesses are quoted [N].
_THREAD_LOAD = LOADS[-1]
#: Threads of one roller in the stiffnesses that are compared with the published ones.
_THREADS = 16
#: Tolerance of an identity: rounding only.
_EXACT = 1e-9
_CITATION = "L. Wu, S. Ma, P. Deng, Q. Huang, Electronics 11 (2022) 1395"


@rows_of("wu2022", _CITATION)
def dimensions() -> Iterator[Row]:
    """Table 3."""
    stage = example("wu2022").stages[0]
    thread, gear = stage.thread, given(stage.gear)
    roller = 2e3 * float(thread.roller_radius)
    screw, nut = 2e3 * float(thread.screw_radius), 2e3 * float(thread.nut_radius)
    identity = "exactly, from the roller's 8 mm and 5 starts by r_n = r_s + 2 r_R = n r_R"
    for name, printed, diameter in (("screw", "24", screw), ("nut", "40", nut)):
        item = f"Table 3: nominal diameter of the {name}"
        yield number(item, printed, diameter, "mm", tolerance=_EXACT, note=identity)
    screw_angle, angle = (
        np.degrees(float(value)) for value in (thread.screw_helix_angle, thread.roller_helix_angle)
    )
    yield number("Table 3: helix angle of the screw", "7.55", screw_angle, "°")
    yield number("Table 3: helix angle of roller and nut", "4.55", angle, "°")
    starts = np.pi * nut * np.tan(np.radians(4.55)) / 2
    yield misprint(
        "Table 3: number of starts of the nut",
        "1",
        starts,
        correct="5",
        note="from the printed helix angle 4.55°, pitch 2 mm and diameter 40 mm; one start would "
        "have 0.91°, and the roller would slip in the nut",
    )
    yield inconsistent(
        "Table 3: major diameter of the nut, and its minor diameter beside it",
        "39.26",
        41.05,
        "mm",
        between=(nut, 41.05),
        note="an internal thread has its crest inside, so major must exceed minor, and the nominal "
        f"{nut:.0f} mm lies between 39.26 (crest) and 41.05 mm (root): the labels are exchanged",
    )
    yield differs(
        "Table 3: radius of the roller's profile",
        "4.956",
        1e3 * float(thread.profile_radius),
        "mm",
        between=(5.6568, 5.6569),
        evidence=7 / 2 / np.sin(np.pi / 4),
        evidence_between=(4.94, 4.97),
        because="the arc of equation 36 is centred on the roller's axis, r_R/sin 45°; 4.956 mm is "
        f"the radius for a roller of {2 * 4.956 * np.sin(np.pi / 4):.2f} mm, not for one of "
        f"{roller:.0f} mm (the paper compares itself with one of 7 mm in section 4, whose r_R/sin "
        "45° is the evidence)",
    )
    module = roller / float(given(gear.roller_teeth))
    note = "exactly, 2 r_R/z"
    yield number("Table 3: module of the gears", "0.5", module, "mm", tolerance=_EXACT, note=note)
    teeth = float(given(gear.roller_teeth) * thread.starts)
    note = "exactly, n z"
    yield number("Table 3: teeth of the ring gear", "80", teeth, tolerance=_EXACT, note=note)


@rows_of("wu2022")
def masses() -> Iterator[Row]:
    """Table 4, inertias."""
    stage = example("wu2022").stages[0]
    thread = stage.thread
    # Steel sleeves outside the nominal radius: the nut as long as the roller's mass implies, the
    # ring gear as wide as its teeth.
    gear = given(stage.gear)
    length = solid_length(float(given(stage.roller.mass)), float(thread.roller_radius))
    widths = {"nut": length, "ring_gear": float(given(gear.face_width))}
    for name, body, radius, printed in (
        ("screw", "screw", thread.screw_radius, "1.822e-4"),
        ("roller", "roller", thread.roller_radius, "5.216e-7"),
        ("nut", "nut", thread.nut_radius, "8.636e-4"),
        ("ring gear", "ring_gear", thread.nut_radius, "4.48e-5"),
        ("carrier", "carrier", thread.centre_distance, "5.888e-6"),
    ):
        part = getattr(stage, body)
        ring = float(part.mass * radius**2)
        item = f"Table 4: moment of inertia of the {name}"
        note = "m r² with the nominal radius, the inertia of a thin ring"
        if body == "carrier":
            note += "; correct for a narrow annulus on the circle of the roller axes"
            yield number(item, printed, ring, "kg·m²", note=note)
            continue
        if body in ("screw", "roller"):
            solid = dataclasses.replace(part, inertia=None, length=1.0)
            own = float(body_inertia(dataclasses.replace(stage, **{body: solid}), body))
            note += f"; a solid cylinder of that mass has half of it, {own:.3e}"
        else:
            outer = sleeve_radius(float(part.mass), float(radius), widths[body])
            own = float(part.mass) * (outer**2 + float(radius) ** 2) / 2
            note += (
                f"; a sleeve of steel outside that radius, {1e3 * widths[body]:.1f} mm long and "
                f"{2e3 * outer:.1f} mm outside, has ½ m (R² + r²) = {own:.3e}"
            )
        yield fault(item, printed, ring, "kg·m²", own=own, note=note)


@rows_of("wu2022")
def stiffnesses() -> Iterator[Row]:
    """Table 4, thread contacts and gear."""
    stage = example("wu2022").stages[0]
    thread, gear = stage.thread, given(stage.gear)
    single = {
        name: {side: float(contact.axial_stiffness[-1]) for side, contact in sides.items()}
        for name, sides in pairs_of_threads("wu2022").items()
    }
    pair = single["wu2022"]
    printed = {"screw": 2.078e8, "nut": 2.198e8}
    threads = {side: printed[side] / pair[side] for side in printed}
    loads = {side: _THREAD_LOAD * (threads[side] / _THREADS) ** 3 for side in printed}
    bounds = {"screw": (2.02e8, 2.04e8), "nut": (2.20e8, 2.215e8)}
    for side in printed:
        yield not_comparable(
            f"Table 4: thread contact stiffness, {side} and one roller",
            f"{printed[side]:.3e}",
            pair[side] * _THREADS,
            "N/m",
            between=bounds[side],
            missing="neither load, number of threads nor material are given. Equations 36 to 47 "
            f"give {pair[side]:.4g} N/m for one thread at an axial {_THREAD_LOAD:.0f} N (E 212 "
            f"GPa, ν 0.29); computed for {_THREADS} of them. The printed number is that of "
            f"{threads[side]:.2f} such threads, or of {_THREADS} at {loads[side]:.1f} N",
        )
    others = ", ".join(
        f"{single[name]['nut'] / single[name]['screw']:.4f} ({name})"
        for name in single
        if name != "wu2022"
    )
    yield unexplained(
        "Table 4: ratio of the thread contact stiffnesses, nut to screw",
        f"{2.198 / 2.078:.4f}",
        pair["nut"] / pair["screw"],
        between=(1.088, 1.089),
        note="no load, number of threads or material reaches the printed ratio: all of them cancel "
        f"when both sides have the same. Other curvature conventions give {others}",
    )
    width = float(gear_mesh_stiffness(gear, thread.starts))
    yield differs(
        "Table 4: gear mesh stiffness, equations 48 to 50 at 10 mm face width",
        "2.464e8",
        width,
        "N/m",
        between=(1.6428e8, 1.6429e8),
        evidence=1.5 * width,
        evidence_between=(2.4635e8, 2.4645e8),
        because="the printed value is 1.5 times the stiffness of one pair of teeth (the evidence)",
    )
    meshing = dataclasses.replace(gear, mesh_factor=1.5)
    yield number(
        "Table 4: gear mesh stiffness, 1.5 times one pair of teeth",
        "2.464e8",
        float(gear_mesh_stiffness(meshing, thread.starts)),
        "N/m",
        note="the paper does not mention the factor: 0.75 ε_α + 0.25 of ISO 6336-1 with ε_α = 5/3, "
        "or a face width of 15 mm",
    )
