"""Tables of a study in an engineer's units."""

import math
from typing import Any

import numpy as np

from ..optimisation import LIMIT_ROOM
from ..text import NOT_DEFINED, DisplayUnit, TextTable, display_unit, state_without_efficiency
from ._gradients import words
from ._parts import StudyParts
from ._variants import Variant, best_of

#: Magnitude of a cosine, or of a change in %, below which it is the rounding of its parts.
ROUNDING = 1e-6


def tables_of(study: StudyParts) -> dict[str, tuple[TextTable, ...]]:
    """All tables, by the part of the study that they belong to."""
    return {
        "drivers": (_drivers(study), _quantities(study), _present(study)),
        "conflict": (_conflicts(study), _by_driver(study)),
        "front": (_front(study), _gradients(study)) if study.front.points else (),
        "variants": (_changes(study), *_found_without(study)) if study.variants else (),
    }


def unit_of_driver(study: StudyParts, name: str) -> DisplayUnit:
    """The unit of a driver in all tables."""
    one = next(d for d in study.problem.drivers if d.name == name)
    return display_unit(one.unit, (one.lower, one.upper))


def unit_of_quantity(study: StudyParts, name: str) -> DisplayUnit:
    """The unit of a quantity in all tables, chosen for its largest value in the map."""
    values = study.map.values[name]
    known = map(float, values[np.isfinite(values)])
    return display_unit(study.problem.units[name], known, name)


def _drivers(study: StudyParts) -> TextTable:
    rows = []
    for one in study.problem.drivers:
        shown = unit_of_driver(study, one.name)
        numbers = [float(shown(value)) for value in (one.present, one.lower, one.upper)]
        rows.append(
            (shown.heading(words(one.name)), *numbers, len(study.map.coordinates[one.name]))
        )
    return TextTable("Drivers", ("driver", "present", "from", "to", "values"), rows)


def _limit_words(study: StudyParts, name: str) -> str:
    shown = unit_of_quantity(study, name)
    texts = []
    for one in study.problem.limits:
        if one.quantity == name:
            sides = ((">=", one.lower), ("<=", one.upper), ("=", one.equal))
            texts += [f"{sign} {shown(v):.6g}" for sign, v in sides if v is not None]
    return " and ".join(texts)


def _quantities(study: StudyParts) -> TextTable:
    rows = []
    for name in study.problem.names:
        shown, values = unit_of_quantity(study, name), study.map.values[name]
        known = values[np.isfinite(values)]
        present = float(study.designs.values[name][0])
        ends = [float(known.min()), float(known.max())] if known.size else [math.nan] * 2
        cells: list[Any] = [
            state_without_efficiency(name, value) or float(shown(value))
            for value in (present, *ends)
        ]
        sense = study.problem.senses.get(name, "")
        rows.append((shown.heading(words(name)), *cells, sense, _limit_words(study, name)))
    head = ("quantity", "present design", "smallest in the map", "largest in the map", "sense")
    return TextTable("Quantities", (*head, "limit"), rows)


def _present(study: StudyParts) -> TextTable:
    drivers = [one.name for one in study.problem.drivers]
    rows = [
        (words(name), *(_signed(study.present_elasticities[name][by]) for by in drivers))
        for name in study.problem.names
    ]
    return TextTable(
        "Present design: relative change in % for 1 % more of each driver",
        ("quantity", *map(words, drivers)),
        rows,
    )


def _signed(value: float) -> str:
    return f"{value:+.3f}" if math.isfinite(value) else NOT_DEFINED


def _percent(share: float) -> float:
    return 100 * share if math.isfinite(share) else math.nan


def _unrounded(value: float) -> float:
    """A number for the printer of the table, which rounds it; what rounding has left is 0."""
    return 0.0 if abs(value) < ROUNDING else float(value)


def _conflicts(study: StudyParts) -> TextTable:
    rows = []
    for one in study.conflicts:
        lowest, highest = one.range
        numbers = [_unrounded(value) for value in (one.present, lowest, highest)]
        shares = [_percent(one.share), _percent(one.share_allowed)]
        second = words(one.second) + (" (limit)" if one.limit else "")
        rows.append((words(one.first), second, *numbers, *shares))
    return TextTable(
        "Conflicts: cosine of the angle between elasticities, and share of designs below 0",
        (
            "quantity",
            "against",
            "present design",
            "lowest",
            "highest",
            "conflict [% of the map]",
            "conflict [% of allowed designs]",
        ),
        rows,
    )


def _by_driver(study: StudyParts) -> TextTable:
    drivers = [one.name for one in study.problem.drivers]
    rows = [
        (
            words(one.first),
            words(one.second) + (" (limit)" if one.limit else ""),
            *(_percent(one.by_driver[name]) for name in drivers),
        )
        for one in study.conflicts
    ]
    return TextTable(
        "Share of the map [%] in which more of a driver improves one quantity, worsens the other",
        ("quantity", "against", *map(words, drivers)),
        rows,
    )


