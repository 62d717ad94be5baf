"""`docs/accuracy_and_speed.md`, its JSON and its charts, from the JSON files of the cases."""

import json
from pathlib import Path
from typing import Any

from ..cases import case_names
from ..harness import written_whole
from .advice import CASES, REASONS
from .front import (
    NOISE,
    dominating,
    error_of,
    fastest_within,
    is_ours,
    is_single,
    on_front,
)
from .picture import draw

#: Raised by one when a key changes its meaning or goes.
SCHEMA = 1
NAME = "accuracy_and_speed"
#: Errors that an engineer may allow.
_LIMITS = (1e-2, 1e-4, 1e-6, 1e-9, 1e-12)

_HEAD = """\
# Accuracy and speed

This page and [its JSON](accuracy_and_speed.json) are written by `prsm bench` (or `make bench`) in a
checkout. Do not edit them by hand.

The charts show the cost of accuracy: the largest error against an independent reference of higher
precision, over the run time of one instance. Left is faster, down is more accurate. All methods of
a chart were sampled in turn in one run: **ratios are valid on other machines, absolute times only
for this machine and run.** The times do not include compilation; see
[](compile_time_and_batching.md).

* Full markers are methods of this package. Hollow markers with dashed lines are rivals: other
  codes, in their best form.
* A **ring** marks a default of the package.
* The grey stair is the **front** of our own methods. A method is behind it if another one of ours
  has the same error in less time (by more than {noise:.0%}, the scatter of such times), or half its
  error in the same time.
  Batches and single calls have separate fronts, because a batch always costs less per instance.
* In the tables the time is that of one instance with the fastest way of calling, mostly a batch;
  a row holds from its allowed error up to that of the row above.
* A rival that is not installed or failed is listed with the reason.
"""


