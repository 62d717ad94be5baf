"""The whole report as a list of sections."""

import collections
import platform

from .._display_units import show
from .._version import __version__
from ._analysis_sections import (
    contact_section,
    steady_section,
    transient_section,
    vibration_section,
)
from ._assumptions import with_assumptions
from ._data import ReportData
from ._design_sections import optimisation_section, sensitivity_section
from ._mechanism_section import findings_section, mechanism_section
from ._section import Section, Table
from ._strength_section import sharing_section, strength_section


def report_sections(data: ReportData) -> tuple[Section, ...]:
    """Every section that the data have something for, in the order of reading."""
    sections = [
        _summary(data),
        mechanism_section(data),
        findings_section(data),
        contact_section(data),
        sharing_section(data),
        vibration_section(data),
        steady_section(data),
        transient_section(data),
        strength_section(data),
        sensitivity_section(data),
        optimisation_section(data),
        _provenance(data),
    ]
    return tuple(with_assumptions(section, data) for section in sections if section is not None)


def _summary(data: ReportData) -> Section:
    words = []
    point, steady = data.mechanism.operating_point, data.steady
    if point is not None and steady is not None and bool(steady.valid):
        words.append(
            f"At {show(float(point.speed), 'rad/s')} and {show(float(point.load), 'N')} the "
            f"efficiency is {100 * float(steady.efficiency):.2f} % and the torque at the screw "
            f"{show(abs(float(steady.drive_torque)), 'N·m')}."
        )
    if data.contacts is not None:
        worst = max(
            float(getattr(c, side).hertz.max_pressure)
            for c in data.contacts
            for side in ("screw", "nut")
        )
        words.append(f"The largest contact pressure is {show(worst, 'Pa')}.")
    serious = [f for f in data.findings if f.severity != "note"]
    if serious:
        counts = collections.Counter(f.name.replace("_", " ") for f in serious)
        names = ", ".join(f"{n} ({k})" if k > 1 else n for n, k in counts.items())
        words.append(f"The checks found {len(serious)} thing(s) that need attention: {names}.")
    if data.optimisation is not None:
        words.append(data.optimisation.in_a_sentence())
    return Section("summary", "In short", tuple(words))


def _provenance(data: ReportData) -> Section:
    import jax

    bits = "64" if data.mechanism.stages[0].thread.lead.dtype.itemsize == 8 else "32"
    rows = [
        ("prsm_jax", __version__),
        ("JAX", jax.__version__),
        ("Python", platform.python_version()),
    ]
    rows.append(("numbers", f"float{bits}"))
    if data.source:
        rows.append(("mechanism from", data.source))
    if data.command:
        rows.append(("command", data.command))
    tables = [Table("Made with", ("", ""), tuple(rows))]
    if data.left_out:
        tables.append(Table("Not analysed", ("part", "because"), tuple(data.left_out)))
    return Section("provenance", "Provenance", (), tuple(tables))
