"""The status of every design: checks and limits of the design problem, and the worst of them."""

import collections
import math
from collections.abc import Sequence

from ...findings import StrengthCheck
from ...mechanism import Mechanism
from ...optimisation import LimitReading
from ...text import (
    MINUS,
    display_unit,
    in_unit,
    number,
    related,
    show,
    state_without_efficiency,
    with_label,
)
from .._parts import component_words
from .._style import readable
from ..results import ReportData
from ._section import Section, Table

#: What a check is called where its name does not say it. Static safety is that of the largest load
#: of operating point and duty cycle, contact pressures are those of the operating point alone.
_LABELS = {
    "static_safety": "static safety under the largest load",
    "max_pressure_shared": "contact pressure at the operating point, most loaded thread",
    "max_pressure": "contact pressure at the operating point, equal sharing",
    "preloaded_pressure": "contact pressure at the operating point with preload, equal sharing",
    "rating_life": "rating life, with its factors",
    "rating_life_time": "rating life L10h",
    "buckling": "safety against buckling",
    "screw_speed": "speed of the body that turns",
    "contact_truncation": "share of the ellipse past the {}",
    "false_brinelling": "amplitude of oscillation",
    "jamming": "friction coefficient (jamming)",
    "self_locking": "efficiency when the load drives",
}
#: Checks whose value is a share.
_IN_PER_CENT = ("contact_truncation",)
#: Where drag holds a load near 0, the efficiency tends to −∞; a number below −1e6 stands for it.
_HELD = 1e6
#: What the margins of a table of checks are.
MARGINS_IN_WORDS = (
    "A margin of 0 is the limit. A margin in % is the part of a capacity that is left before the "
    f"limit (buckling with a safety of 2: 1/2 {MINUS} load / buckling load), the life beyond the "
    "required one as a share of it, or a difference of efficiencies."
)
#: What these limits are called.
LIMITS = "Limits of the design problem ([optimise])"
#: The same where the limit is a lower one: rollers without lead have no coefficient that jams.
_LABELS_AT_LEAST = {"jamming": "share of the axial thread force that carries load"}


def label_of(check: StrengthCheck) -> str:
    """What a check is called in a table."""
    words = _LABELS.get(check.name, readable(check.name))
    if not check.at_most:
        words = _LABELS_AT_LEAST.get(check.name, words)
    if "{}" in words:
        words = words.format(check.subject)
    elif check.subject:
        words = f"{words}, {check.subject}"
    return f"{words} (at {check.at_load})" if check.at_load else words


def value_text(check: StrengthCheck) -> str:
    """The value of a check with its unit; a load of 0 has no efficiency."""
    if check.name == "self_locking":
        if math.isnan(check.value) and check.verdict == "no limit":
            return "not defined (no load)"
        if check.value < -_HELD:
            return "self-locking"
    return _shown(check, check.value)


def _shown(check: StrengthCheck, value: float) -> str:
    """Value or limit of a check with its unit: shares in per cent, as the messages have them."""
    if check.name in _IN_PER_CENT:
        return with_label(number(100 * value), "%", " ")
    return show(value, check.unit, check.name)


def limit_text(check: StrengthCheck) -> str:
    """The limit of a check with its unit; empty if it has none."""
    if check.limit is None:
        return ""
    sense = "at most" if check.at_most else "at least"
    return related(sense, _shown(check, check.limit))


def margin_text(check: StrengthCheck) -> str:
    """The margin of a check: in per cent if it is relative, else with its unit."""
    if check.margin is None:
        return ""
    if check.margin_unit != "1":
        return show(check.margin, check.margin_unit)
    share = 100 * check.margin
    return with_label(number(share, 3), "%", " ") if abs(share) < 1e4 else "large"


def checks_table(caption: str, checks: Sequence[StrengthCheck], stages: int) -> Table:
    """Checks as a table: value, limit, margin and verdict of each."""
    many = stages > 1
    head = ("check", *(("stage",) if many else ()), "value", "limit", "margin", "verdict")
    rows = tuple(
        (
            label_of(one),
            *((str(one.stage) if one.stage else "all",) if many else ()),
            value_text(one),
            limit_text(one),
            margin_text(one),
            one.verdict,
        )
        for one in checks
    )
    return Table(caption, head, rows)


def limit_cells(one: LimitReading) -> tuple[str, str, str]:
    """Value, limit and margin of a limit as text, value and limit in the same unit."""
    known = not math.isnan(one.value)
    shown = display_unit(one.unit, [one.value, one.limit] if known else [one.limit], one.quantity)
    limit = related(one.sense, in_unit(one.limit, shown))
    if not known:
        return "", limit, ""
    value = state_without_efficiency(one.quantity, one.value) or in_unit(one.value, shown)
    if not math.isfinite(one.margin):
        return value, limit, ""
    if not one.limit:
        return value, limit, in_unit(one.margin, shown, 3)
    return value, limit, with_label(number(100 * one.margin, 3), "%", " ")


