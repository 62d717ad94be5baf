"""Stresses below the surface of a contact."""

from ._axis_stress import axis_stress as axis_stress
from ._line_stress import line_subsurface_stress as line_subsurface_stress
from ._stress_measures import (
    max_shear_stress as max_shear_stress,
    principal_stresses as principal_stresses,
    von_mises_stress as von_mises_stress,
)
from ._stress_peak import (
    AxisMeasure as AxisMeasure,
    StressPeak as StressPeak,
    stress_peak as stress_peak,
    stress_peak_on_axis as stress_peak_on_axis,
)
from ._subsurface import subsurface_stress as subsurface_stress
