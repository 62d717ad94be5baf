"""`docs/programs.md`: compile and run times of programs, from their own run."""

from pathlib import Path
from typing import Any

from ..harness import row_of, table_of, where_and_when, write_text
from .functions import EXAMPLES, FUNCTIONS, KINDS

_HEAD = """\
# Compiling

This page is written by `python -m benchmarks programs --docs docs`. Do not edit it by hand.

Each row is a program in its own process: the value of a function, the gradient of a scalar of its
result in reverse mode (without such a scalar, the Jacobian of all its numbers in forward mode), or
the Hessian of the scalar; for the number of designs in its column, several at once under
`jax.vmap`. Variables are lead,
contact angle and roller radius of the first stage. **Equations** are those of the traced program; a
loop counts once. **Tracing**, **lowering** and **compiling** are processor time; **run** is the
shortest wall time per design. A program that fails or takes too long has a row with the reason.
"""
_PLURAL = {"value": "values", "gradient": "gradients", "hessian": "Hessians"}
_RATIOS = ("equations", "compile_s", "flops", "run_s")


def tables(rows: list[dict[str, Any]]) -> str:
    """The measurements as Markdown."""
    heads = ["example", "function", "", "designs", "equations", "tracing", "lowering", "compiling"]
    heads += ["flops", "run"]
    lines = table_of(heads)
    for row in rows:
        cells = [row["example"], row["function"], row["kind"], str(row["batch"])]
        if row["error"]:
            lines.append(row_of([*cells, row["error"].replace("|", "\\|"), *[""] * 5]))
            continue
        cells += [f"{row['equations']:,}"]
        cells += [f"{row[key]:.2f} s" for key in ("trace_s", "lower_s", "compile_s")]
        flops = "" if row["flops"] is None else f"{row['flops']:.3g}"
        run = f"{1e6 * row['run_s']:.3g} µs" + ("" if row["finite"] else " (not finite)")
        lines.append(row_of([*cells, flops, run]))
    return "\n".join([*lines, ""])


def compared(new: dict[str, Any], old: dict[str, Any]) -> str:
    """Ratios of a run to an older one, program by program, and of all compile times together."""

    def by_key(document):
        return {_name_of(r): r for r in document["programs"] if not r["error"]}

    before, after = by_key(old), by_key(new)
    both = [key for key in after if key in before]
    lines = ["New over old:", "", *table_of(["program", *_RATIOS])]
    for key in both:
        pairs = [(after[key][name], before[key][name]) for name in _RATIOS]
        ratios = [f"{a / b:.2f}" if a and b else "" for a, b in pairs]
        lines.append(row_of([" ".join(map(str, key)), *ratios]))
    sums = [sum(rows[key]["compile_s"] for key in both) for rows in (after, before)]
    if sums[1]:
        lines += ["", f"All compile times: {sums[0]:.1f} s over {sums[1]:.1f} s."]
    return "\n".join([*lines, ""])


def _processor_s(row: dict[str, Any]) -> float | None:
    """Tracing, lowering and compiling of a program; its limit if it takes longer."""
    if row["error"]:
        return row.get("limit_s")
    return row["trace_s"] + row["lower_s"] + row["compile_s"]


def totals(document: dict[str, Any]) -> str:
    """Processor time until programs are ready, in this and in another commit, as Markdown.

    **Arguments:**

    - `document`: what `programs.json` has after a run with `--beside`.
    """
    here, there = ({_name_of(r): r for r in document[k]} for k in ("programs", "beside"))
    now, then = ({name: _processor_s(r) for name, r in rows.items()} for rows in (here, there))
    both = [n for n in here if now[n] is not None and then.get(n) is not None]
    lines = table_of(["programs", "count", "then", "now", "now over then"])
    for words, kinds in (*((_PLURAL[kind], (kind,)) for kind in KINDS), ("all", KINDS)):
        names = [name for name in both if here[name]["kind"] in kinds]
        before, after = (sum(times[n] or 0.0 for n in names) for times in (then, now))
        ratio = f"{after / before:.2f}" if before else ""
        lines.append(row_of([words, str(len(names)), f"{before:.0f} s", f"{after:.0f} s", ratio]))
    for words, rows in (("then", there), ("now", here)):
        late = [" ".join(map(str, n)) for n, r in rows.items() if "limit_s" in r]
        if late:
            programs = ", ".join(late)
            lines += ["", f"Not done within their limit, which is counted, {words}: {programs}."]
    return "\n".join([*lines, ""])


def _name_of(row: dict[str, Any]) -> tuple[Any, ...]:
    return tuple(row[key] for key in ("example", "function", "kind", "batch"))


def _beside(document: dict[str, Any]) -> list[str]:
    if not document.get("beside"):
        return []
    commit = document["beside_commit"]
    head = f"## Against commit {commit}\n"
    words = (
        "Processor time of tracing, lowering and compiling, both commits at the same time.\n"
        "Programs that were not measured in both, or that one of them does not have, are left\n"
        "out.\n"
    )
    return [head, words, totals(document)]


def _missing(rows: list[dict[str, Any]]) -> str:
    run = {(row["example"], row["function"]) for row in rows}
    lacking = [f"{e} {f}" for e in EXAMPLES for f in FUNCTIONS if (e, f) not in run]
    return f"Not in this run: {', '.join(lacking)}.\n" if lacking else ""


def write_page(document: dict[str, Any], folder: Path) -> Path:
    """Write the page.

    **Arguments:**

    - `document`: what `programs.json` has.
    - `folder`: that of the documentation.

    **Returns:** its path.
    """
    rows, measured = document["programs"], f"{where_and_when(document)}.\n"
    longest = sorted((r for r in rows if not r["error"]), key=lambda r: -r["compile_s"])[:10]
    parts = [_HEAD, measured, *_beside(document)]
    parts += ["## The longest to compile\n", tables(longest), "## All\n"]
    text = "\n".join([*parts, tables(rows), _missing(rows)]).rstrip() + "\n"
    return write_text(folder / "programs.md", text)
