"""Stiffnesses of threads and gears."""

from ._gear import (
    gear_mesh_stiffness as gear_mesh_stiffness,
    ring_roller_stiffness as ring_roller_stiffness,
    tooth_flexibility as tooth_flexibility,
)
from ._threads import (
    ThreadStiffness as ThreadStiffness,
    axial_stiffness as axial_stiffness,
    in_series as in_series,
    loaded_threads as loaded_threads,
    stiffness_under_load as stiffness_under_load,
    thread_stiffness as thread_stiffness,
)
