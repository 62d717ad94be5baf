"""The status of every design: checks with limit, margin and verdict, and the worst of them."""

import collections
from collections.abc import Sequence

from ...findings import StrengthCheck
from ...text import MINUS, number, related, show, with_label
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
#: Where drag holds a load of 0, the efficiency is −∞; a number below −1e6 stands for it.
_HELD = 1e6
#: What the margins of a table of checks are.
MARGINS_IN_WORDS = (
    "A margin of 0 is the limit. A margin in % is the part of a capacity that is left before the "
    f"limit (buckling with a safety of 2: 1/2 {MINUS} load / buckling load), the life beyond the "
    "required one as a share of it, or a difference of efficiencies."
)
#: The same where the limit is a lower one: rollers without lead have no coefficient that jams.
_LABELS_AT_LEAST = {"jamming": "share of the axial thread force that carries load"}


def label_of(check: StrengthCheck) -> str:
    """What a check is called in a table."""
    words = _LABELS.get(check.name, readable(check.name))
    if not check.at_most:
        words = _LABELS_AT_LEAST.get(check.name, words)
    if "{}" in words:
        return words.format(check.subject)
    return f"{words}, {check.subject}" if check.subject else words


def value_text(check: StrengthCheck) -> str:
    """The value of a check with its unit; a load of 0 that is held has no efficiency."""
    if check.name == "self_locking" and check.value < -_HELD:
        return "self-locking"
    return show(check.value, check.unit, check.name)


def limit_text(check: StrengthCheck) -> str:
    """The limit of a check with its unit; empty if it has none."""
    if check.limit is None:
        return ""
    sense = "at most" if check.at_most else "at least"
    return related(sense, show(check.limit, check.unit, check.name))


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
    if data.findings is None or data.checks is None:
        return words + " Not everything could be checked."
    return words + f" The findings have {' and '.join(listed) or 'no error and no warning'}."


def status_section(data: ReportData) -> Section:
    """Status of every design, and its checks; the status of the last design is that of the report.

    The margins are those of `check` and of the optimiser.
    """
    designs = data.designs
    tables = tuple(
        checks_table(
            f"Checks: {name}" if name else "Checks", one.checks, len(data.mechanism.stages)
        )
        for name, one in designs.items()
        if one.checks
    )
    words = tuple(_in_a_sentence(one, name) for name, one in designs.items())
    if data.optimisation is not None and not data.feasible:
        words = (data.optimisation.in_a_sentence(), *words)
    if tables:
        words += (MARGINS_IN_WORDS,)
    last = list(designs.values())[-1]
    return Section("status", "Status", words, tables, status=last.status)
