"""The whole report as a list of sections."""

import collections
from collections.abc import Callable

from ...geometry import Finding
from ...programs import origin_of
from ...text import show
from ..motion_charts import efficiency_text
from ..results import ReportData, largest_pressure, largest_shared_pressure, words_of_fault
from ._analysis_sections import (
    contact_section,
    steady_section,
    transient_section,
    vibration_section,
)
from ._design_sections import optimisation_section, sensitivity_section
from ._foundations import left_out_section, provenance_section, with_assumptions
from ._inputs_section import inputs_section
from ._mechanism_section import findings_section, mechanism_section
from ._section import Section
from ._status_section import status_section
from ._strength_section import sharing_section, strength_section

_Maker = Callable[[ReportData], Section | None]
_own: dict[str, tuple[str, _Maker]] = {}


def report_section(anchor: str, title: str) -> Callable[[_Maker], _Maker]:
    """Add a section of your own to the report, before what is left out and the provenance.

    The function makes it from the report's data, or returns `None` if they contain nothing for it.
    It may be defined again, as when a cell of a notebook is run twice.

    **Arguments:**

    - `anchor`: its name in links, different from those of other sections.
    - `title`: its heading.

    **Raises:** `ValueError` if another section has the anchor.
    """
    if anchor in {row[0] for row in _sections()}:
        raise ValueError(f"the section {anchor!r} exists already; choose another anchor")

    def register(make: _Maker) -> _Maker:
        before = _own.get(anchor)
        if before is not None and origin_of(before[1]) != origin_of(make):
            raise ValueError(f"the section {anchor!r} exists already; choose another anchor")
        _own[anchor] = (title, make)
        return make

    return register


def _sections() -> tuple[tuple[str, str, _Maker], ...]:
    """Anchor, title and maker of the package's own sections, in the order of reading."""
    return (
        ("status", "Status", status_section),
        ("summary", "In short", _summary),
        ("findings", "Findings", findings_section),
        ("inputs", "Inputs", inputs_section),
        ("mechanism", "Mechanism", mechanism_section),
        ("contact", "Thread contact", contact_section),
        ("load_sharing", "Load sharing", sharing_section),
        ("vibration", "Vibration", vibration_section),
        ("steady", "Steady state", steady_section),
        ("transient", "Transient", transient_section),
        ("strength", "Strength and life", strength_section),
        ("sensitivity", "Sensitivities", sensitivity_section),
        ("optimisation", "Optimisation", optimisation_section),
        ("left_out", "Assumptions and parts left out", left_out_section),
        ("provenance", "Provenance", provenance_section),
    )


def report_sections(data: ReportData) -> tuple[Section, ...]:
    """All sections for which there are data, in the order of reading.

    A section that cannot be made is included, and says so.
    """
    *first, left_out, provenance = _sections()
    own = [(anchor, title, make) for anchor, (title, make) in _own.items()]
    makers = (*first, *own, left_out, provenance)
    sections = [_made(anchor, title, data, make) for anchor, title, make in makers]
    return tuple(section for section in sections if section is not None)


def _made(
    anchor: str, title: str, data: ReportData, make: Callable[[ReportData], Section | None]
) -> Section | None:
    """A section with its assumptions, or one that says why it could not be made."""
    try:
        section = make(data)
        return None if section is None else with_assumptions(section, data)
    except (OSError, ImportError):
        raise
    except Exception as error:
        return Section(anchor, title, faults=(f"The section is missing: {words_of_fault(error)}",))


def _summary(data: ReportData) -> Section:
    words = []
    if data.optimisation is not None and not data.feasible:
        words.append(data.optimisation.in_a_sentence())
    point, steady = data.mechanism.operating_point, data.steady
    if point is not None and steady is not None:
        at = f"At {show(float(point.speed), 'rad/s')} and {show(float(point.load), 'N')} the "
        if steady.has_efficiency and bool(steady.valid):
            torque = show(float(steady.drive_torque), "N·m")
            turning = data.mechanism.stages[0].thread.family.turning
            words.append(
                f"{at}efficiency is {efficiency_text(steady)} and the torque at the {turning} "
                f"{torque}."
            )
        else:
            words.append(f"{at}mechanism has no efficiency; {steady.result}.")
    if data.contacts is not None:
        words.append(_pressure_in_a_sentence(data))
    if data.improved is None:
        words += _need_attention("", data.findings)
    else:
        words += _need_attention(" of the start", data.findings)
        after = " of the optimum" if data.feasible else " of the best design found"
        words += _need_attention(after, data.improved.findings)
    if data.optimisation is not None and data.feasible:
        words.append(data.optimisation.in_a_sentence())
    return Section("summary", "In short", tuple(words))


def _pressure_in_a_sentence(data: ReportData) -> str:
    """Largest pressure: at equal sharing, and of the most loaded thread if it is modelled."""
    equal, point = show(largest_pressure(data), "Pa"), data.mechanism.operating_point
    start = "The largest contact pressure"
    if point is not None:
        # A duty cycle may have larger loads, which the static safety is for.
        start += f" at the load of the operating point ({show(float(point.load), 'N')})"
    if len(data.shared) < len(data.mechanism.stages):
        return f"{start} is {equal}."
    worst = max(largest_shared_pressure(data, index) for index in data.shared)
    return (
        f"{start} is {show(worst, 'Pa')}, on the most loaded thread; it would be {equal} if all "
        "threads shared the load equally."
    )


def _need_attention(design: str, findings: tuple[Finding, ...] | None) -> list[str]:
    """Errors and warnings of one design by name, errors first."""
    if findings is None:
        return [f"The checks{design} could not be made."]
    serious = sorted((f for f in findings if f.severity != "note"), key=lambda f: f.severity)
    if not serious:
        return []
    counts = collections.Counter(
        f"{f.name.replace('_', ' ')} (error)" if f.severity == "error" else f.name.replace("_", " ")
        for f in serious
    )
    names = ", ".join(f"{n} ({k})" if k > 1 else n for n, k in counts.items())
    kinds = collections.Counter(f.severity for f in serious)
    counted = " and ".join(f"{k} {kind}{'s' * (k > 1)}" for kind, k in sorted(kinds.items()))
    return [f"The checks{design} found {counted}: {names}."]
