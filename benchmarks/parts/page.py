"""`docs/parts.md`: what each optional part costs, from its own run."""

from pathlib import Path
from typing import Any

from ..harness import row_of, table_of, write_text

_HEAD = """\
# What each part costs

This page is written by `python -m benchmarks parts --docs docs`. Do not edit it by hand.

For each example and each optional part of its file: the program with the part and without it, both
in the same process. **Equations** are those of the traced program that the result needs; a loop
counts once. **Flops** and **bytes** accessed are counted by XLA in the compiled program; a loop
counts once. **Memory** is what XLA reserves for results and intermediate numbers. **Compiling** is
processor time, **run** the shortest wall time of a run. A part that does not change the number of
equations, because the program does not read it or uses 0 without it, is named below the table.
Programs with the same number of equations are not compiled twice. `prsm explain FILE --time` does
the same for your own file.
"""
_MEASURES = ("equations", "flops", "bytes", "memory_bytes", "compile_s", "run_s")


def _cell(measure: str, value: float | None) -> str:
    if value is None:
        return ""
    if measure == "compile_s":
        return f"{value:.2f} s"
    if measure == "run_s":
        return f"{1e6 * value:.0f} µs"
    if measure == "memory_bytes":
        return f"{value / 1e3:.1f} kB"
    return f"{value:,.0f}"


def _of(example: dict[str, Any]) -> list[str]:
    if example["error"]:
        return [f"Not measured: {example['error']}.", ""]
    heads = ["program", "without", "equations", "flops", "bytes", "memory", "compiling", "run"]
    lines, unread, needed, reasons = table_of(heads), {}, {}, []
    for program in example["programs"]:
        name = program["name"]
        if program["error"]:
            reasons.append(f"No {name.replace('_', ' ')}: {program['error']}.")
            continue
        whole = [_cell(m, program[m]) for m in _MEASURES]
        lines.append(row_of([name, "**nothing**", *whole]))
        for part in example["parts"]:
            cost = part["costs"][name]
            if cost["needed"]:
                needed.setdefault(name, []).append(part["name"])
            elif cost["equations"] == 0:
                unread.setdefault(name, []).append(part["name"])
            else:
                label = part["name"] + (f" ({part['law']})" if part["law"] else "")
                cells = [_cell(m, cost[f"{m}_without"]) for m in _MEASURES]
                lines.append(row_of([name, label, *cells]))
    lines.append("")
    for title, found in (("The same without", unread), ("Not possible without", needed)):
        for name, parts in found.items():
            lines += [f"{title}, {name.replace('_', ' ')}: {', '.join(parts)}.", ""]
    return [*lines, *reasons, ""]


def tables(examples: list[dict[str, Any]]) -> str:
    """The measurements as Markdown, one table for an example."""
    lines = []
    for example in examples:
        lines += [f"## {example['example']}", "", *_of(example)]
    return "\n".join(lines)


def write_page(document: dict[str, Any], folder: Path) -> Path:
    """Write the page.

    **Arguments:**

    - `document`: what `parts.json` has.
    - `folder`: that of the documentation.

    **Returns:** its path.
    """
    machine = document["machine"]
    measured = (
        f"On a busy machine of {_number(machine['cores'])} cores ({machine['processor']}), "
        f"{document['date'][:10]}.\n"
    )
    text = "\n".join([_HEAD, measured, tables(document["examples"])])
    return write_text(folder / "parts.md", text.rstrip() + "\n")


def _number(cores: int) -> str:
    return {1: "one", 2: "two", 4: "four"}.get(cores, str(cores))
