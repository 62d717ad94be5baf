"""Parts of the page as HTML, from plain results; text of users is escaped."""

import html
import math
from collections.abc import Iterable, Sequence

import numpy as np

from ..findings import StrengthCheck
from ..geometry import Finding
from ..optimisation import LimitReading, with_limits
from ..report import checks_table, limit_cells, point_words
from ..text import MINUS, display_unit, in_unit, show, state_without_efficiency
from ._improve import Improvement
from ._readings import Numbers, Verdicts
from ._variables import StudioVariable

_STATUS = {
    "pass": "Pass: all limits are kept; no finding is a warning.",
    "warning": "Warning: a check or a finding below is a warning, or a limit was not evaluated.",
    "fail": "Fail: a limit below is broken, or a finding is an error.",
    "no checks": "No checks: the file gives no limit; no finding is a warning.",
}
#: A change below this share of the quantity has no bar.
_NOTHING = 1e-9
#: A relative difference of two designs that is rounding.
_ROUNDING = 1e-12
#: Size of the chart of a search [px].
_WIDE, _HIGH = 320, 90


def words_of(name: str) -> str:
    """A name of the catalogue in words, escaped."""
    return html.escape(name.replace("_", " "))


def labels_of(quantities: Sequence[str]) -> dict[str, str]:
    """Names of quantities and their components in words, escaped: `nut_radius[2]` is of stage 2."""
    found: dict[str, str] = {}
    for name in quantities:
        base, _, number = name.removesuffix("]").partition("[")
        alone = not number or f"{base}[2]" not in quantities
        found[name] = words_of(base) if alone else f"{words_of(base)}, stage {number}"
    return found