def _row(cells: list[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def time_text(seconds: float) -> str:
    """A time with three digits in a unit that fits."""
    for factor, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if seconds >= factor:
            return f"{seconds / factor:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def setting_text(row: dict[str, Any]) -> str:
    """A method and its setting."""
    setting = row["setting"]
    name = row["method"]
    return name if setting is None else f"{name}, {setting['name']} {setting['value']:g}"


def joined(folder: Path) -> dict[str, Any]:
    """The JSON files of all cases in a folder as one, with what the page says of each row.

    **Raises:** `FileNotFoundError` if there are none.
    """
    found = []
    for name in [*CASES, *sorted(set(case_names()) - set(CASES))]:
        path = folder / f"{name}.json"
        if path.is_file():
            found.append(json.loads(path.read_text(encoding="utf-8")))
    if not found:
        raise FileNotFoundError(f"{folder}: no results of a case; run `prsm bench` first")
    for case in found:
        for problem in case["problems"]:
            rows = problem["results"]
            for row in rows:
                row["single"] = is_single(row)
                row["largest_error"] = error_of(row)
                row["on_front"] = is_ours(row) and on_front(row, rows)
    return {"schema": SCHEMA, "cases": found}


def _choices(problem: dict[str, Any]) -> list[str]:
    """For each error allowed the fastest of ours and of the rivals."""
    rows = problem["results"]
    header = ["error allowed", "fastest of ours", "time", "fastest rival", "time", "rival / ours"]
    lines = []
    before = None
    for limit in _LIMITS:
        ours = fastest_within(limit, [row for row in rows if is_ours(row)])
        theirs = fastest_within(limit, [row for row in rows if not is_ours(row)])
        if (ours, theirs) == before:
            lines.pop()
        before = (ours, theirs)
        if ours is None and theirs is None:
            break
        cells = [f"{limit:.0e}".replace("e-0", "e-")]
        for row in (ours, theirs):
            text = ["none", ""] if row is None else [setting_text(row), time_text(row["best_s"])]
            cells += text
        ratio = "" if not (ours and theirs) else f"{theirs['best_s'] / ours['best_s']:.3g}"
        lines.append(_row([*cells, ratio]))
    return [_row(header), _row(["---"] * len(header)), *lines, ""] if lines else []


def _verdicts(case: str, problem: dict[str, Any]) -> list[str]:
    """Of every default whether it lies on the front, and what beats it."""
    rows, lines = problem["results"], []
    for row in rows:
        if not row.get("default"):
            continue
        error = error_of(row)
        what = f"* Default **{setting_text(row)}**, {time_text(row['best_s'])}"
        if error is None:
            lines.append(f"{what}: its error is not finite.")
            continue
        what += f", error {error:.1e}: "
        better = dominating(row, rows)
        if better is None:
            lines.append(what + "on the front.")
        else:
            lines.append(
                f"{what}**not on the front**; {setting_text(better)} takes "
                f"{time_text(better['best_s'])} at {error_of(better):.1e}. "
                + REASONS.get((case, row["method"]), "")
            )
    return lines or ["* None of these is a default."]


def _problem(case: dict[str, Any], problem: dict[str, Any], folder: Path) -> list[str]:
    name = f"bench_{case['case']}_{problem['name']}.png"
    drawn = draw(problem, folder / "images" / name)
    lines = [f"### {problem['title']}", ""]
    if drawn is not None:
        lines += [f"![{problem['title']}: error over run time](images/{name})", ""]
    lines += [f"Reference: {problem['reference']}.", "", *_verdicts(case["case"], problem), ""]
    lines += _choices(problem)
    if problem["left_out"]:
        for one in problem["left_out"]:
            lines.append(f"* Not in the chart: {one['method']} ({one['reason']}).")
        lines.append("")
    return lines


def _summary(document: dict[str, Any]) -> list[str]:
    lines, behind = [], []
    count = 0
    for case in document["cases"]:
        for problem in case["problems"]:
            for row in problem["results"]:
                if not row.get("default"):
                    continue
                count += 1
                if not row["on_front"]:
                    behind.append(f"{problem['title']}: {setting_text(row)}")
    lines.append(
        f"Of {count} defaults {count - len(behind)} lie on the front"
        + ("." if not behind else "; the others, with the reason beside each chart:")
    )
    return [*lines, "", *(f"* {one}" for one in behind), *([""] if behind else [])]


def write_page(folder: Path, docs: Path) -> tuple[Path, Path]:
    """Write the page with its charts, and its JSON, each whole or not at all.

    **Arguments:**

    - `folder`: where the cases have left their JSON files.
    - `docs`: folder for `accuracy_and_speed.md`, `accuracy_and_speed.json` and `images/`.

    **Returns:** the paths of page and JSON.

    **Raises:** `FileNotFoundError` if no case has left a file.
    """
    document = joined(folder)
    json_path, page_path = docs / f"{NAME}.json", docs / f"{NAME}.md"
    with written_whole(json_path) as temporary:
        text = json.dumps(document, indent=1, allow_nan=False, ensure_ascii=False)
        temporary.write_text(text + "\n", encoding="utf-8")
    # The page is one of the JSON, not of what happens to be in memory.
    document = json.loads(json_path.read_text(encoding="utf-8"))
    lines = [_HEAD.format(noise=NOISE), *_summary(document)]
    for case in document["cases"]:
        heading, words = CASES.get(case["case"], (case["description"], ""))
        machine, date = case["machine"], case["date"][:10]
        lines += [f"## {heading}", ""]
        if words:
            lines += [f"**What to choose.** {words}", ""]
        lines += [
            f"{case['description']}. Measured on {date}, {machine['processor']}, "
            f"{machine['cores']} cores" + (", by the quick form." if case["quick"] else "."),
            "",
        ]
        for problem in case["problems"]:
            lines += _problem(case, problem, docs)
    with written_whole(page_path) as temporary:
        temporary.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")
    return page_path, json_path
