"""`python -m benchmarks programs`: time to compile and to run each program; JSON, page."""

import argparse
import datetime
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from ..harness import written_whole
from ..harness.report import machine, versions
from .functions import BATCHES, EXAMPLES, FUNCTIONS, KINDS
from .page import compared, tables, write_page

#: A program that takes longer is given up [s].
_LIMIT = 240.0
_EMPTY = dict.fromkeys(
    ("equations", "trace_s", "lower_s", "compile_s", "flops", "run_s", "finite"), None
)


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks programs", description=__doc__)
    parser.add_argument("names", nargs="*", help=f"functions, of {', '.join(FUNCTIONS)}")
    parser.add_argument("--examples", nargs="*", choices=EXAMPLES, default=EXAMPLES)
    parser.add_argument("--kinds", nargs="*", choices=KINDS, default=KINDS)
    parser.add_argument("--batches", nargs="*", type=int, choices=BATCHES, default=BATCHES)
    parser.add_argument("--limit", type=float, default=_LIMIT, help="time limit for a program [s]")
    parser.add_argument("--add", action="store_true", help="keep other programs of earlier runs")
    parser.add_argument("--against", type=Path, metavar="JSON", help="print ratios to an older run")
    parser.add_argument(
        "--out", type=Path, default=Path("out/benchmarks"), help="folder for the results"
    )
    parser.add_argument("--docs", type=Path, default=None, help="folder for the page")
    parser.add_argument("--page", type=Path, metavar="JSON", help="only the page, from this file")
    given = parser.parse_args(argv)
    unknown = sorted(set(given.names) - set(FUNCTIONS))
    if unknown:
        parser.error(f"unknown function {', '.join(unknown)}; choose from {', '.join(FUNCTIONS)}")
    return given


def measured(example: str, name: str, kind: str, batch: int, limit: float) -> dict[str, Any]:
    """One program in a process of its own; what went wrong is its `error`."""
    row = {"example": example, "function": name, "kind": kind, "batch": batch, **_EMPTY}
    command = [sys.executable, "-m", "benchmarks.programs.worker"]
    try:
        done = subprocess.run(
            [*command, example, name, kind, str(batch)],
            capture_output=True,
            text=True,
            timeout=limit,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return {**row, "error": f"not done in {limit:g} s"}
    if done.returncode:
        return {**row, "error": f"ended with status {done.returncode}"}
    return row | json.loads(done.stdout)


def _key(row: dict[str, Any]) -> tuple[int, int, int, int]:
    return (
        EXAMPLES.index(row["example"]),
        list(FUNCTIONS).index(row["function"]),
        KINDS.index(row["kind"]),
        row["batch"],
    )


def main(argv: list[str] | None = None) -> int:
    """Entry point; a program that fails is a row with its error, and the exit status stays 0."""
    given = _arguments(argv)
    if given.page is not None:
        document = json.loads(given.page.read_text(encoding="utf-8"))
        print(f"programs: {write_page(document, given.docs or given.out)}")
        return 0
    path = given.out / "programs.json"
    rows: dict[tuple[Any, ...], dict[str, Any]] = {}
    if given.add and path.exists():
        rows = {_key(r): r for r in json.loads(path.read_text(encoding="utf-8"))["programs"]}
    document: dict[str, Any] = {}
    for example in given.examples:
        for name in given.names or FUNCTIONS:
            for kind in given.kinds:
                if kind == "hessian" and FUNCTIONS[name][1] is None:
                    continue
                for batch in given.batches:
                    row = measured(example, name, kind, batch, given.limit)
                    rows[_key(row)] = row
                    print(example, name, kind, batch, row["compile_s"], row["error"], flush=True)
                    document = {
                        "schema": 1,
                        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
                        "machine": machine(),
                        "versions": versions(),
                        "programs": [rows[key] for key in sorted(rows)],
                    }
                    _write(document, path)
    print(tables(document["programs"]))
    if given.against is not None:
        print(compared(document, json.loads(given.against.read_text(encoding="utf-8"))))
    if given.docs is not None:
        print(f"programs: {write_page(document, given.docs)}")
    return 0


def _write(document: dict[str, Any], path: Path) -> None:
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(document, indent=1, ensure_ascii=False), encoding="utf-8")
