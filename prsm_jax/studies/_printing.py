"""A study in words: sentences on its main results, and the whole as text."""

import math
import textwrap

import numpy as np

from ..text import in_unit, number, state_without_efficiency
from ._gradients import change_in_words, words
from ._parts import StudyParts
from ._tables import ROUNDING, tables_of, unit_of_quantity
from ._variants import Variant

#: Limits that conflict with an objective in this share of the map are named.
_OFTEN = 0.5


def map_sentences(study: StudyParts) -> list[str]:
    """Sentences on the designs of the map, and on the gradient at the present design."""
    grid, designs = study.map, study.map.usable.size
    failed, errors = int(np.sum(~grid.usable)), int(np.sum(grid.error & grid.usable))
    why = ", ".join(f"{words(name)} {count}" for name, count in grid.reasons.items())
    fail = f"{failed} fail ({why})" if failed and why else f"{failed} fail"
    lines = [
        f"The map has {designs} designs; {fail}, prsm check finds errors in {errors} more, "
        f"and {int(grid.allowed.sum())} are allowed: they have no error and satisfy all limits."
    ]
    rows = {name: study.present_elasticities[name] for name in study.problem.senses}
    clauses = [change_in_words(one.name, rows) for one in study.problem.drivers]
    lines.append(f"Present design, relative changes: {'; '.join(clauses)}.")
    return lines


def conflict_sentences(study: StudyParts) -> list[str]:
    """Sentences on the conflicts of quantities, with each other and with limits."""
    lines = []
    for one in study.conflicts:
        if one.limit:
            continue
        pair = f"{words(one.first)} and {words(one.second)}"
        if not math.isfinite(one.share):
            lines.append(f"{pair}: one of them does not depend on the drivers.")
            continue
        allowed = int(np.sum(study.map.allowed & np.isfinite(one.cosine)))
        if one.share == 0:
            lines.append(f"{pair[0].upper()}{pair[1:]} do not conflict anywhere in the map.")
            continue
        text = f"{pair} conflict in {number(100 * one.share, 3)} % of the map"
        if allowed:
            text += (
                f" and in {number(100 * one.share_allowed, 3)} % of its {allowed} allowed designs"
            )
        opposed = [words(n) for n, share in one.by_driver.items() if share > _OFTEN]
        if opposed:
            text += f"; in most designs {' and '.join(opposed)} moves them in opposite senses"
        lines.append(f"{text[0].upper()}{text[1:]}.")
    for name in study.problem.senses:
        against = [
            f"{words(one.second)} ({number(100 * one.share, 3)} %)"
            for one in study.conflicts
            if one.limit and one.first == name and one.share > _OFTEN
        ]
        if against:
            lines.append(
                f"Improving {words(name)} leads towards these limits in most of the map: "
                f"{', '.join(against)}."
            )
    return lines


def front_sentences(study: StudyParts) -> list[str]:
    """Sentences on the extent of the front, and on its active limits."""
    front = study.front
    if not front.points:
        return [f"No front: {front.message}."]
    ranges = []
    for name in study.problem.objectives:
        shown = unit_of_quantity(study, name)
        values = [front.points[i].objectives[name] for i in (0, -1)]
        texts = [state_without_efficiency(name, v) or in_unit(v, shown) for v in values]
        ranges.append(f"{words(name)} from {texts[0]} to {texts[1]}")
    lines = [f"The front has {len(front.points)} points: {', '.join(ranges)}."]
    if not front.converged:
        lines.append(f"The front has not converged: {front.message}.")
    counts: dict[str, int] = {}
    for point in front.points:
        for name in point.active:
            counts[name] = counts.get(name, 0) + 1
    if counts:
        listed = ", ".join(f"{words(n)} ({c} of {len(front.points)})" for n, c in counts.items())
        lines.append(f"Active limits on it: {listed}.")
    return lines


def variant_sentences(study: StudyParts) -> list[str]:
    """Sentences on the influence of each part of the physics on the results."""
    return [_variant(study, one) for one in study.variants]


def _variant(study: StudyParts, one: Variant) -> str:
    head = f"Without {words(one.name)}"
    if not one.changes:
        return f"{head}: {one.error}."
    parts = []
    for name in study.problem.senses:
        change = float(one.changes[name][0])
        if not math.isfinite(change) or abs(change) < ROUNDING:
            parts.append(f"{words(name)} is the same")
        else:
            side = "higher" if change > 0 else "lower"
            parts.append(f"{words(name)} is {number(100 * abs(change), 2)} % {side}")
    text = f"{head}, in the present design: {', '.join(parts)}."
    if one.turned:
        turned = [f"{words(q)} by {words(d)} ({n})" for q, d, n in one.turned]
        text += f" The sign of a derivative changes, in some designs: {', '.join(turned)}."
    if one.without_data:
        text += f" These limits cannot be computed: {', '.join(map(words, one.without_data))}."
    if one.front is None or not one.front.points:
        why = one.error or ("" if one.front is None else one.front.message)
        return f"{text} No front without it: {why}."
    allowed, points = int(one.allowed.sum()), len(one.allowed)
    text += (
        f" Of the {points} points of its front, {allowed} satisfy all limits with complete physics"
    )
    if allowed and math.isfinite(one.volume):
        text += f"; they dominate {number(100 * one.volume, 4)} % of the front's volume"
    return f"{text}."


def sentences_of(study: StudyParts) -> dict[str, list[str]]:
    """All sentences, by the part of the study that they belong to."""
    return {
        "drivers": map_sentences(study),
        "conflict": conflict_sentences(study),
        "front": front_sentences(study),
        "variants": variant_sentences(study),
    }


def text_of(study: StudyParts, width: int | None) -> str:
    """Tables and sentences, part by part, and a sentence on the gradient at each point."""
    said, blocks = sentences_of(study), []
    for part, tables in tables_of(study).items():
        blocks += [table.text(width).rstrip() for table in tables]
        lines = list(said[part])
        if part == "front":
            lines += [f"{i}: {one.sentence}" for i, one in enumerate(study.gradients, start=1)]
        blocks += ["\n".join(_wrapped(line, width)) for line in lines]
    return "\n\n".join(blocks)


def _wrapped(line: str, width: int | None) -> list[str]:
    return [line] if width is None else textwrap.wrap(line, width, subsequent_indent="  ")
