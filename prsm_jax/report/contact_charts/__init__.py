"""Charts of contacts: ellipses, pressures, stresses below the surface, loads of threads."""

from ._contact_ellipses import contact_ellipses as contact_ellipses
from ._flank_lines import FlankLine as FlankLine, flank_lines as flank_lines
from ._force_deflection_chart import force_deflection_chart as force_deflection_chart
from ._line_contact_chart import line_contact_chart as line_contact_chart
from ._pressure_map import pressure_map as pressure_map, pressure_profiles as pressure_profiles
from ._published_pressure import published_pressure as published_pressure
from ._roller_force_chart import roller_force_chart as roller_force_chart
from ._shared_loads import shared_loads as shared_loads
from ._stress_section import stress_section as stress_section
from ._subsurface_chart import subsurface_chart as subsurface_chart
from ._thread_load_chart import thread_load_chart as thread_load_chart