def point_words(one: LimitReading) -> str:
    """The operating point of the design problem at which a limit was read; empty without one."""
    points = ((one.speed, "rad/s"), (one.load, "N"))
    words = [show(value, unit) for value, unit in points if value is not None]
    return f" at {' and '.join(words)}" if words else ""


def limits_table(caption: str, limits: Sequence[LimitReading]) -> Table:
    """Limits of the design problem as a table: value, limit, margin and verdict of each."""
    rows = tuple(
        (component_words(one.quantity) + point_words(one), *limit_cells(one), one.verdict)
        for one in limits
    )
    return Table(caption, ("quantity", "value", "limit", "margin", "verdict"), rows)


def limits_in_words(limits: Sequence[LimitReading] | None) -> str:
    """How many limits of the design problem are broken, in a sentence; empty without limits."""
    if limits is None:
        return f"The l{LIMITS[1:]} could not be evaluated."
    if not limits:
        return ""
    counts = collections.Counter(one.verdict for one in limits)
    said = [
        f"{counts[verdict]} {one if counts[verdict] == 1 else several}"
        for verdict, one, several in (
            ("pass", "is kept", "are kept"),
            ("fail", "is broken", "are broken"),
            ("not evaluated", "was not evaluated", "were not evaluated"),
        )
        if counts[verdict]
    ]
    kind = LIMITS.removeprefix("Limits")
    return f"Of {len(limits)} limit{'s' * (len(limits) > 1)}{kind} {', '.join(said)}."


def where_read(mechanism: Mechanism) -> str:
    """What the values of the table of limits are those of, in a sentence or two."""
    problem = mechanism.design_problem
    where = "at the operating point of the mechanism"
    if problem is not None and problem.nut_speed is not None:
        where = f"at the speed at which the nut moves with {show(problem.nut_speed, 'm/s')}"
    elif problem is not None and problem.operating_points:
        where = "at that operating point of [optimise] at which the margin is least"
    words = (
        f"Values beside the limits of the design problem are those {where}; a margin in % is the "
        "distance from the limit as a share of it."
    )
    if problem is not None and problem.tolerance_sigmas is not None:
        words += (
            " They are those of the nominal numbers; a search also adds "
            f"{problem.tolerance_sigmas:g} standard deviations due to [tolerances]."
        )
    return words


def _in_a_sentence(data: ReportData, name: str) -> str:
    counts = collections.Counter(one.verdict for one in data.checks or ())
    counted = [
        f"{counts[verdict]} {one if counts[verdict] == 1 else several}"
        for verdict, one, several in (
            ("pass", "keeps its limit", "keep their limit"),
            ("warning", *(f"{verb} beyond a limit of severity warning" for verb in ("is", "are"))),
            ("fail", "fails", "fail"),
            ("no limit", "has no limit", "have no limit"),
        )
        if counts[verdict]
    ]
    found = collections.Counter(one.severity for one in data.findings or ())
    listed = [f"{found[s]} {s}{'s' * (found[s] > 1)}" for s in ("error", "warning") if found[s]]
    start = f"Status of the {name}: " if name else "Status: "
    words = f"{start}{data.status}."
    if counted:
        total = sum(counts.values())
        words += f" Of {total} check{'s' * (total > 1)} {', '.join(counted)}."
    if data.checks is not None and counts["no limit"] == counts.total():
        words += " No check has a limit."
    if limited := limits_in_words(data.limits):
        words += f" {limited}"
    if data.findings is None or data.checks is None:
        return words + " Not everything could be checked."
    return words + f" The findings have {' and '.join(listed) or 'no error and no warning'}."


def status_section(data: ReportData) -> Section:
    """Status of every design, its checks and the limits of its design problem.

    The status of the last design is that of the report. The margins of checks are those of `check`
    and of the optimiser.
    """
    designs, stages = data.designs, len(data.mechanism.stages)
    tables: tuple[Table, ...] = ()
    for name, one in designs.items():
        of_design = f": {name}" if name else ""
        if one.checks:
            tables += (checks_table(f"Checks{of_design}", one.checks, stages),)
        if one.limits:
            tables += (limits_table(f"{LIMITS}{of_design}", one.limits),)
    words = tuple(_in_a_sentence(one, name) for name, one in designs.items())
    if data.optimisation is not None and not data.feasible:
        words = (data.optimisation.in_a_sentence(), *words)
    if any(one.checks for one in designs.values()):
        words += (MARGINS_IN_WORDS,)
    words += tuple(
        dict.fromkeys(where_read(one.mechanism) for one in designs.values() if one.limits)
    )
    last = list(designs.values())[-1]
    return Section("status", "Status", words, tables, status=last.status)
