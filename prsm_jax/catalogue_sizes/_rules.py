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
from ._size_rules import SizeRules

#: Heights of the screw's thread above and below the nominal diameter, over the pitch: medians of
#: the sizes that print crest and root.
_ADDENDUM, _DEDENDUM = 0.15, 0.25
#: Tip clearance between the roller's crest and the screw's root, over the pitch.
_TIP_CLEARANCE = 0.05
#: Length of one gear over that of the roller's end without loaded thread; journals take the rest.
_GEAR_SHARE = 0.5
#: Largest relative error of a given circle of the roller axes: the 90 sizes print it exactly.
_CIRCLE_TOLERANCE = 0.01
#: Wall and length of the nut by nominal diameter, d in mm: fits of 90 sizes, good to a third.
_WALL, _LENGTH = (1.14, 0.53), (7.97, 0.69)
#: Smallest number of teeth of a roller, and the smallest module of rollers that are too small for
#: the usual ones [mm].
_FEWEST_TEETH, _LEAST_MODULE = 16, 0.1
#: Mean pressure of the operating load on the square of the nominal diameter: about a fifth of a
#: printed dynamic capacity [Pa].
_LOAD = 25e6
#: Yield strength of the core of an induction-hardened screw, quenched and tempered [Pa].
_YIELD_STRENGTH = 900e6
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


def built(
    chosen: SizeRules,
    nominal_diameter: float | int,
    lead: float | int,
    starts: float | int,
    row: dict[str, float | int],
) -> Mechanism:
    """A standard roller screw of a catalogue's size.

    **Arguments:**

    - `chosen`: the rules.
    - `nominal_diameter`, `lead`, `starts`, `row`: as in `catalogue_mechanism`.

    **Raises:** as `catalogue_mechanism`.
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
    if roller_radius * (1 + chosen.gap) + roller_addendum >= circle / 2:
        raise ValueError(
            f"lead is {lead} m: rollers with threads of this pitch do not fit beside a screw of "
            f"{nominal_diameter * 1e3:.4g} mm"
        )
    count, roller_addendum = chosen.rollers(circle / 2, roller_radius, roller_addendum, pitch)

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
    largest_module = 2e3 * roller_radius / _FEWEST_TEETH
    if largest_module < _LEAST_MODULE:
        raise ValueError(
            f"nominal_diameter is {nominal_diameter} m: the rollers are too small for a gear of "
            f"{_FEWEST_TEETH} teeth with the smallest module, {_LEAST_MODULE:g} mm"
        )
    module = 1e-3 * max((m for m in USUAL_MODULES if m <= largest_module), default=_LEAST_MODULE)

    steel = Material(210e9, 0.3, 7850.0)
    roller_length, threaded = chosen.roller_length(length), chosen.threaded_length(length)
    gear_width = _GEAR_SHARE * (roller_length - threaded) / 2
    roller = Roller(length=roller_length)
    carrier = Carrier(length=0.02 * length, radial_width=roller_radius, count=2)
    masses: dict[str, Any] = {}
    if "nut_mass_kg" in row:
        planets = count * math.pi * 7850.0 * roller_radius**2 * roller_length
        rings = 4 * math.pi * 7850.0 * circle / 2 * roller_radius * 0.02 * length
        masses["mass"] = max(row["nut_mass_kg"] - planets - rings, 0.1 * row["nut_mass_kg"])
    if "nut_inertia_kg_mm2" in row:
        masses["inertia"] = 1e-6 * row["nut_inertia_kg_mm2"]
    shaft: dict[str, Any] = {}
    if "shaft_mass_kg_per_m" in row:
        shaft["mass"] = row["shaft_mass_kg_per_m"]
    if "shaft_inertia_kg_mm2_per_m" in row:
        shaft["inertia"] = 1e-6 * row["shaft_inertia_kg_mm2_per_m"]
    play = chosen.play(pitch)
    if "largest_axial_play_mm" in row:
        play = 1e-3 * row["largest_axial_play_mm"]
    stage = Stage(
        thread=Thread(
            lead=lead,
            starts=starts,
            roller_radius=roller_radius,
            contact_angle=math.pi / 4,
            roller_profile_radius=chosen.profile_radius(pitch),
            screw_addendum=addendum,
            roller_addendum=roller_addendum,
        ),
        roller_count=count,
        engaged_threads=threaded / pitch,
        sharing="equal",
        screw=Screw(length=1.0, **shaft),
        roller=roller,
        nut=Nut(length=length, wall_thickness=outer - nut_radius, **masses),
        carrier=carrier,
        gear=Gear(
            pressure_angle=math.radians(20),
            roller_teeth=round(2 * roller_radius / module),
            face_width=gear_width,
        ),
        material=steel,
        friction=Friction(thread=CoulombFriction(chosen.friction_coefficient(starts))),
        strength=Strength(
            permissible_pressure=4.2e9,
            material_factor=chosen.material_factor,
            fatigue_rule=chosen.fatigue_rule,
            shaft=ScrewShaft(
                "fixed_supported", root_radius=root_radius, yield_strength=_YIELD_STRENGTH
            ),
            play=None if play is None else AxialPlay(axial_backlash=play),
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
