"""`docs/sweep_throughput.md`: a million designs, call sizes, threads and shards, and the model."""

import statistics
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..harness import table_of, where_and_when, write_text

_HEAD = """\
# Throughput of sweeps

This page is written by `python -m benchmarks sweeps --docs docs`. Do not edit it by hand.

The designs are a grid over lead, contact angle and roller radius, within 10 % of the actuator. For
every design the sweep computes natural frequencies, efficiency and largest contact pressure,
beginning with the geometry, and writes them to a store. Other work on the machine lengthens all
run times, and the processor times of all threads by less. Ratios are those of measurements taken
in turn in one run.
"""

_WHAT = """\
* **Sweep**: one call of `prsm_jax.sweep` with a store, in a process that has compiled the program:
  plan, arguments, compiled program, results, files.
* **Kernel**: the compiled program alone on the same designs, in calls of the same size, by as many
  threads; arguments are ready, and results are dropped.
* **Outside**: 1 − kernel/sweep, by wall time and by processor time; median of the rounds. If other
  work needs the cores, the value by wall time is noise (it can be below zero); the value by
  processor time is not.
* **Memory**: largest memory of the process, after compiling and after the sweep.
* **Compiling**: tracing, compiling and the first block.
"""

_RIVAL = """\
The rival computes the same numbers with SciPy, one design after another, in plain floats: `root`
(hybr) for meshing, `brentq` and `ellipkm1` for two Hertz contacts, `eigh` for 20 degrees of
freedom, and a linear equation for the steady state. Its actuator shares the load equally among
threads and has neither spin nor rolling losses, because these need root searches of many unknowns.
In this comparison our actuator is the same; the kernel is then so short that files and results take
half of the time. The loop uses one core, and a sweep uses all cores: the ratio of processor times
is that of one core.
"""

_CALLS = """\
A block is computed in calls that are small enough for the cache. On a processor the size of a call
is one core's share of the largest cache divided by 8 kB, as a power of two from 512 to 4,096; XLA
reserves 8.4 kB for a design of the actuator. The sizes below were measured in turn, with the kernel
alone on one thread. The times are those of a design, the best of the rounds.
"""

_SHARED = """\
Each thread may use one core. While other work uses the cores too, run times do not show the gain of
more threads. The processor time of a design shows the cost of a shared store.
"""

_MODEL = """\
## Many cores: model

`t = s + N/(p r)`: s is the time in which a process starts and compiles, r the rate of one thread
with its writes, p the number of threads in all processes. The threads share only the file system,
which must be able to write at the rates in the last two columns. s and r (both in processor time),
bytes and files are measured; the table follows from the model.
"""


def _median(rounds: list[dict[str, Any]], value: Callable[[dict[str, Any]], float]) -> float:
    return statistics.median(map(value, rounds))


def _best(row: dict[str, Any], what: str, key: str) -> float:
    return min(one[what][key] for one in row["rounds"])


def outside(row: dict[str, Any], key: str) -> float:
    """Share of a sweep's time outside the kernel, median over the rounds.

    **Arguments:**

    - `row`: what the worker found.
    - `key`: `wall_s` or `processor_s`.
    """
    return _median(row["rounds"], lambda one: 1 - one["kernel"][key] / one["sweep"][key])


def ratio(row: dict[str, Any], key: str) -> float:
    """Time of a design by the rival over that by a sweep, median over the rounds."""
    each = row["points"] / row["rival_designs"]
    return _median(row["rounds"], lambda one: each * one["rival"][key] / one["sweep"][key])


def _megabytes(value: float | None) -> str:
    return "" if value is None else f"{value / 1e6:,.0f} MB"


def _sweeps(rows: list[dict[str, Any]]) -> list[str]:
    heads = ["scene", "findings", "designs", "sweep", "designs a second", "processor a design"]
    heads += ["outside, wall", "outside, processor", "memory", "store", "compiling"]
    lines = []
    for row in rows:
        wall = _best(row, "sweep", "wall_s")
        processor = _best(row, "sweep", "processor_s") / row["points"]
        lines.append(
            [
                row["scene"],
                "yes" if row["findings"] else "no",
                f"{row['points']:,}",
                f"{wall:.3g} s",
                f"{row['points'] / wall:,.0f}",
                f"{1e6 * processor:.3g} µs",
                f"{100 * outside(row, 'wall_s'):.0f} %",
                f"{100 * outside(row, 'processor_s'):.0f} %",
                f"{_megabytes(row['memory']['compiled'])}, {_megabytes(row['memory']['swept'])}",
                f"{_megabytes(row['stored_bytes'])} in {row['files']:,} files",
                f"{row['compile']['wall_s']:.0f} s",
            ]
        )
    return table_of(heads, lines)


def _rivals(rows: list[dict[str, Any]]) -> list[str]:
    heads = ["scene", "SciPy a design", "sweep a design", "ratio, wall", "ratio, processor"]
    heads += ["largest difference"]
    lines = []
    for row in rows:
        if not row["rival_designs"]:
            continue
        theirs = _best(row, "rival", "wall_s") / row["rival_designs"]
        ours = _best(row, "sweep", "wall_s") / row["points"]
        lines.append(
            [
                row["scene"],
                f"{1e6 * theirs:.3g} µs",
                f"{1e6 * ours:.3g} µs",
                f"{ratio(row, 'wall_s'):.0f}",
                f"{ratio(row, 'processor_s'):.0f}",
                ", ".join(f"{name} {value:.0e}" for name, value in row["error"].items()),
            ]
        )
    return table_of(heads, lines)


