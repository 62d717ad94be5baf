"""Errors of real parts, and displacements of a nut or of rollers: gaps, and forces on the nut."""

from ._displacements import (
    Displacements as Displacements,
    SideCoupling as SideCoupling,
    joined as joined,
)
from ._free_nut import free_nut_displacements as free_nut_displacements
from ._openings import (
    GapOpening as GapOpening,
    error_names as error_names,
    gap_opening as gap_opening,
)
from ._places import Places as Places, contact_places as contact_places
from ._reaction import NutForces as NutForces, forces_on_nut as forces_on_nut
