"""The text of a new file: the design, with a reason for each number that was chosen."""

from collections.abc import Mapping

from ....dimensioning import Dimensioning, nut_outer_diameter
from ....file import commented, rounded
from ....text import Line

#: Comments of tables and numbers that are the same in every new file.
_FIXED = {
    "operating_point.load": "as required",
    "stage.sharing": "all threads are assumed to carry equal loads",
    "stage.thread.starts": "of screw and nut, as in the catalogue",
    "stage.thread.contact_angle": "as usual",
    "stage.thread.screw_addendum": "crest of the screw as in the catalogue, or 0.15 pitches",
    "stage.thread.roller_addendum": "leaves 0.05 pitches to the root of the screw",
    "stage.engaged_threads": "threads on 0.6 of the length of the nut",
    "stage.roller_count": "as many as fit with a gap between their crests",
    "stage.roller.length": "0.85 of the nut; gears and journals take the rest",
    "stage.screw.length": "between the bearings, and three diameters of journals",
    "stage.gear": "a standard module with at least 16 teeth of the roller",
    "stage.material": "hardened bearing steel",
    "stage.friction.thread": "grease, boundary lubrication: an assumption; measure it",
    "stage.friction.thread.coefficient": "of the threads",
    "stage.strength": "no standard exists for roller screws: practice of bearings and ball screws",
    "stage.strength.permissible_pressure": "ball bearings in ISO 76: a dent of 1e-4 of the ball",
    "stage.strength.material_factor": "the capacity is estimated; ISO 281 gives its steels 1.3",
    "stage.strength.shaft.root_radius": "as in the catalogue, or 0.25 pitches below the thread",
    "stage.strength.shaft.end_conditions": "fixed at the motor, supported at the other end",
    "stage.strength.shaft.permissible_speed_share": "as catalogues of ball screws allow",
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
    return commented(rounded(found.mechanism), _FIXED | _chosen(found, asked), head)


def _chosen(found: Dimensioning, asked: Mapping[str, str]) -> dict[str, str]:
    """Reasons that depend on the design."""
    assert found.mechanism is not None
    assert found.size is not None
    stage, margin, size = found.mechanism.stages[0], found.margins, found.size
    diameter = size["nominal_diameter_mm"]
    # The margins are over twice the load, and over 0.8 of the critical speed.
    buckling, static = 2 * margin["buckling"], 2 * margin["static_safety"]
    critical = 0.8 / margin["critical_speed"]
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
    text, _, label = Line("", float(value), unit).text.partition(" ")
    return f"{float(text):g} {label}" if "·" not in text else f"{text} {label}"
