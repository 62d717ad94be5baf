"""`docs/devices.md`: designs a second on each device, from one run."""

from pathlib import Path
from typing import Any

from ..harness import row_of, write_text
from .tasks import TASKS

_HEAD = """\
# Processors and accelerators

This page is written by `python -m benchmarks devices --docs docs`. Do not edit it by hand.

The same functions run unchanged on every device that JAX finds. If JAX finds no accelerator, the
command reports this and measures only the processor.

The **share of the ceiling** is the shortest possible time on the device over the measured time. The
shortest possible time is the longer of two: that of the operations that XLA counts, at the rate of
multiplications and additions in registers, and that of moving inputs and results once, at the rate
of a copy. Both rates were measured in the same run. The rate of operations is below the figures of
makers, which are for a multiplication and an addition merged into one. XLA counts a loop as one
pass, so shares of tasks with loops (meshing, frequencies, the chain, RODASP) are lower bounds. The
**error** is the largest difference from float64 on the processor, over the largest entry of each
result, for 1,000 designs.
"""

_READING = """\
## What to read from it

* Short functions (Hertz, meshing, frequencies) need a million designs at once to fill an
  accelerator. They are then limited by divisions, roots and long chains of scalars, not by
  memory.
* The chain from geometry to efficiency and frequencies consists of many kernels, each of which
  reads and writes memory: 100,000 designs at once take three times as long as 10,000.
* A processor is fastest with chunks of about 1,000 designs, which fit its cache
  (`prsm_jax.sweeps.map_in_chunks`); an accelerator with all designs that fit its memory.

## Transients in lock step, and how to avoid it

RODASP takes each step for all designs of a batch at once, so all take as many steps as the slowest
one. A step consists of about a hundred kernels, each of which reads and writes one number per
design. Below 100,000 designs the time of a step is that of starting its kernels: ten times as many
designs take 1.6 times as long. Above, memory limits the speed.

For independent steps of each design, the whole loop must be one kernel, in which a block of 32 or
64 designs continues until all of them are finished:

1. a right-hand side in plain numbers, without arrays of stages: the reduced stage has 15 numbers;
2. the Jacobian by forward mode of the same numbers, and elimination written out for up to six
   stages;
3. samples written by the block itself, at the step that passes their time;
4. the same for derivatives: tangents as further states, with the same steps repeated.

The arithmetic of a step of two stages is about 2,000 operations. At the measured rate and 70 steps
that is 1e8 trajectories a second; a tenth of it would be 1e7. None of this is implemented.
"""


def _line(row: dict[str, Any]) -> str:
    first = [TASKS[row["task"]].title, f"{row['designs']:,}", row["precision"]]
    if "failure" in row:
        return row_of([*first, row["failure"], "", "", "", ""])
    rest = [
        f"{row['designs_per_second']:.2e}",
        f"{1e9 * row['seconds'] / row['designs']:.3g} ns",
        f"{100 * row['share_of_ceiling']:.2g} %",
        f"{row['error']:.0e}",
        f"{row['compile_seconds']:.2g} s",
    ]
    return row_of([*first, *rest])


def page_of(document: dict[str, Any]) -> str:
    """The page as Markdown.

    **Arguments:**

    - `document`: what `devices.json` holds.
    """
    lines = [_HEAD]
    if document["no_accelerator"]:
        lines.append(f"{document['no_accelerator']}.\n")
    devices = list(dict.fromkeys(row["device"] for row in document["rows"]))
    for device in devices:
        lines.append(f"## {'Processor' if device == 'cpu' else device}\n")
        for precision, one in document["ceilings"].get(device, {}).items():
            lines.append(
                f"Ceilings in {precision}: {one['bytes_per_second'] / 1e9:.3g} GB/s, "
                f"{one['operations_per_second'] / 1e9:.3g} billion operations a second.\n"
            )
        lines.append(
            "| task | designs | precision | designs a second | time a design "
            "| share of the ceiling | error | compiling |\n|---|---|---|---|---|---|---|---|"
        )
        order = {name: place for place, name in enumerate(TASKS)}
        rows = [row for row in document["rows"] if row["device"] == device]
        rows.sort(key=lambda row: (order[row["task"]], row["precision"], row["designs"]))
        lines.extend(map(_line, rows))
        lines.append("")
    versions = ", ".join(f"{name} {version}" for name, version in document["versions"].items())
    lines.append(f"Versions: {versions}.\n")
    if len(devices) > 1:
        lines.append(_READING)
    return "\n".join(lines)


def write_page(document: dict[str, Any], folder: Path) -> None:
    """Write `devices.md` into a folder, whole or not at all."""
    write_text(folder / "devices.md", page_of(document))
