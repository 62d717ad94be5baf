"""`docs/fronts.md`: fronts against NSGA-II, and many starts against searches one by one."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..harness import table_of, where_and_when, write_text

_HEAD = """\
# Fronts and starts against rivals

This page is written by `python -m benchmarks fronts --docs docs` and `python -m benchmarks starts
--docs docs`; each takes the measurements of the other from `--out`. Do not edit it by hand.
"""

_FRONTS = """\
## Fronts by gradients against NSGA-II

Both methods have the variables, the limits and the errors of `check` of the example `actuator`. The
**volume** is the volume that the designs dominate, as a share of a box. The box extends from the
ideal point to a point that is worse than the front of the gradients by 10 % of its range.
**Evaluations** of the gradients are values plus derivatives, each counted as one; in brackets, a
derivative is counted once for each variable. Run times are without compilation. The goal is a
volume at least as large as the best of NSGA-II with at most a twentieth of the evaluations.
"""

_STARTS = """\
## Many starts at once against SLSQP from each

Both begin at the same Latin hypercube. "At once" moves all starts by Adam in one program, and then
searches from the best few by SLSQP. Run times are the shortest of several, after the first call.
"""


def _fronts(document: dict[str, Any]) -> Iterator[str]:
    yield _FRONTS
    yield f"{where_and_when(document)}.\n"
    for name, one in document["problems"].items():
        spent = one["evaluations"] + one["derivative_evaluations"]
        ours = (
            f"gradients, {one['points']} points",
            f"{one['hypervolume']:.5f}",
            f"{spent} ({one['evaluations_by_variables']})",
            f"{one['seconds']:.1f} s",
        )
        rivals = (
            (
                f"NSGA-II, {rival['population']} a generation, seed {rival['seed']}",
                f"{rival['hypervolume']:.5f}",
                f"{rival['evaluations']}",
                f"{rival['seconds']:.1f} s",
            )
            for rival in one["nsga2"]
        )
        if not one["nsga2"]:
            rivals = (("NSGA-II", one["left_out"], "–", "–"),)
        yield f"### {name.replace('_', ', ')}\n"
        yield from table_of(("method", "volume", "evaluations", "run time"), (ours, *rivals))
        residual = (
            f"Largest Karush–Kuhn–Tucker residual of a point {one['largest_kkt_residual']:.0e}.\n"
        )
        if not one["nsga2"]:
            yield f"\nThe goal is not judged. {residual}"
            continue
        larger = one["hypervolume_ratio"] >= 1
        fewer = one["evaluation_ratio"] >= 20
        verdict = "reached" if larger and fewer else "NOT reached"
        yield (
            f"\nVolume over the best of NSGA-II {one['hypervolume_ratio']:.4f}, with "
            f"{one['evaluation_ratio']:.1f} times fewer evaluations: goal {verdict}. {residual}"
        )


def _starts(document: dict[str, Any]) -> Iterator[str]:
    yield _STARTS
    where, starts = where_and_when(document), document["starts"]
    yield f"{where}. Example `{document['example']}`, {starts} starts.\n"
    rows = (
        (
            name,
            f"{row['best']:.10g}",
            str(row["evaluations"]),
            str(row["derivative_evaluations"]),
            str(row["searches"]),
            f"{min(row['samples_s']):.2f} s",
            f"{row['first_call_s']:.1f} s",
        )
        for name, row in document["rows"].items()
    )
    heads = ("starts", "objective", "values", "derivatives", "searches", "run time", "first call")
    yield from table_of(heads, rows)
    yield (
        f'\n"At once" is {document["speed_ratio"]:.3g} times as fast (median of runs in turn); '
        "the relative difference of the objectives is "
        f"{document['difference']:.0e}.\n"
    )


def write_page(fronts: dict[str, Any] | None, starts: dict[str, Any] | None, folder: Path) -> Path:
    """Write `fronts.md` into a folder, from what was measured."""
    lines = [_HEAD]
    if fronts is not None:
        lines += _fronts(fronts)
    if starts is not None:
        lines += _starts(starts)
    path = folder / "fronts.md"
    write_text(path, "\n".join(lines).rstrip() + "\n")
    return path
