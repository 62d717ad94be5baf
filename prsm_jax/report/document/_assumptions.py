"""Assumptions behind the numbers of each section."""

import dataclasses

from ...quantities import assumptions, catalogue
from ._data import ReportData
from ._section import Section

#: Quantities that sections show, by anchor; those of other sections come from the data.
_SHOWN = {
    "summary": ("max_pressure", "efficiency"),
    "contact": ("max_pressure", "approach_screw", "approach_nut", "semi_major_screw"),
    "vibration": ("natural_frequencies",),
    "steady": ("efficiency", "carrier_ratio", "contact_force", "loss_power"),
    "transient": ("efficiency", "carrier_ratio", "drive_torque", "contact_force"),
}


def _shown(section: Section, data: ReportData) -> tuple[str, ...]:
    if section.anchor == "strength":
        return tuple(data.strength or ())
    if section.anchor == "sensitivity":
        return tuple(data.sensitivity.quantities)
    if section.anchor == "optimisation" and data.optimisation is not None:
        optimisation = data.optimisation
        names = [one.name for one in optimisation.quantities] + [
            one.quantity for one in optimisation.limits
        ]
        return (*names, *(_SHOWN["summary"] if data.contacts is not None else ()))
    return _SHOWN.get(section.anchor, ())


def with_assumptions(section: Section, data: ReportData) -> Section:
    """A section with the assumptions of the quantities that it shows."""
    known = {quantity.name for quantity in catalogue()}
    names = [name for name in _shown(section, data) if name.partition("[")[0] in known]
    if section.anchor == "summary" and data.contacts is None:
        names.remove("max_pressure")
    return dataclasses.replace(section, assumptions=assumptions(data.mechanism, names))
