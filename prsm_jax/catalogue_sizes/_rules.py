"""Rules that complete a size of a catalogue to a mechanism."""

import math
from typing import Any

from .._errors import UnknownNameError, closest
from ..friction import CoulombFriction, Friction
from ..mechanism import (
    USUAL_MODULES,
    AxialPlay,
    Carrier,
    Gear,
    Material,
    Mechanism,
    Nut,
    OperatingPoint,
    Roller,
    Screw,
    ScrewShaft,
    Stage,
    Strength,
    Thread,
)
from ._rows import CAPACITIES, columns

#: Heights of the screw's thread above and below the nominal diameter, over the pitch: medians of
#: the sizes that print crest and root.
_ADDENDUM, _DEDENDUM = 0.15, 0.25
#: Tip clearance between the roller's crest and the screw's root, over the pitch.
_TIP_CLEARANCE = 0.05
#: Half of the smallest gap between crests of neighbouring rollers, over the roller's radius.
_GAP = 0.02
#: Length of the roller, and of its thread, over that of the nut. Printed inertias of the rollers
#: give 0.78 to 0.96 for the first; gears and journals take the rest.
_ROLLER_SHARE, _THREAD_SHARE, _GEAR_SHARE = 0.85, 0.6, 0.0625
#: Largest relative error of a given circle of the roller axes: the 90 sizes print it exactly.
_CIRCLE_TOLERANCE = 0.01
#: Wall and length of the nut by nominal diameter, d in mm: fits of 90 sizes, good to a third.
_WALL, _LENGTH = (1.14, 0.53), (7.97, 0.69)
#: Smallest number of teeth of a roller.
_FEWEST_TEETH = 16
#: Mean pressure of the operating load on the square of the nominal diameter: about a fifth of a
#: printed dynamic capacity [Pa].
_LOAD = 25e6
#: A speed well below the printed limits of such screws, DN value [m rad/s].
_DN = 0.03 * 1000 * 2 * math.pi / 60


def _checked(row: dict[str, float | int]) -> None:
    known = columns()
    for name, value in row.items():
        if name in CAPACITIES:
            raise ValueError(f"{name} is a result of the mechanism; leave it out")
        if name not in known:
            raise UnknownNameError(f"unknown column {name!r}; {closest(name, known)}")
        if not (isinstance(value, float | int) and math.isfinite(value)):
            raise ValueError(f"{name} is {value!r}; give a finite number")
        if name != "largest_axial_play_mm" and value <= 0:
            raise ValueError(f"{name} is {value}; it must be above 0")
        if value < 0:
            raise ValueError(f"{name} is {value}; it must be 0 or more")


def rollers_that_fit(centre_distance: float, largest_radius: float) -> int:
    """Largest number of rollers beside each other: 2 a sin(π/N) ≥ 2 r, at least 3."""
    return max(3, math.floor(math.pi / math.asin(largest_radius / centre_distance) + 1e-9))


