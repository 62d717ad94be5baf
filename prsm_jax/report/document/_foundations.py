"""What the numbers rest on: assumptions, parts left out, the file, and versions."""

import dataclasses
import platform

from ..._version import __version__
from ...dynamics import neglected_inertia
from ...explanation import places
from ...mechanism import Mechanism
from ...quantities import assumptions, catalogue
from ...text import printable
from ..results import Origin, ReportData
from ._section import Section, Table

#: Packages whose versions the numbers depend on.
_PACKAGES = ("jax", "jaxlib", "equinox", "diffrax", "optimistix", "numpy", "scipy")


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
    if section.anchor == "vibration":
        return (*(_SHOWN["vibration"] if data.modes is not None else ()), *(data.axis or ()))
    return _SHOWN.get(section.anchor, ())


def with_assumptions(section: Section, data: ReportData) -> Section:
    """A section with the assumptions of the quantities that it shows, unless it has its own."""
    if section.assumptions:
        return section
    known = {quantity.name for quantity in catalogue()}
    names = [name for name in _shown(section, data) if name.partition("[")[0] in known]
    if section.anchor == "summary" and data.contacts is None:
        names.remove("max_pressure")
    stated = assumptions(data.mechanism, names)
    if section.anchor == "transient" and data.transient is not None:
        stated = (*stated, *neglected_inertia(data.transient, data.mechanism))
    return dataclasses.replace(section, assumptions=stated)


def left_out_section(data: ReportData) -> Section:
    """Assumptions behind all numbers, and optional parts that the mechanism does not have."""
    rows = tuple(
        (one.name, one.without, one.write)
        for one in places(data.mechanism)
        if not one.present and one.kind != "number"
    )
    tables = []
    if rows:
        head = ("part", "effect on the results", "to have it, write")
        tables.append(Table("Parts that the file leaves out", head, rows))
    if data.left_out:
        tables.append(Table("Not analysed", ("part", "because"), tuple(data.left_out)))
    words = ("Optional parts that the file does not give are not modelled (prsm explain).",)
    stated = assumptions(data.mechanism)
    title = "Assumptions and parts left out"
    return Section("left_out", title, words, tuple(tables), assumptions=stated)


def provenance_section(data: ReportData) -> Section:
    """Author, revision, date and file, with its hash, and versions of the programs."""
    return provenance_of(data.mechanism, data.origin, data.source, data.command)


def provenance_of(mechanism: Mechanism, origin: Origin, source: str, command: str) -> Section:
    """The section of `provenance_section`.

    **Arguments:**

    - `mechanism`: the mechanism, whose author and revision hold unless the origin has others.
    - `origin`: its file, and who made the report.
    - `source`: what was given to `prsm_jax.load`; empty if nothing was.
    - `command`: the command that made the report; empty if none did.
    """
    from importlib.metadata import PackageNotFoundError, version

    blank = "…" * 12
    signed = [
        ("author", printable(origin.author or mechanism.author) or blank),
        ("revision", printable(origin.revision or mechanism.revision) or blank),
        ("date", printable(origin.date) or blank),
        ("signature", blank),
    ]
    rows = []
    if source:
        rows.append(("mechanism from", source))
    if origin.sha256:
        rows.append(("SHA-256 of this file", origin.sha256))
    rows += [("changed on the command line", one) for one in origin.settings]
    if command:
        rows.append(("command", command))
    bits = "64" if mechanism.stages[0].thread.lead.dtype.itemsize == 8 else "32"
    rows += [("prsm_jax", __version__), ("Python", platform.python_version())]
    for name in _PACKAGES:
        try:
            rows.append((name, version(name)))
        except PackageNotFoundError:
            continue
    rows.append(("numbers", f"float{bits}"))
    tables = (
        Table("Responsible", ("", ""), tuple(signed)),
        Table("Made with", ("", ""), tuple(rows)),
    )
    return Section("provenance", "Provenance", (), tables)
