"""`python -m benchmarks load`: every task in every size; JSON, tables, picture, page."""

import argparse
import json
import math
import time
from pathlib import Path
from typing import Any

from ..harness import (
    of_this_run,
    parser_of,
    read_json,
    refuse_unknown,
    run_worker,
    write_json,
    write_text,
)
from .growth import of_rows
from .page import tables, write_page
from .picture import draw
from .tasks import TASKS

#: A size that takes longer is given up; compiling is in it [s].
_LIMIT = 1200.0


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("load", __doc__, several=True)
    parser.add_argument("tasks", nargs="*", metavar="task", help="which tasks; default all")
    parser.add_argument("--quick", action="store_true", help="without the largest size")
    parser.add_argument("--smoke", action="store_true", help="the two smallest sizes, two samples")
    parser.add_argument("--list", action="store_true", help="list the tasks and exit")
    given = parser.parse_args(argv)
    refuse_unknown(parser, "task", given.tasks, TASKS)
    return given


def _measured(name: str, size: int, seconds: float) -> dict[str, Any]:
    """One size in a process of its own.

    **Raises:** `RuntimeError` with what the process said if it failed.
    """
    done = run_worker("load.worker", [name, str(size), "--seconds", str(seconds)], _LIMIT)
    if done is None or done.returncode:
        why = f"not done in {_LIMIT:g} s" if done is None else done.stderr.strip()
        raise RuntimeError(f"{name}, size {size}: {why}")
    return json.loads(done.stdout)


def main(argv: list[str] | None = None) -> int:
    """Entry point; the exit status is 1 where a result is not finite or a code says it failed."""
    given = _arguments(argv)
    if given.page is not None:
        _said(write_page(_joined([*map(read_json, given.page)]), given.docs or given.out))
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
        **of_this_run(2),
        "seconds": seconds,
        "quick": quick,
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
    # NaN is not JSON: a size without an error has none there.
    content = json.loads(json.dumps(document), parse_constant=lambda _: None)
    write_json(folder / "load.json", content)
    write_text(folder / "load.md", tables(document["tasks"]))
    draw(document["tasks"], folder / "load.png")
