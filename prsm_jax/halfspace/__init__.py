"""Contact of true surfaces: half-spaces on a grid, the gap of real flanks, stress below them."""

from ._grid import Grid as Grid, grid_over as grid_over
from ._displacement import normal_displacement as normal_displacement
from ._surface_contact import (
    RESULTS as RESULTS,
    SurfaceContact as SurfaceContact,
    solve_contact as solve_contact,
)
