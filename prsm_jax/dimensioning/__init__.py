"""A first design for five requirements, from the sizes of a catalogue and the rules of strength."""

from ._dimension import Dimensioning as Dimensioning, dimension as dimension
from ._requirements import (
    BUCKLING_SAFETY as BUCKLING_SAFETY,
    SPEED_SHARE as SPEED_SHARE,
    STATIC_SAFETY as STATIC_SAFETY,
    Requirements as Requirements,
)
from ._sizes import nut_outer_diameter as nut_outer_diameter
