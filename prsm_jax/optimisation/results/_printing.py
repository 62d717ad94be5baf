"""An optimum as text: start and optimum, limits, verdict, findings."""

import textwrap
from collections import Counter
from collections.abc import Iterator
from typing import Any

from ...findings import margins_of
from ...geometry import Finding
from ...mechanism import find_parameters, follows_in_words
from ...text import TextTable, display_unit, state_without_efficiency
from ..search import respected


def text_of(best: Any, width: int | None) -> str:
    """An `Optimum` as a table of start and optimum in an engineer's units, and the verdict.

    A design that violates a limit is not called an optimum, and the first line says so.
    """
    first = [] if best.feasible else [f"NO FEASIBLE DESIGN: {best.message}"]
    verdict = _verdict(best)
    if width is not None:
        first, verdict = (
            [part for line in lines for part in textwrap.wrap(line, width)]
            for lines in (first, verdict)
        )
    return "\n".join([*first, _table(best).text(width), *verdict])


def _dependents(best: Any) -> list[str]:
    """For each design variable a line on the dimensions that follow it and those that stay."""
    names = [variable.name for variable in best.problem.variables]
    lines = (follows_in_words(best.mechanism, name, names) for name in names)
    return [line for line in lines if line]


def _table(best: Any) -> TextTable:
    """Start and optimum in an engineer's units."""
    terms = " + ".join(
        (f"{term.weight:g} " if term.weight != 1 else "") + term.quantity
        for term in best.problem.objectives
    )
    sense = "/".join(dict.fromkeys(term.sense for term in best.problem.objectives))
    rows = []

    def add(words: str, unit: str, quantity: str, start: float, end: float, limits, state: str):
        numbers = [start, end, *(limit for _, limit in limits)]
        shown = display_unit(unit, numbers, quantity)
        name = f"{words} [{shown.label}]" if shown.label else words
        texts = [f"{sign} {shown(limit):.6g}".strip() for sign, limit in limits]
        joined = " to ".join(texts) if limits and limits[0][0] == "" else " ".join(texts)
        ends = [state_without_efficiency(quantity, v) or shown(v) for v in (start, end)]
        rows.append((name, *ends, joined, state))

    first, *others = best.problem.objectives
    weighted = bool(others) or first.weight != 1
    unit, quantity = ("1", "") if weighted else (best.objective_unit, first.quantity)
    words = f"{sense} {terms}"
    add(words, unit, quantity, best.start.objective, best.optimum.objective, (), "")
    bounds = {v.name: (("", v.lower), ("", v.upper)) for v in best.problem.variables}
    for name, value in best.optimum.variables.items():
        at = best.bounds_active.get(name)
        state = f"at {at} bound" if at else ""
        start, unit = best.start.variables[name], best.variable_units[name]
        add(name, unit, "", start, value, bounds[name], state)
    for report in best.constraints:
        signs = ((">=", report.lower), ("<=", report.upper), ("=", report.equal))
        limits = [(sign, limit) for sign, limit in signs if limit is not None]
        state = "VIOLATED" if not report.satisfied else "active" if report.active else ""
        start = best.start.constraints[report.name]
        add(report.name, report.unit, report.name, start, report.value, limits, state)
    for report in best.margins:
        if report.active or not report.satisfied:
            state = "active" if report.satisfied else "VIOLATED"
            start = best.start.margins[report.name]
            limits = [(">=", report.limit)]
            add(f"check: {report.name}", report.unit, "", start, report.value, limits, state)
    return TextTable("", ("", "start", _final_name(best), "limits", ""), rows)


def _final_name(best: Any) -> str:
    """Name of the final design in the table."""
    return "optimum" if best.feasible else "best found"


def _verdict(best: Any) -> list[str]:
    return [
        *_dependents(best),
        *(_trial_line(one, best) for one in best.choices),
        f"{'converged' if best.converged else 'NOT CONVERGED'}: {best.message}",
        f"method {best.method}; best of {len(best.runs)} starts: number {best.best_run + 1}; "
        f"{best.evaluations} evaluations of values, {best.derivative_evaluations} of derivatives",
        *_finding_lines(best),
    ]


def _trial_line(one: Any, best: Any) -> str:
    """One combination of choices in words."""
    chosen = []
    for name, value in one.choices.items():
        shown = display_unit(find_parameters(best.mechanism, name)[0].unit, [value])
        chosen.append(f"{name} = {shown(value):.6g} {shown.label}".rstrip())
    return f"{', '.join(chosen)}: {one.status}: {one.message}"


def against_limit(name: str, unit: str, value: float, limit: float) -> str:
    """A quantity and the limit that it breaks, in an engineer's unit."""
    shown = display_unit(unit, [value, limit], name)
    numbers = f"{shown(value):.6g} against a limit of {shown(limit):.6g}"
    return f"{name} = {numbers} {shown.label}".rstrip()


#: A limit that is broken by less, relative to itself, is reached.
_ROUNDING = 1e-6


def _broken_at_start(best: Any) -> Iterator[str]:
    """The limits of the problem that the start breaks; its errors of `check` are findings."""
    for report in best.constraints if best.start.usable else ():
        value = best.start.constraints[report.name]
        lower, upper = (
            limit if report.equal is None else report.equal
            for limit in (report.lower, report.upper)
        )
        for limit, sign in ((lower, 1.0), (upper, -1.0)):
            if limit is not None and sign * (limit - value) > _ROUNDING * (abs(limit) or 1.0):
                yield against_limit(report.name, report.unit, value, limit)


def _finding_lines(best: Any) -> Iterator[str]:
    """Errors of start and optimum, and the warnings that only the optimum has, a line each.

    The limits of the problem that the start breaks are one line.

    Other warnings are those of the file, known from `prsm check`: their names and numbers.
    """
    start, end = best.findings_start, best.findings_optimum
    known = {(f.name, f.stage) for f in start}
    yield from _of_design("start", "warnings", start, known)
    if broken := list(_broken_at_start(best)):
        yield f"limits of the optimisation that the start breaks: {'; '.join(broken)}"
    yield from _of_design(_final_name(best), "warnings as at the start", end, known)
    kept = respected(warnings=True)
    limited = {(one.name, one.stage) for one in margins_of(best.mechanism) if kept.keeps(one)}
    caused = [
        f
        for f in end
        if f.severity == "warning"
        and (f.name, f.stage) in limited
        and (f.name, f.stage) not in known
    ]
    if caused and best.feasible and not best.problem.avoid_warnings:
        yield (
            "warnings with a limit can be made constraints: prsm optimise --avoid-warnings, or "
            "avoid_warnings in [optimise]"
        )


def _of_design(
    where: str, words: str, findings: tuple[Finding, ...], known: set[tuple[str, int]]
) -> Iterator[str]:
    """Lines of one design; warnings in `known` are counted by name after `words`."""
    serious = [f for f in findings if f.severity != "note"]
    counted: Counter[str] = Counter()
    for f in serious:
        if f.severity == "warning" and (f.name, f.stage) in known:
            counted[f.name] += 1
        else:
            yield f"prsm check of the {where}: {f.severity} {f.name}, stage {f.stage}: {f.message}"
    if counted:
        names = ", ".join(f"{n} ({k})" if k > 1 else n for n, k in counted.items())
        yield f"prsm check of the {where}: {words}: {names}"
    if not serious:
        yield f"prsm check of the {where}: no errors, no warnings"
