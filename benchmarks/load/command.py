"""`python -m benchmarks load`: every task in every size; JSON, table, picture."""

import argparse
import datetime
import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

from ..harness import written_whole
from ..harness.report import machine, versions
from .growth import of_rows
from .tasks import TASKS

#: A size that takes longer is given up; compiling is in it [s].
_LIMIT = 1200.0


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks load", description=__doc__)
    parser.add_argument("tasks", nargs="*", metavar="task", help="which tasks; default all")
    parser.add_argument("--quick", action="store_true", help="without the largest size")
    parser.add_argument("--smoke", action="store_true", help="the two smallest sizes, two samples")
    parser.add_argument(
        "--out", type=Path, default=Path("out/benchmarks"), help="folder for the results"
    )
    parser.add_argument("--list", action="store_true", help="name the tasks and stop")
    given = parser.parse_args(argv)
    unknown = sorted(set(given.tasks) - set(TASKS))
    if unknown:
        parser.error(f"unknown task {', '.join(unknown)}; choose from {', '.join(TASKS)}")
    return given


def _measured(name: str, size: int, seconds: float) -> dict[str, Any]:
    """One size in a process of its own.

    **Raises:** `RuntimeError` with what the process said if it failed.
    """
    command = [sys.executable, "-m", "benchmarks.load.worker", name, str(size)]
    done = subprocess.run(
        [*command, "--seconds", str(seconds)],
        capture_output=True,
        text=True,
        timeout=_LIMIT,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{name}, size {size}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def _bytes(value: int | None) -> str:
    return "" if value is None else f"{value / 1e6:.3g} MB"


def _power(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"


def table(tasks: list[dict[str, Any]]) -> str:
    """The measurements as Markdown: growth first, then every size."""
    header = [
        "task",
        "largest",
        "run time",
        "grows as size to the",
        "memory",
        "grows as size to the",
    ]
    lines = ["# load", "", _row([*header, "largest error"]), _row(["---"] * 7)]
    for task in tasks:
        last = task["sizes"][-1]
        cells = [task["title"], f"{last['count']:,} {task['unit']}s", f"{last['best_s']:.3g} s"]
        cells += [_power(task["exponents"]["time"]), _bytes(last["run_bytes"])]
        cells += [_power(task["exponents"]["memory"])]
        worst = max(row["error"] for row in task["sizes"])
        lines.append(_row([*cells, f"{worst:.1e}, {task['check']}"]))
    header = ["task", "size", "run time", "first call", "memory", "peak of the process", "error"]
    lines += ["", _row(header), _row(["---"] * 7)]
    for task in tasks:
        for row in task["sizes"]:
            cells = [task["name"], f"{row['count']:,}", f"{row['best_s']:.3g} s"]
            cells += [f"{row['first_call_s']:.3g} s", _bytes(row["run_bytes"])]
            lines.append(_row([*cells, _bytes(row["peak_bytes"]), f"{row['error']:.1e}"]))
    return "\n".join([*lines, ""])


def _row(cells: list[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def main(argv: list[str] | None = None) -> int:
    """Entry point; the exit status is 1 where a result is not finite or a code says it failed."""
    given = _arguments(argv)
    tasks = []
    for name in given.tasks or TASKS:
        task = TASKS[name]
        if given.list:
            print(f"{name:22} {task.title}, up to {task.sizes[-1]:,}")
            continue
        sizes = task.sizes[:2] if given.smoke else task.sizes[:-1] if given.quick else task.sizes
        rows = [_measured(name, size, 0.0 if given.smoke else 1.0) for size in sizes]
        tasks.append(
            {
                "name": name,
                "title": task.title,
                "unit": task.unit,
                "check": task.check,
                "sizes": rows,
                "exponents": of_rows(rows),
            }
        )
        print(f"{name}: {tasks[-1]['exponents']}", flush=True)
    if given.list:
        return 0
    text = table(tasks)
    print(text)
    document = {
        "schema": 1,
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "quick": given.quick or given.smoke,
        "machine": machine(),
        "versions": versions(),
        "tasks": tasks,
    }
    _write(document, text, given.out)
    return int(any(not math.isfinite(row["error"]) for task in tasks for row in task["sizes"]))


def _write(document: dict[str, Any], text: str, folder: Path) -> None:
    from .picture import draw

    with written_whole(folder / "load.json") as temporary:
        # NaN is not JSON: a size without an error has none there.
        content = json.loads(json.dumps(document), parse_constant=lambda _: None)
        temporary.write_text(json.dumps(content, indent=1, ensure_ascii=False), encoding="utf-8")
    with written_whole(folder / "load.md") as temporary:
        temporary.write_text(text, encoding="utf-8")
    draw(document["tasks"], folder / "load.png")