def _calls(parts: list[dict[str, Any]]) -> list[str]:
    lines = []
    for part in parts:
        best = min(size["processor_us"] for size in part["sizes"])
        for size in part["sizes"]:
            lines.append(
                [
                    part["scene"],
                    f"{size['call']:,}",
                    f"{size['wall_us']:.2f} µs",
                    f"{size['processor_us']:.2f} µs",
                    f"{size['processor_us'] / best:.2f}",
                ]
            )
    return table_of(["scene", "designs in a call", "wall", "processor", "over the best"], lines)


def _alone(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [row for row in rows if (row["processes"], row["cores"]) == (1, 1)]


def _scaling(rows: list[dict[str, Any]]) -> list[str]:
    ways = list(dict.fromkeys((row["processes"], row["cores"]) for row in rows))
    alone, lines = _alone(rows), []
    for way in ways:
        mine = [row for row in rows if (row["processes"], row["cores"]) == way]
        faster = statistics.median(
            one["wall_s"] / row["wall_s"] for one, row in zip(alone, mine, strict=True)
        )
        best = min(mine, key=lambda row: row["wall_s"])
        lines.append(
            [
                f"{way[0]}",
                f"{way[1]}",
                f"{best['wall_s']:.3g} s",
                f"{best['points'] / best['wall_s']:,.0f}",
                f"{faster:.2f}",
                f"{1e6 * min(row['processor_s'] for row in mine) / best['points']:.3g} µs",
            ]
        )
    heads = [
        "processes",
        "threads each",
        "time",
        "designs a second",
        "faster",
        "processor a design",
    ]
    return table_of(heads, lines)


def model(
    designs: float, threads: int, start: float, rate: float, block: int, bytes_each: float
) -> dict[str, float]:
    """Time and load of the file system of a sweep by many processes of one thread.

    **Arguments:**

    - `designs`, `threads`: N and p.
    - `start`: time in which a process starts and compiles [s].
    - `rate`: designs a second of one thread, with its writes.
    - `block`: designs in a block, which has a file for each variable and one for its mark.
    - `bytes_each`: of the store, for a design.
    """
    # A block is computed by one thread.
    turns = -(-designs // (block * threads))
    busy = turns * block / rate
    total = start + min(busy, designs / rate)
    flow = min(threads, designs / block) * rate
    return {
        "seconds": total,
        "efficiency": (start + designs / rate) / (threads * total),
        "bytes_per_second": flow * bytes_each,
        "files_per_second": flow / block * _FILES,
    }


#: Three quantities, three codes, and the mark of the block.
_FILES = 7


def _modelled(document: dict[str, Any]) -> list[str]:
    row = document["sweeps"][0]
    start = row["compile"]["processor_s"]
    rate = row["points"] / _best(row, "sweep", "processor_s")
    each, block = row["stored_bytes"] / row["points"], row["block"]
    lines = [_MODEL, f"s = {start:.0f} s with nothing compiled before, r = {rate:,.0f} designs a "]
    lines[-1] += f"second, {each:.0f} bytes a design, {_FILES} files for {block:,} designs.\n"
    rows = []
    for designs in (1e6, 1e8):
        for threads in (1, 2, 16, 128, 1024):
            found = model(designs, threads, start, rate, block, each)
            rows.append(
                [
                    f"{designs:,.0f}",
                    f"{threads:,}",
                    f"{found['seconds']:,.0f} s",
                    f"{100 * found['efficiency']:.0f} %",
                    f"{found['bytes_per_second'] / 1e6:,.1f} MB/s",
                    f"{found['files_per_second']:,.0f}",
                ]
            )
    heads = ["designs", "threads", "time", "efficiency", "written", "files a second"]
    lines += [*table_of(heads, rows), ""]
    even = start * rate
    lines.append(
        f"Below {even:,.0f} designs for each thread, starting and compiling take longer than "
        "computing: keep compiled programs in a common folder (`PRSM_JAX_CACHE`), or use fewer "
        f"processes. If there are more threads than blocks ({1e6 / block:,.0f} for a million "
        "designs), some threads are idle: use a smaller `chunk`. With many threads the file system "
        "becomes the limit, first by the number of files: use a larger `chunk`."
    )
    return [*lines, ""]


def tables(document: dict[str, Any]) -> str:
    """The measurements as Markdown, as far as there are any."""
    lines: list[str] = []
    if "sweeps" in document:
        lines += ["## A grid of designs", "", _WHAT, *_sweeps(document["sweeps"]), ""]
        lines += ["## Against a loop with SciPy", "", _RIVAL, *_rivals(document["sweeps"]), ""]
    if "calls" in document:
        lines += ["## Designs in a call", "", _CALLS, *_calls(document["calls"]), ""]
    if "scaling" in document:
        count = document["scaling"][0]["points"]
        lines += ["## Threads and shards", ""]
        lines += [
            f"A sweep of {count:,} designs into one store, all programs compiled before.",
            _SHARED,
        ]
        lines += [*_scaling(document["scaling"]), ""]
    if "sweeps" in document:
        lines += _modelled(document)
    return "\n".join(lines)


def write_page(document: dict[str, Any], folder: Path) -> Path:
    """Write the page.

    **Arguments:**

    - `document`: what `sweeps.json` has.
    - `folder`: that of the documentation.

    **Returns:** its path.
    """
    text = "\n".join([_HEAD, f"{where_and_when(document)}.\n", tables(document)])
    return write_text(folder / "sweep_throughput.md", text)
