"""`docs/startup.md`: from command to answer, from its own run."""

from pathlib import Path
from typing import Any

from ..harness import row_of, table_of, where_and_when, write_text

_HEAD = """\
# From command to answer

This page is written by `python -m benchmarks startup --docs docs`. Do not edit it by hand.

Each command runs in its own process, without pictures: **cold** with an empty folder of stored
programs, **warm** with the programs that the previous run has stored there. **Processor** seconds
are those of all threads; other work on the machine affects them less than **wall** seconds. Wall
seconds are divided into start of the interpreter, imports, tracing, lowering, compiling (warm:
reading stored programs), and the rest: reading the file, running, printing and the end of the
process. **Over imports** is the processor time of the warm run over that of `import jax, diffrax`
alone; both run in turn.
"""
_CALLS = """\
## Calls in Python

`wu2022`, each call as written, without `jax.jit`, in a process without stored programs. The first
call traces and compiles; of thirty later ones the fastest counts.
"""
_PARTS = ("wall", "processor", "interpreter", "imports", "tracing", "lowering", "compiling", "rest")


def tables(verbs: list[dict[str, Any]]) -> str:
    """The measurements as Markdown."""
    heads = ["command", "", *(f"{part} [s]" for part in _PARTS), "over imports"]
    lines = table_of(heads)
    for row in verbs:
        if row["error"]:
            lines.append(row_of([row["command"], row["error"], *[""] * (len(heads) - 2)]))
            continue
        for kind in ("cold", "warm"):
            cells = [f"{row[kind][f'{part}_s']:.2f}" for part in _PARTS]
            ratio = f"{row['over_imports']:.2f}" if kind == "warm" else ""
            lines.append(row_of([f"`prsm {row['command']}`", kind, *cells, ratio]))
    return "\n".join([*lines, ""])


def call_table(calls: list[dict[str, Any]]) -> str:
    """First and later calls as Markdown."""
    lines = table_of(["call", "first [s]", "later [ms]"])
    for row in calls:
        later = f"{1e3 * row['later_s']:.2f}"
        lines.append(row_of([f"`{row['call']}`", f"{row['first_s']:.2f}", later]))
    return "\n".join([*lines, ""])


def write_page(document: dict[str, Any], folder: Path) -> Path:
    """Write the page.

    **Arguments:**

    - `document`: what `startup.json` has.
    - `folder`: that of the documentation.

    **Returns:** its path.
    """
    alone = [row["imports"]["processor_s"] for row in document["verbs"] if not row["error"]]
    measured = (
        f"{where_and_when(document)}. "
        f"`import jax, diffrax` alone took {min(alone):.2f} to {max(alone):.2f} s of processor "
        "time.\n"
    )
    parts = [_HEAD, measured, tables(document["verbs"]), _CALLS, call_table(document["calls"])]
    text = "\n".join(parts)
    return write_text(folder / "startup.md", text)
