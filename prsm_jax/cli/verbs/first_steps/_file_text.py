"""The text of a new file: the design, with a reason for each number that was chosen."""

from collections.abc import Mapping

from ....catalogue_sizes import FITTED
from ....dimensioning import (
    BUCKLING_SAFETY,
    SPEED_SHARE,
    STATIC_SAFETY,
    Dimensioning,
    nut_outer_diameter,
)
from ....file import commented, rounded
from ....text import display_unit

#: Comments of tables and numbers that are the same in every new file.
_FIXED = {
    "operating_point.load": "as required",
    "operating_point.duration": "of a step to this speed: the carriers settle within a third of it",
    "stage.sharing": "all threads are assumed to carry equal loads",
    "stage.thread.starts": "of screw and nut, as in the catalogue",
    "stage.thread.contact_angle": "45 deg, the usual value",
    "stage.thread.screw_addendum": "crest of the screw as in the catalogue, or 0.15 pitches",
    "stage.thread.roller_addendum": (
        "leaves 0.05 pitches to the root of the screw, lower if rollers would touch"
    ),
    "stage.screw.length": "between the bearings, and three diameters of journals",
    "stage.gear": "a standard module with at least 16 teeth of the roller",
    "stage.material": "hardened bearing steel",
    "stage.friction.thread": "grease, boundary lubrication: an assumption; measure it",
    "stage.strength": "no standard exists for roller screws: practice of bearings and ball screws",
    "stage.strength.permissible_pressure": (
        "ISO 76 for ball bearings: permanent deformation of 1e-4 of the ball's diameter"
    ),
    "stage.strength.shaft.root_radius": "as in the catalogue, or 0.25 pitches below the thread",
    "stage.strength.shaft.yield_strength": (
        "core of an induction-hardened screw, quenched and tempered: an assumption"
    ),
    "stage.strength.shaft.end_conditions": "fixed at the motor, supported at the other end",
    "stage.strength.shaft.permissible_speed_share": "as catalogues of ball screws allow",
}
#: Estimates of the dynamic capacity.
_FATIGUE_RULES = {
    "equivalent_balls": "capacity by the formula of ball screws with equivalent balls",
    "lundberg_palmgren": "capacity by Lundberg and Palmgren's theory for the contact ellipses",
}


def file_text(found: Dimensioning) -> str:
    """The file of a design that was found.

    **Arguments:**

    - `found`: the design.
    """
    assert found.mechanism is not None
    assert found.size is not None
    wanted = found.requirements
    asked = {
        "load": _shown(wanted.load, "N"),
        "stroke": _shown(wanted.stroke, "m"),
        "speed": _shown(wanted.speed, "m/s"),
        "life": _shown(wanted.life, "s"),
        "envelope": _shown(wanted.envelope, "m"),
    }
    requirements = ", ".join(f"{name} {value}" for name, value in asked.items())
    head = [
        f"A first design by prsm new, for: {requirements}.",
        f"It is the smallest of {found.sizes} sizes of a catalogue that meets them all. Numbers "
        "that the catalogue does not give follow from rules; the comments say what was chosen and "
        "why. Check what you know better: friction, material, supports, lengths.",
    ]
    pitch = float(found.mechanism.stages[0].thread.pitch)
    reasons = _FIXED | _rule_words(pitch) | _chosen(found, asked)
    return commented(rounded(found.mechanism), reasons, head)


def _rule_words(pitch: float) -> dict[str, str]:
    """Reasons of the numbers that follow from the rules of the catalogue's sizes, by path.

    **Arguments:**

    - `pitch`: of the thread [m].
    """
    radius = FITTED.profile_radius(pitch)
    assert radius is not None
    thread = _part_of_nut(FITTED.thread_ends, FITTED.least_thread)
    roller = _part_of_nut(FITTED.roller_ends, FITTED.least_roller)
    return {
        "stage.roller_count": (
            f"pitch circles that fit side by side, less {FITTED.spare_rollers}; fewer where crests "
            "would touch"
        ),
        "stage.engaged_threads": f"length of loaded thread over the pitch; the length is {thread}",
        "stage.roller.length": f"{roller}; gears and journals are beside the thread",
        "stage.thread.roller_profile_radius": (
            f"{radius / pitch:.3g} pitches, fitted to capacities of the catalogue"
        ),
        "stage.friction.thread.coefficient": (
            f"{FITTED.friction_by_starts:g} times (starts less 1), fitted to efficiencies of the "
            "catalogue"
        ),
        "stage.strength.play.axial_backlash": (
            "the catalogue's largest play of unpreloaded nuts of this pitch"
        ),
        "stage.strength.fatigue_rule": _FATIGUE_RULES[FITTED.fatigue_rule],
        "stage.strength.material_factor": (
            "one value for all sizes, fitted to their dynamic capacities"
        ),
    }


def _part_of_nut(ends: float, least: float) -> str:
    """A length that is the nut's less both ends, and at least a share of it."""
    return f"the nut's length less {1e3 * ends:g} mm, at least {least:g} of it"


def _chosen(found: Dimensioning, asked: Mapping[str, str]) -> dict[str, str]:
    """Reasons that depend on the design."""
    assert found.mechanism is not None
    assert found.size is not None
    stage, margin, size = found.mechanism.stages[0], found.margins, found.size
    diameter = size["nominal_diameter_mm"]
    buckling = BUCKLING_SAFETY * margin["buckling"]
    static = STATIC_SAFETY * margin["static_safety"]
    critical = SPEED_SHARE / margin["critical_speed"]
    outer = nut_outer_diameter(stage)
    nut = _shown(float(stage.nut.length), "m")  # pyright: ignore[reportArgumentType]
    return {
        "operating_point.speed": f"{asked['speed']} of the nut at this lead",
        "stage.thread.lead": "smallest whose contacts stay on the flanks, if any does",
        "stage.thread.roller_radius": f"screw of {diameter:g} mm, as in the catalogue",
        "stage.nut.wall_thickness": (
            f"outer diameter {_shown(outer, 'm')}, in a bore of {asked['envelope']}"
        ),
        "stage.nut.length": f"static capacity {static:.3g} times the load",
        "stage.strength.required_life": (
            f"as required; by the dynamic capacity it is {margin['life']:.3g} times as long"
        ),
        "stage.strength.shaft.unsupported_length": (
            f"stroke {asked['stroke']}, nut {nut}, two diameters; {100 * critical:.3g} % of the "
            "critical speed"
        ),
        "stage.strength.shaft.loaded_length": (
            f"stroke and nut; the buckling load is {buckling:.3g} times the load"
        ),
        "stage.strength.shaft.dn_limit": (
            f"for grease; the design has {100 / margin['dn_value']:.3g} % of it"
        ),
    }


def _shown(value: float, unit: str) -> str:
    """A number as a person would ask for it."""
    shown = display_unit(unit, float(value))
    # Four digits, without an exponent up to a million.
    return f"{float(f'{float(shown(float(value))):.4g}'):g} {shown.label}"
