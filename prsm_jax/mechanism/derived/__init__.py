"""Masses, sections, and whether dimensions are possible."""

from ._masses import (
    body_inertia as body_inertia,
    body_mass as body_mass,
    material_of as material_of,
    mean_roller_inertia as mean_roller_inertia,
    mean_roller_mass as mean_roller_mass,
    nut_outer_radius as nut_outer_radius,
    nut_unit_mass as nut_unit_mass,
    stage_mass as stage_mass,
    tilting_inertia as tilting_inertia,
)
from ._possible import numbers_possible as numbers_possible
from ._sections import screw_root_radius as screw_root_radius, screw_section as screw_section
from ._thread_sections import (
    ThreadHeights as ThreadHeights,
    ThreadSection as ThreadSection,
    pointed_height as pointed_height,
    thread_heights as thread_heights,
    thread_section as thread_section,
)
