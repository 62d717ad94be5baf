"""`docs/devices.md`: designs a second on each device, from one run."""

from pathlib import Path
from typing import Any

from ..harness import written_whole
from .tasks import TASKS

_HEAD = """\
# Processors and accelerators

This page is written by `python -m benchmarks devices --docs docs`. It does not change by hand.

The same functions run unchanged on every device that JAX sees. Where JAX sees no accelerator, the
command says so and measures the processor alone.

The **share of the ceiling** is the least time that the device needs, over the time measured. The
least time is the longer one of two: the operations that XLA counts, at the rate of multiplications
and additions that stay in registers; inputs and results, each moved once, at the rate of a copy.
Both rates were measured in the same run. XLA counts one trip of a loop, so shares of tasks with
loops (meshing, the chain, RODASP) are lower bounds. The **error** is the largest difference from
the same in float64 on the processor, over the largest entry of each result, 1,000 designs.
"""

_READING = """\
## What to read from it

* Short functions without loops (Hertz, meshing, frequencies) reach a tenth of the ceiling of an
  accelerator. They are one kernel each, bound by divisions, roots and the latency of long chains of
  scalars, not by memory.
* The chain from geometry to efficiency and frequencies is many kernels, each of which reads and
  writes memory. 10,000 designs do not fill an accelerator: give it 100,000 or more at once.
* Settling in closed form is as fast as the memory allows a history of 21 samples to be written.
* RODASP takes its steps in lock step: all designs of a batch take as many as the slowest one.
* A processor wants chunks of about 1,000 designs, which fit its cache
  (`prsm_jax.sweep.map_in_chunks`); an accelerator wants all that fit its memory.
"""


def _line(row: dict[str, Any]) -> str:
    first = [TASKS[row["task"]].title, f"{row['designs']:,}", row["precision"]]
    if "failure" in row:
        return "| " + " | ".join([*first, row["failure"], "", "", "", ""]) + " |"
    rest = [
        f"{row['designs_per_second']:.2e}",
        f"{1e9 * row['seconds'] / row['designs']:.3g} ns",
        f"{100 * row['share_of_ceiling']:.2g} %",
        f"{row['error']:.0e}",
        f"{row['compile_seconds']:.2g} s",
    ]
    return "| " + " | ".join([*first, *rest]) + " |"


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
    with written_whole(folder / "devices.md") as path:
        path.write_text(page_of(document))
