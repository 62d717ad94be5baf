"""Limits of numbers: finite and, if the field or the unit says so, positive or in a range."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Limit:
    """The physical range of a number [SI], with the words that an error message uses.

    A field declares its own (`number("1", "friction coefficient", limit=NOT_NEGATIVE)`); it applies
    to files, to `--set`, to numbers given in Python outside a trace, and to bounds of variables.
    """

    lower: float
    upper: float
    allowed: str
    lower_allowed: bool = False
    upper_allowed: bool = False
    zero_allowed: bool = True
    #: A hint for the author of a file.
    hint: str = ""

    @property
    def words(self) -> str:
        """What is allowed, and a hint for the author of a file."""
        return f"{self.allowed} ({self.hint})" if self.hint else self.allowed

    def admits(self, value: float | int) -> bool:
        """Whether a value is finite and in the range."""
        above = value > self.lower or (self.lower_allowed and value == self.lower)
        below = value < self.upper or (self.upper_allowed and value == self.upper)
        return above and below and math.isfinite(value) and (self.zero_allowed or value != 0)


ANY = Limit(-math.inf, math.inf, "finite")
NOT_ZERO = Limit(-math.inf, math.inf, "finite and not 0", zero_allowed=False)
POSITIVE = Limit(0.0, math.inf, "more than 0")
NOT_NEGATIVE = Limit(0.0, math.inf, "0 or more", lower_allowed=True)
SHARE = Limit(0.0, 1.0, "from 0 to 1", lower_allowed=True, upper_allowed=True)
ACUTE_ANGLE = Limit(0.0, math.pi / 2, "between 0 and 90 deg, both excluded")
SLANT = Limit(-math.pi / 2, math.pi / 2, "between -90 and 90 deg, both excluded")
#: Enough for any roller screw, and few enough that a typing error does not fill the memory.
ROLLERS = Limit(
    1.0, 1000.0, "a whole number from 1 to 1000", lower_allowed=True, upper_allowed=True
)
ROLLER_NUMBER = Limit(1.0, 1000.0, "a whole number from 1 to the number of rollers", True, True)
COUNT = Limit(1.0, 100.0, "a whole number from 1 to 100", lower_allowed=True, upper_allowed=True)
#: Rounding spoils polynomials of a higher degree before they describe a beam any better.
SHAPES = Limit(1.0, 16.0, "a whole number from 1 to 16", True, True)
#: More threads than any roller has; a longer chain would only take time.
THREADS = Limit(1.0, 1000.0, "a whole number from 1 to 1000", True, True)

SAMPLES = Limit(2.0, 1e6, "a whole number from 2 to 1000000", True, True)
MANY = Limit(1.0, 1e6, "a whole number from 1 to 1000000", True, True)

_UNIT = 'a bare number is in m, so give the unit, such as "10 mm"'
#: No roller screw has threads of a metre: then the unit was left out.
OF_A_THREAD = Limit(0.0, 1.0, "more than 0 and at most 1 m", upper_allowed=True, hint=_UNIT)
_LENGTH = Limit(0.0, 100.0, "more than 0 and at most 100 m", upper_allowed=True, hint=_UNIT)
STARTS = Limit(2.0, math.inf, "more than 2 (the screw radius is (starts - 2) r_R)")
RADIUS_RATIO = Limit(2.0, math.inf, "more than 2 (the screw radius is (radius_ratio - 2) r_R)")
POISSON_RATIO = Limit(-1.0, 0.5, "between -1 and 0.5, both excluded")
DAMPING_RATIO = Limit(0.0, 1.0, "0 or more and less than 1", lower_allowed=True)
INNER_SHARE = Limit(0.0, 1.0, "between 0 and 1, both excluded")
SHARE_ABOVE_0 = Limit(0.0, 1.0, "more than 0 and at most 1", upper_allowed=True)

#: Limits by unit, for fields that declare none.
_BY_UNIT = {
    "m": _LENGTH,
    "s": POSITIVE,
    "kg": POSITIVE,
    "kg·m²": POSITIVE,
    "kg/m³": POSITIVE,
    "Pa": POSITIVE,
    # A support of stiffness 0 means a free body; a given contact stiffness of 0, no contact.
    "N/m": NOT_NEGATIVE,
    "N·s/m": NOT_NEGATIVE,
    "m/s": POSITIVE,
    "m·rad/s": POSITIVE,
}


def limit_of(unit: str, declared: Limit | None = None) -> Limit:
    """The limit of a number: what its field declares, else that of its SI unit, else finite."""
    return declared or _BY_UNIT.get(unit) or ANY