def table(head: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> str:
    """A table; the cells are HTML, and the first of each row is its heading."""
    cells = "".join(f'<th scope="col">{one}</th>' for one in head)
    body = "".join(
        f'<tr><th scope="row">{row[0]}</th>'
        + "".join(f"<td>{one}</td>" for one in row[1:])
        + "</tr>"
        for row in rows
    )
    title = f"<caption>{caption}</caption>" if caption else ""
    return f"<table>{title}<thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table>"


def _verdict(word: str) -> str:
    return f'<span class="verdict {word.replace(" ", "-")}">{html.escape(word)}</span>'


def status_html(verdicts: Verdicts, limits: Sequence[LimitReading], stages: int) -> str:
    """The status box: the worst verdict, limits of the file, broken checks, errors and warnings.

    **Arguments:**

    - `verdicts`: checks and findings.
    - `limits`: those of the `[optimise]` table.
    - `stages`: number of stages of the mechanism.
    """
    status = with_limits(verdicts.status, limits)
    parts = [f'<p class="status {status.replace(" ", "-")}" role="status">{_STATUS[status]}</p>']
    if limits:
        labels = labels_of([one.quantity for one in limits])
        rows = [_limit_row(one, labels[one.quantity]) for one in limits]
        head = ("quantity", "value", "limit", "margin", "verdict")
        parts.append(table(head, rows, "Limits of [optimise]"))
    told = [one for one in verdicts.checks if one.verdict in ("warning", "fail")]
    parts.append(checks_html(told, stages))
    findings = [one for one in verdicts.findings if one.severity != "note"]
    parts.append("<h3>Findings</h3>" + (_findings(findings) or "<p>No error and no warning.</p>"))
    return "".join(parts)


def checks_html(checks: Sequence[StrengthCheck], stages: int) -> str:
    """Checks with value, limit, margin and verdict; empty without any."""
    if not checks:
        return ""
    shown = checks_table("Checks", checks, stages)
    rows = [(*map(html.escape, row[:-1]), _verdict(row[-1])) for row in shown.rows]
    return table(tuple(map(html.escape, shown.head)), rows, "Checks")


def notes_html(findings: Sequence[Finding]) -> str:
    """Findings that are for information."""
    return _findings([one for one in findings if one.severity == "note"]) or "<p>none</p>"


def _limit_row(one: LimitReading, label: str) -> tuple[str, ...]:
    value, limit, margin = limit_cells(one)
    words = label + html.escape(point_words(one))
    return words, _unbroken(value), _unbroken(limit), _unbroken(margin), _verdict(one.verdict)


def _unbroken(words: str) -> str:
    """A number with its unit, in one line."""
    return f'<span class="unbroken">{html.escape(words)}</span>'


def _findings(findings: Sequence[Finding]) -> str:
    lines = "".join(map(_finding, findings))
    return f"<ul>{lines}</ul>" if lines else ""


def _finding(one: Finding) -> str:
    where = f", stage {one.stage}" if one.stage else ""
    return (
        f"<li>{_verdict({'error': 'fail'}.get(one.severity, one.severity))} "
        f"<b>{words_of(one.name)}</b>{where}: {html.escape(one.message)}</li>"
    )


def numbers_html(numbers: Numbers, variables: Sequence[StudioVariable]) -> str:
    """Every quantity with its value, and a bar for what 1 % more of each variable does to it.

    The longest bar of a quantity is that of the variable with the largest effect on it.
    """
    names, labels = labels_of(numbers.quantities), {one.name: one.label for one in variables}
    blocks: list[str] = []
    if not numbers.valid:
        blocks.append(
            '<p class="status fail">These numbers cannot be used: the threads do not mesh, or a '
            "contact would have to pull.</p>"
        )
    for row, (name, unit) in enumerate(zip(numbers.quantities, numbers.units, strict=True)):
        value = float(numbers.values[row])
        known = np.abs(numbers.relative[row])
        longest = float(np.max(known, where=np.isfinite(known), initial=0.0))
        stateless = not state_without_efficiency(name, value) and math.isfinite(value)
        bars = "".join(
            _bar(
                labels[variable],
                float(numbers.changes[row, column]),
                float(numbers.relative[row, column]),
                longest,
                display_unit(unit, value, name),
            )
            for column, variable in enumerate(numbers.variables)
            if stateless
        )
        blocks.append(
            f'<section class="quantity"><h3>{names[name]} '
            f'<output data-quantity="{html.escape(name)}" data-si="{value!r}">'
            f"{html.escape(show(value, unit, name))}</output></h3>{bars}</section>"
        )
    return "".join(blocks)


def _bar(label: str, change: float, relative: float, longest: float, unit) -> str:
    """One arrow with its bar and number."""
    nothing = not math.isfinite(relative) or abs(relative) < _NOTHING or not longest
    length = 0.0 if nothing else 100 * min(abs(relative) / longest, 1.0)
    side = "up" if change > 0 else "down"
    arrow = "" if nothing else {"up": "▲", "down": "▼"}[side]
    words = "no effect" if nothing else ("+" if change > 0 else "") + in_unit(change, unit, 3)
    return (
        f'<div class="effect"><span>{html.escape(label)}</span>'
        f'<span class="arrow {side}">{arrow}</span>'
        f'<span class="track"><span class="bar {side}" style="width:{length:.1f}%"></span></span>'
        f'<span class="change">{html.escape(words)}</span></div>'
    )


def comparison_html(kept: Numbers, now: Numbers, variables: Sequence[StudioVariable]) -> str:
    """Design A beside the present one: variables, then quantities, with their differences."""
    rows: list[tuple[str, ...]] = []
    for one in variables:
        before, after = kept.design[one.name], now.design[one.name]
        rows.append(_difference(html.escape(one.label), before, after, one.unit, ""))
    labels = labels_of(now.quantities)
    for name, unit in zip(now.quantities, now.units, strict=True):
        before, after = kept.value(name), now.value(name)
        shown = display_unit(unit, [before, after], name)
        rows.append(_difference(labels[name], before, after, shown, name))
    return table(("", "A", "now", "difference"), rows, "Design A and the present design")


def _difference(label: str, before: float, after: float, unit, quantity: str) -> tuple[str, ...]:
    def cell(value: float) -> str:
        return _unbroken(state_without_efficiency(quantity, value) or in_unit(value, unit))

    change = after - before
    same = abs(change) <= _ROUNDING * max(abs(before), abs(after))
    words = _unbroken("same" if same else ("+" if change > 0 else "") + in_unit(change, unit, 3))
    if not same and before and math.isfinite(change / before):
        share = f"({100 * change / abs(before):+.2f} %)".replace("-", MINUS)
        words += f" {_unbroken(share)}"
    return label, cell(before), cell(after), words


def improvement_html(
    job: Improvement, variables: Sequence[StudioVariable], quantity: str, unit: str
) -> str:
    """The way of a search: its state, the objective of every step, and the best design so far.

    **Arguments:**

    - `job`: the search.
    - `variables`: of the page.
    - `quantity`, `unit`: of the objective [SI]; empty for a sum of several.
    """
    parts = [f'<p role="status"><b>{job.state}</b>: {html.escape(job.message)}</p>']
    steps = [one for one in job.steps if math.isfinite(one.objective)]
    if steps:
        values = [one.objective for one in steps]
        low, high = min(values), max(values)
        shown = display_unit(unit or "1", values, quantity)
        name = words_of(quantity or "objective").capitalize()
        across = _WIDE / max(len(values) - 1, 1)
        span = (high - low) or 1.0
        points = [
            (across * place, _HIGH - _HIGH * (value - low) / span)
            for place, value in enumerate(values)
        ]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        dots = "".join(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" class="'
            f'{"good" if step.keeps_limits else "bad"}"/>'
            for (x, y), step in zip(points, steps, strict=True)
        )
        parts.append(
            f'<svg class="way" viewBox="-6 -6 {_WIDE + 12} {_HIGH + 12}" role="img" '
            f'aria-label="objective by step"><polyline points="{path}"/>{dots}</svg>'
            f"<p>{name} by step, from {in_unit(low, shown)} to {in_unit(high, shown)}; a filled "
            "dot keeps all limits.</p>"
        )
    best = job.best
    if best is not None:
        rows = [
            (html.escape(one.label), in_unit(best[one.name], one.unit))
            for one in variables
            if one.name in best
        ]
        parts.append(table(("", "best so far" if job.running else "best"), rows))
    elif not job.running and job.state != "failed":
        parts.append("<p>No design on the way keeps all limits.</p>")
    return "".join(parts)
