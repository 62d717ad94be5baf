"""What a screw must do, and the limits that a design keeps."""

import dataclasses
import math
from typing import TypeVar

import numpy as np

#: One length, or an array of them.
_Length = TypeVar("_Length", float, np.ndarray)
#: Static capacity over the load (ISO 76 asks rolling bearings for 1 to 2).
STATIC_SAFETY = 2.0
#: Buckling load over the load, as catalogues of ball screws require.
BUCKLING_SAFETY = 2.0
#: Screw speed over the critical speed, as catalogues of ball screws allow.
SPEED_SHARE = 0.8
#: Largest DN value with grease: 100,000 mm rpm; catalogues give 80,000 to 160,000 [m·rad/s].
DN_LIMIT = 100.0 * 2 * math.pi / 60
#: Length beside the stroke and the nut between the bearings, and of both journals, over the
#: diameter of the screw.
_ENDS, _JOURNALS = 2.0, 3.0


@dataclasses.dataclass(frozen=True)
class Requirements:
    """Five requirements on a roller screw.

    - `load`: axial force on the nut, at all times and in both directions [N].
    - `stroke`: travel of the nut [m].
    - `speed`: largest speed of the nut, at which the life counts [m/s].
    - `life`: operating time at this speed under this load, for a survival of 90 % [s].
    - `envelope`: diameter of the bore into which the nut has to fit [m].

    **Raises:** `ValueError` for a number that is not above 0.
    """

    load: float
    stroke: float
    speed: float
    life: float
    envelope: float

    def __post_init__(self) -> None:
        for name, unit in UNITS.items():
            value = getattr(self, name)
            if not (isinstance(value, int | float) and 0 < value < math.inf):
                raise ValueError(f"{name} is {value!r}; give it in {unit}, above 0 and finite")


#: SI units of the requirements, in the order in which they are asked for.
UNITS = {"load": "N", "stroke": "m", "speed": "m/s", "life": "s", "envelope": "m"}


def loaded_length(stroke: float, nut_length: _Length) -> _Length:
    """From the bearing to the far end of the nut at the end of its stroke [m]."""
    return stroke + nut_length


def unsupported_length(stroke: float, nut_length: _Length, diameter: _Length) -> _Length:
    """Between the bearings of the screw [m]."""
    return stroke + nut_length + _ENDS * diameter


def screw_length(stroke: float, nut_length: _Length, diameter: _Length) -> _Length:
    """Of the whole screw [m]."""
    return unsupported_length(stroke, nut_length, diameter) + _JOURNALS * diameter
