"""Contact of true surfaces: half-spaces on a grid, the gap of real flanks, stress below them."""

from ._displacement import normal_displacement as normal_displacement
from ._flank_contact import FlankContact as FlankContact, flank_contact as flank_contact
from ._flank_gap import (
    FlankGap as FlankGap,
    TangentPlane as TangentPlane,
    flank_gap as flank_gap,
    tangent_plane as tangent_plane,
)
from ._grid import Grid as Grid, grid_over as grid_over
from ._peak import peak_pressure as peak_pressure
from ._ring_contact import ring_contact as ring_contact
from ._subsurface_stress import (
    SubsurfaceStress as SubsurfaceStress,
    subsurface_stress_field as subsurface_stress_field,
)
from ._surface_contact import (
    RESULTS as RESULTS,
    SurfaceContact as SurfaceContact,
    solve_contact as solve_contact,
)
from ._traction import (
    PartialSlip as PartialSlip,
    partial_slip as partial_slip,
    sliding_traction as sliding_traction,
)
