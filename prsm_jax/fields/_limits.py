"""What a number may be: finite, and where its name or its unit says so, positive or in a range."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Limit:
    """The physical range of a number [SI], with the words that an error message uses.

    Files and numbers that are set in Python are held to the same table, `limit_of`.
    """

    lower: float
    upper: float
    allowed: str
    lower_allowed: bool = False
    upper_allowed: bool = False
    #: What else a file's author is told.
    hint: str = ""

    @property
    def words(self) -> str:
        """What is allowed, and the hint to who writes a file."""
        return f"{self.allowed} ({self.hint})" if self.hint else self.allowed

    def admits(self, value: float) -> bool:
        """Whether a value is finite and in the range."""
        above = value > self.lower or (self.lower_allowed and value == self.lower)
        below = value < self.upper or (self.upper_allowed and value == self.upper)
        return math.isfinite(value) and above and below


ANY = Limit(-math.inf, math.inf, "finite")
POSITIVE = Limit(0.0, math.inf, "more than 0")
NOT_NEGATIVE = Limit(0.0, math.inf, "0 or more", lower_allowed=True)
SHARE = Limit(0.0, 1.0, "from 0 to 1", lower_allowed=True, upper_allowed=True)
ACUTE_ANGLE = Limit(0.0, math.pi / 2, "between 0 and 90 deg, both excluded")
SLANT = Limit(-math.pi / 2, math.pi / 2, "between -90 and 90 deg, both excluded")
#: Enough for any roller screw, and few enough that a slip of the pen does not fill the memory.
ROLLERS = Limit(
    1.0, 1000.0, "a whole number from 1 to 1000", lower_allowed=True, upper_allowed=True
)
ROLLER_NUMBER = Limit(1.0, 1000.0, "a whole number from 1 to the number of rollers", True, True)
COUNT = Limit(1.0, 100.0, "a whole number from 1 to 100", lower_allowed=True, upper_allowed=True)
#: A chain of more threads than any roller has would only take time.
THREADS = Limit(1.0, 1000.0, "a whole number from 1 to 1000", True, True)

_UNIT = 'a bare number is in m, so give the unit, such as "10 mm"'
#: No roller screw has threads of a metre; who writes so has left out the unit.
_OF_A_THREAD = Limit(0.0, 1.0, "more than 0 and at most 1 m", upper_allowed=True, hint=_UNIT)
_LENGTH = Limit(0.0, 100.0, "more than 0 and at most 100 m", upper_allowed=True, hint=_UNIT)

_BY_NAME = {
    "lead": _OF_A_THREAD,
    "pitch": _OF_A_THREAD,
    "roller_radius": _OF_A_THREAD,
    "roller_radius_at_fixed_screw_radius": _OF_A_THREAD,
    "roller_profile_radius": _OF_A_THREAD,
    "screw_radius": _OF_A_THREAD,
    "starts": Limit(2.0, math.inf, "more than 2 (the screw radius is (starts - 2) r_R)"),
    "starts_at_fixed_pitch": Limit(2.0, math.inf, "more than 2"),
    "contact_angle": ACUTE_ANGLE,
    "flank_angle": ACUTE_ANGLE,
    "pressure_angle": ACUTE_ANGLE,
    "screw_profile_angle": ACUTE_ANGLE,
    "roller_profile_angle": ACUTE_ANGLE,
    "lead_angle": SLANT,
    "helix_angle": SLANT,
    "poisson_ratio": Limit(-1.0, 0.5, "between -1 and 0.5, both excluded"),
    "bore_radius": NOT_NEGATIVE,
    "screw_addendum": NOT_NEGATIVE,
    "roller_addendum": NOT_NEGATIVE,
    "edge_radius": POSITIVE,
    "coefficient": NOT_NEGATIVE,
    "static_coefficient": NOT_NEGATIVE,
    "viscous_coefficient": NOT_NEGATIVE,
    "bristle_stiffness": POSITIVE,
    "bristle_damping": NOT_NEGATIVE,
    "width": POSITIVE,
    "loss_factor": SHARE,
    "ratio": Limit(0.0, 1.0, "0 or more and less than 1", lower_allowed=True),
    "mass_coefficient": NOT_NEGATIVE,
    "stiffness_coefficient": NOT_NEGATIVE,
    "stiffness_factor": POSITIVE,
    "mass_factor": POSITIVE,
    "position_offset": SLANT,
    "torque": NOT_NEGATIVE,
    "engaged_threads": POSITIVE,
    "tooth_thinning": ANY,
    "thread_count": THREADS,
    "after_thread": THREADS,
    "preload": POSITIVE,
    "offset": ANY,
    "backlash": ANY,
    "spacer_stiffness": POSITIVE,
    "screw_segment_stiffness": POSITIVE,
    "roller_segment_stiffness": POSITIVE,
    "nut_segment_stiffness": POSITIVE,
    "screw_pitch_error": ANY,
    "roller_pitch_error": ANY,
    "nut_pitch_error": ANY,
    "screw_relief": NOT_NEGATIVE,
    "nut_relief": NOT_NEGATIVE,
    "screw_wear": NOT_NEGATIVE,
    "nut_wear": NOT_NEGATIVE,
    "roller_teeth": POSITIVE,
    "mesh_factor": POSITIVE,
    "roller_count": ROLLERS,
    "static_capacity": POSITIVE,
    "dynamic_capacity": POSITIVE,
    "material_factor": POSITIVE,
    "reliability": Limit(0.0, 1.0, "between 0 and 1, both excluded"),
    "life_modification_factor": POSITIVE,
    "oscillation_amplitude": POSITIVE,
    "permissible_speed_share": Limit(0.0, 1.0, "more than 0 and at most 1", upper_allowed=True),
    "axial_backlash": NOT_NEGATIVE,
    "screw_tooth_thinning": NOT_NEGATIVE,
    "roller_tooth_thinning": NOT_NEGATIVE,
    "nut_tooth_thinning": NOT_NEGATIVE,
    "preload_force": POSITIVE,
    "number": ROLLER_NUMBER,
    "count": COUNT,
}
_BY_UNIT = {
    "m": _LENGTH,
    "s": POSITIVE,
    "kg": POSITIVE,
    "kg·m²": POSITIVE,
    "kg/m³": POSITIVE,
    "Pa": POSITIVE,
    # A free body is a support of stiffness zero, and no contact one of the given stiffnesses.
    "N/m": NOT_NEGATIVE,
    "N·s/m": NOT_NEGATIVE,
    "m/s": POSITIVE,
    "m·rad/s": POSITIVE,
}


def limit_of(name: str, unit: str) -> Limit:
    """The limit of a number by its name, else by its SI unit, else finite."""
    return _BY_NAME.get(name) or _BY_UNIT.get(unit) or ANY
