"""`python -m benchmarks load`: every task in every size; JSON, tables, picture, page."""

import argparse
import datetime
import json
import math
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from ..harness import written_whole
from ..harness.report import machine, versions
from .growth import of_rows
from .page import tables, write_page
from .picture import draw
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
    parser.add_argument("--docs", type=Path, default=None, help="folder for the page and picture")
    parser.add_argument(
        "--page", type=Path, nargs="+", metavar="JSON", help="only the page, from these files"
    )
    parser.add_argument("--list", action="store_true", help="list the tasks and exit")
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


def main(argv: list[str] | None = None) -> int:
    """Entry point; the exit status is 1 where a result is not finite or a code says it failed."""
    given = _arguments(argv)
    if given.page is not None:
        parts = [json.loads(path.read_text(encoding="utf-8")) for path in given.page]
        _said(write_page(_joined(parts), given.docs or given.out))
        return 0
    begin, tasks, document = time.perf_counter(), [], {}
    for name in given.tasks or TASKS:
        task = TASKS[name]
        if given.list:
            print(f"{name:22} {task.title}, up to {task.sizes[-1]:,} {task.unit}s")
            continue
        sizes = task.sizes[:2] if given.smoke else task.sizes[:-1] if given.quick else task.sizes
        rows = [_measured(name, size, 0.0 if given.smoke else 1.0) for size in sizes]
        tasks.append(
            {
                "name": name,
                "title": task.title,
                "unit": task.unit,
                "check": task.check,
                "expected": task.expected,
                "why": task.why,
                "sizes": rows,
                "exponents": of_rows(rows),
            }
        )
        print(f"{name}: {tasks[-1]['exponents']}", flush=True)
        # After each task: a run that is stopped keeps those that are done.
        document = _document(tasks, time.perf_counter() - begin, given.quick or given.smoke)
        _write(document, given.out)
    if given.list:
        return 0
    print(tables(tasks))
    if given.docs is not None:
        _said(write_page(document, given.docs))
    return int(any(not math.isfinite(row["error"]) for task in tasks for row in task["sizes"]))


def _document(tasks: list[dict[str, Any]], seconds: float, quick: bool) -> dict[str, Any]:
    return {
        "schema": 2,
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "seconds": seconds,
        "quick": quick,
        "machine": machine(),
        "versions": versions(),
        "tasks": tasks,
    }


def _joined(parts: list[dict[str, Any]]) -> dict[str, Any]:
    """Runs of some tasks each as one, in the order of all tasks; a later file wins."""
    found = {task["name"]: task for part in parts for task in part["tasks"]}
    tasks = [
        {**found[name], "why": TASKS[name].why, "exponents": of_rows(found[name]["sizes"])}
        for name in TASKS
        if name in found
    ]
    return {**parts[-1], "tasks": tasks, "seconds": sum(part["seconds"] for part in parts)}


def _said(paths: list[Path]) -> None:
    print(f"load: {', '.join(str(path) for path in paths)}")


def _write(document: dict[str, Any], folder: Path) -> None:
    with written_whole(folder / "load.json") as temporary:
        # NaN is not JSON: a size without an error has none there.
        content = json.loads(json.dumps(document), parse_constant=lambda _: None)
        temporary.write_text(json.dumps(content, indent=1, ensure_ascii=False), encoding="utf-8")
    with written_whole(folder / "load.md") as temporary:
        temporary.write_text(tables(document["tasks"]), encoding="utf-8")
    draw(document["tasks"], folder / "load.png")