def catalogue_mechanism(
    nominal_diameter: float | int, lead: float | int, starts: float | int, **row: float | int
) -> Mechanism:
    r"""A standard roller screw of a catalogue's size, completed by rules.

    | number | rule |
    |---|---|
    | radius of the roller | $r_s/(n-2)$ |
    | addendum and dedendum of the screw | from crest and root, or 0.15 and 0.25 pitches |
    | addendum of the roller | dedendum of the screw less 0.05 pitches |
    | number of rollers | as many as fit with gaps of 0.04 radii between crests; at least 3 |
    | nut | outer diameter and length given, or fitted to 90 sizes |
    | roller | 0.85 of the nut's length; threads on 0.6, a gear on 0.0625 at either end |
    | carriers | 2, as wide as the roller's radius, 0.02 of the nut's length each |
    | contact angle, profile radius | 45°, $r_R/\sin\alpha$ |
    | gear | a standard module with at least 16 teeth of the roller, 20° |
    | screw | solid, one metre long |
    | steel | 210 GPa, 0.3, 7850 kg/m³, hardened; friction coefficient 0.06 |
    | operating point | 25 MPa times $d_0^2$; 30 000 mm rpm over $d_0$ |

    Equal shares of the load in all threads are assumed.

    **Arguments:**

    - `nominal_diameter`: of the screw, $d_0$ [m].
    - `lead`: [m].
    - `starts`: of screw and nut, $n > 2$.
    - `row`: further columns of `catalogue_rows` by their names, in their units; without the
      capacities, which are results. The rules give all columns that are missing. The efficiencies
      and the torque of the preload are results too, and are ignored.

    **Raises:** `UnknownNameError` for another column; `ValueError` for a capacity, for a number
    that is not finite or is negative, and for dimensions that do not make a screw.
    """
    _checked(row)
    for name, value in {"nominal_diameter": nominal_diameter, "lead": lead}.items():
        if not 0 < value <= 1:
            raise ValueError(f"{name} is {value} m; it must be above 0 and at most 1 m")
    if not (math.isfinite(starts) and starts == round(starts) and starts > 2):
        raise ValueError(f"starts is {starts}; a standard roller screw has a whole number above 2")

    def given(name: str, scale: float, estimate: float) -> float:
        return row[name] * scale if name in row else estimate

    screw_radius, pitch = nominal_diameter / 2, lead / starts
    # Screw and nut have the same lead, so the ratio of their radii follows from the starts.
    circle = nominal_diameter * (1 + 1 / (starts - 2))
    printed = given("roller_circle_diameter_mm", 1e-3, circle)
    if abs(printed / circle - 1) > _CIRCLE_TOLERANCE:
        raise ValueError(
            f"roller_circle_diameter_mm is {printed * 1e3:.4g}; a screw of "
            f"{nominal_diameter * 1e3:.4g} mm with {starts:g} starts has {circle * 1e3:.4g}"
        )
    roller_radius = circle / 2 - screw_radius
    addendum = given("crest_diameter_mm", 5e-4, screw_radius + _ADDENDUM * pitch) - screw_radius
    root_radius = given("root_diameter_mm", 5e-4, screw_radius - _DEDENDUM * pitch)
    if root_radius <= 0:
        raise ValueError(
            f"lead is {lead} m: threads of this pitch are deeper than a screw of "
            f"{nominal_diameter * 1e3:.4g} mm"
        )
    if not root_radius < screw_radius <= screw_radius + addendum:
        raise ValueError(
            f"root_diameter_mm is {root_radius * 2e3:.4g} and crest_diameter_mm "
            f"{(screw_radius + addendum) * 2e3:.4g}; the nominal diameter, "
            f"{nominal_diameter * 1e3:.4g}, must lie between them"
        )
    roller_addendum = max(screw_radius - root_radius - _TIP_CLEARANCE * pitch, 0.1 * pitch)
    largest = roller_radius * (1 + _GAP) + roller_addendum
    if largest >= circle / 2:
        raise ValueError(
            f"lead is {lead} m: rollers with threads of this pitch do not fit beside a screw of "
            f"{nominal_diameter * 1e3:.4g} mm"
        )
    count = rollers_that_fit(circle / 2, largest)

    nut_radius = starts * roller_radius
    millimetres = nominal_diameter * 1e3
    wall = 1e-3 * _WALL[0] * millimetres ** _WALL[1]
    outer = given("nut_outer_diameter_mm", 5e-4, nut_radius + wall)
    if outer <= nut_radius:
        raise ValueError(
            f"nut_outer_diameter_mm is {outer * 2e3:.4g}, less than the nominal diameter of the "
            f"nut's thread, {nut_radius * 2e3:.4g} mm"
        )
    length = given("nut_length_mm", 1e-3, 1e-3 * _LENGTH[0] * millimetres ** _LENGTH[1])
    fitting = [m for m in USUAL_MODULES if 2e3 * roller_radius / m >= _FEWEST_TEETH]
    if not fitting:
        raise ValueError(
            f"nominal_diameter is {nominal_diameter} m: the rollers are too small for a gear of "
            f"{_FEWEST_TEETH} teeth with the smallest module, {USUAL_MODULES[0]:g} mm"
        )
    module = 1e-3 * max(fitting)

    steel = Material(210e9, 0.3, 7850.0)
    roller = Roller(length=_ROLLER_SHARE * length)
    carrier = Carrier(length=0.02 * length, radial_width=roller_radius, count=2)
    masses: dict[str, Any] = {}
    if "nut_mass_kg" in row:
        planets = count * math.pi * 7850.0 * roller_radius**2 * _ROLLER_SHARE * length
        masses["mass"] = max(row["nut_mass_kg"] - planets, 0.1 * row["nut_mass_kg"])
    if "nut_inertia_kg_mm2" in row:
        masses["inertia"] = 1e-6 * row["nut_inertia_kg_mm2"]
    shaft: dict[str, Any] = {}
    if "shaft_mass_kg_per_m" in row:
        shaft["mass"] = row["shaft_mass_kg_per_m"]
    if "shaft_inertia_kg_mm2_per_m" in row:
        shaft["inertia"] = 1e-6 * row["shaft_inertia_kg_mm2_per_m"]
    play = row.get("largest_axial_play_mm")
    stage = Stage(
        thread=Thread(
            lead=lead,
            starts=starts,
            roller_radius=roller_radius,
            contact_angle=math.pi / 4,
            screw_addendum=addendum,
            roller_addendum=roller_addendum,
        ),
        roller_count=count,
        engaged_threads=_THREAD_SHARE * length / pitch,
        sharing="equal",
        screw=Screw(length=1.0, **shaft),
        roller=roller,
        nut=Nut(length=length, wall_thickness=outer - nut_radius, **masses),
        carrier=carrier,
        gear=Gear(
            pressure_angle=math.radians(20),
            roller_teeth=round(2 * roller_radius / module),
            face_width=_GEAR_SHARE * length,
        ),
        material=steel,
        friction=Friction(thread=CoulombFriction(0.06)),
        strength=Strength(
            permissible_pressure=4.2e9,
            material_factor=1.1,
            shaft=ScrewShaft("fixed_supported", root_radius=root_radius),
            play=None if play is None else AxialPlay(axial_backlash=1e-3 * play),
        ),
    )
    title = f"Roller screw {millimetres:g} × {lead * 1e3:g} mm, {starts:g} starts"
    return Mechanism(
        stages=(stage,),
        operating_point=OperatingPoint(
            speed=_DN / nominal_diameter, load=_LOAD * nominal_diameter**2
        ),
        title=title,
    )
