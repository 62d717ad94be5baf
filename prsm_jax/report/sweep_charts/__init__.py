"""Charts of sweeps: lines, maps, slices and points, with the limits of constraints."""

from ._sweep_figure import sweep_figure as sweep_figure
from ._sweep_map import sweep_map as sweep_map
