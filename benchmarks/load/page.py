"""`docs/load.md`: what grows how, from its own run."""

from pathlib import Path
from typing import Any

from ..harness import row_of, table_of, write_text
from .growth import finished
from .picture import draw
from .tasks import TASKS

_HEAD = """\
# Growth with size

This page is written by `python -m benchmarks load --docs docs`. Do not edit it by hand.

Each row is one task in several sizes. The **power** is p in `size^p`, by least squares over
the sizes down to 1/150 of the largest; 1 is linear. **Operations** are the numbers that the program
computes, counted in the traced program; they are equal on every machine. A loop that ends by a
condition counts as one pass. **Run time** is the shortest wall time of the compiled program in
several runs. **Processor time** is that of all threads of the process, which other work on the
machine affects less; the first table gives its power. **Memory** is what XLA reserves for results
and intermediate numbers. The **peak** is that of the whole process, with Python, JAX and compiler.
"""

_BEFORE = """\
## What was not linear

At the commit ecd1f5c, on the same machine:

| what | before | now |
|---|---|---|
| mission of 24 hours, run time | 0.78 s | see above |
| 10,000 reversals in balance, memory | 101 MB | see above |
| RODASP, breaks with which a step is compared | all | two |
| load sharing of 20 unequal rollers with play, tracing and compiling | 30 s | 10 s |
| the same, of 60: equations of the program | 51,313 | 4,616 |

* All samples of a scene were computed at once, and about a hundred numbers of each were stored
  until the end. Up to some thousand samples these fit the cache and are written to memory that is
  already in use. Beyond, each number comes from main memory, and each page of 4 kB is new to the
  process, which costs 4.5 µs here: 26,154 pages for 10,000 reversals. Time grew as size to the
  power of 1.4 and 1.8, although operations grew linearly. Now 1,024 samples are computed completely
  before the next 1,024, and histories that are not returned are not stored.
* The bisection that finds a time in a table of more than 128 points was unrolled. XLA computed its
  first halvings again for each one that followed. In a batch it is a loop now: 24 ns per sample
  instead of 200.
* Every step of an integration was compared with all breaks of speed and load; a reversal has five.
  With more than 256 breaks a step is now compared with the previous and the next one only; steps
  and results are equal to the last bit.
* Scales of a scene came from nine equal intervals. If the number of strokes is a multiple of eight,
  the speed is zero at the ends of all of them, so the scale of speed was 1 rad/s and that of time
  the whole duration: 331 steps per reversal instead of 199, and 10,000 reversals did not end.
* A table computed the slopes of all its intervals; a sample now computes those of its own interval.
* With many unequal rollers, elimination was unrolled row by row, and with play into one product for
  each pair of rollers. The program grew with the square of the number of rollers.
"""


def _bytes(value: float | None) -> str:
    return "" if value is None else f"{value / 1e6:.3g} MB"


def _power(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"


def _error(value: float | None) -> str:
    return "not finite" if value is None else f"{value:.1e}"


def _growth(tasks: list[dict[str, Any]]) -> list[str]:
    names = ["task", "largest that ended", "operations", "expected", "processor time", "memory"]
    lines = table_of([*names, "why"])
    for task in tasks:
        powers = task["exponents"]
        rows = finished(task["sizes"])
        cells = [task["title"], f"{rows[-1]['size']:,} {task['unit']}s" if rows else "none"]
        cells += [_power(powers["operations"]), f"{task['expected']:.0f}", _power(powers["time"])]
        lines.append(row_of([*cells, _power(powers["memory"]), task["why"]]))
    return lines


def _sizes(tasks: list[dict[str, Any]]) -> list[str]:
    names = ["task", "size", "run time", "processor time", "operations", "steps", "memory"]
    names += ["peak", "compiling", "error", "error against"]
    lines = table_of(names)
    for task in tasks:
        for row in task["sizes"]:
            cells = [task["title"], f"{row['size']:,}", f"{row['best_s']:.3g} s"]
            cells += [f"{row['processor_s']:.3g} s", f"{row['operations']:.3g}"]
            cells += ["" if row["steps"] is None else f"{row['steps']:,}"]
            cells += [_bytes(row["run_bytes"]), _bytes(row["peak_bytes"])]
            cells += [f"{row['compile_s']:.3g} s", _error(row["error"]), task["check"]]
            lines.append(row_of(cells))
    return lines


def _left_out(tasks: list[dict[str, Any]]) -> list[str]:
    run = {task["title"] for task in tasks}
    missing = [task.title for task in TASKS.values() if task.title not in run]
    return [f"Not in this run: {'; '.join(missing)}.", ""] if missing else []


def tables(tasks: list[dict[str, Any]]) -> str:
    """The measurements as Markdown: powers of growth first, then every size."""
    return "\n".join([*_growth(tasks), "", *_sizes(tasks), ""])


def write_page(document: dict[str, Any], folder: Path) -> list[Path]:
    """Write the page and its picture.

    **Arguments:**

    - `document`: what `load.json` has.
    - `folder`: that of the documentation.

    **Returns:** their paths.
    """
    tasks, machine = document["tasks"], document["machine"]
    picture = draw(tasks, folder / "images" / "load.png")
    lines = [_HEAD, "## Powers of growth", "", *_growth(tasks), ""]
    lines += [
        "A small scene needs the memory of one block of 1,024 samples, and few designs that of one "
        "chunk of 1,000, so memory grows more slowly than the size until the results dominate.",
        "",
        "![Run time and memory over size](images/load.png)",
        "",
        "## Every size",
        "",
        f"On {machine['cores']} cores of a busy machine ({machine['processor']}), "
        f"{document['date'][:10]}, in {document['seconds'] / 60:.0f} minutes. Steps are those of "
        "Newton's method or of the integration. Reversals and missions return one history, the "
        "drive torque, and the result code.",
        "",
        *_sizes(tasks),
        "",
        *_left_out(tasks),
        _BEFORE,
    ]
    return [write_text(folder / "load.md", "\n".join(lines)), picture]