def _front(study: StudyParts) -> TextTable:
    """Present design and points: objectives, other quantities, drivers, and active limits."""
    front, problem = study.front, study.problem
    names = [*problem.objectives, *(one for one in problem.senses if one not in problem.objectives)]
    quantities = [(name, unit_of_quantity(study, name)) for name in names]
    drivers = [(one.name, unit_of_driver(study, one.name)) for one in problem.drivers]
    rows = []
    present = ({one.name: one.present for one in problem.drivers}, ("present",))
    points = [(one.variables, (str(i + 1),)) for i, one in enumerate(front.points)]
    for index, (variables, label) in enumerate([present, *points]):
        at = [float(study.designs.values[name][index]) for name, _ in quantities]
        cells: list[Any] = [
            state_without_efficiency(name, value) or float(shown(value))
            for (name, shown), value in zip(quantities, at, strict=True)
        ]
        active = front.points[index - 1].active if index else _broken(study)
        ends = [float(shown(variables[name])) for name, shown in drivers]
        rows.append((*label, *cells, *ends, ", ".join(map(words, active))))
    head = [shown.heading(words(name)) for name, shown in (*quantities, *drivers)]
    return TextTable("Front", ("design", *head, "active limits"), rows)


def _broken(study: StudyParts) -> tuple[str, ...]:
    """Limits that the present design violates."""
    broken = [
        f"breaks {name}"
        for name, violation in study.designs.violations.items()
        if float(violation[0]) > LIMIT_ROOM
    ]
    if bool(study.designs.error[0]):
        broken.append("error of check")
    return tuple(broken)


def _gradients(study: StudyParts) -> TextTable:
    drivers = [one.name for one in study.problem.drivers]
    pairs = [(name, by) for name in study.problem.objectives for by in drivers]
    rows = [
        (
            str(index + 1),
            *(_signed(one.elasticities[name][by]) for name, by in pairs),
            *((_signed(one.exchange),) if len(study.problem.objectives) == 2 else ()),
        )
        for index, one in enumerate(study.gradients)
    ]
    head = [f"{words(name)} by {words(by)}" for name, by in pairs]
    if len(study.problem.objectives) == 2:
        first, second = map(words, study.problem.objectives)
        head.append(f"{first} per % of {second} along the front")
    return TextTable("Gradients on the front, relative, in % per %", ("design", *head), rows)


def _changes(study: StudyParts) -> TextTable:
    """Change of every quantity without each part."""
    rows = []
    for one in study.variants:
        if not one.changes:
            rows.append((words(one.name), one.error, math.nan, math.nan, math.nan))
            continue
        for name in study.problem.senses:
            change = 100 * one.changes[name]
            known = change[1:][np.isfinite(change[1:])]
            ends = [float(known.min()), float(known.max())] if known.size else [math.nan] * 2
            rows.append(
                (words(one.name), words(name), *(_unrounded(v) for v in (change[0], *ends)))
            )
    return TextTable(
        "Relative change of quantities without a part of the physics, in %",
        ("without", "quantity", "present design", "front: lowest", "front: highest"),
        rows,
    )


def _found_without(study: StudyParts) -> list[TextTable]:
    """Best designs with and without each part, and its front with complete physics."""
    drivers = [(one.name, unit_of_driver(study, one.name)) for one in study.problem.drivers]
    rows = []
    for objective in study.problem.objectives:
        cases = [("nothing", best_of(study.front, objective))]
        cases += [(one.name, one.best(objective)) for one in study.variants]
        rows += [
            (words(objective), words(name), *(float(shown(best[d])) for d, shown in drivers))
            for name, best in cases
            if best
        ]
    head = [shown.heading(words(name)) for name, shown in drivers]
    tables = []
    if rows:
        title = "Best design for each objective, without a part of the physics"
        tables.append(TextTable(title, ("best in", "without", *head), rows))
    judged = [one for one in study.variants if one.front is not None and one.front.points]
    if judged:
        tables.append(
            TextTable(
                "Fronts found without a part, computed with complete physics",
                ("without", "points", "allowed", "dominates [% of the front]", "limits violated"),
                [_judged(one) for one in judged],
            )
        )
    return tables


def _judged(one: Variant) -> tuple[Any, ...]:
    broken = [
        f"{words(name)} by up to {100 * worst:.3g} %"
        for name, worst in one.violations.items()
        if worst > LIMIT_ROOM
    ]
    return (
        words(one.name),
        len(one.allowed),
        int(one.allowed.sum()),
        _percent(one.volume),
        ", ".join(broken),
    )
