"""`python -m benchmarks programs`: time to compile and to run each program; JSON, page."""

import argparse
import json
import signal
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from ..harness import of_this_run, parser_of, read_json, refuse_unknown, run_worker, write_json
from .functions import BATCHES, EXAMPLES, FUNCTIONS, KINDS
from .page import compared, tables, totals, write_page

#: A program that takes more processor time is given up [s].
_LIMIT = 240.0
#: And one that takes this many times the limit on the clock: it waits for something.
_WAITING = 10
_EMPTY = dict.fromkeys(
    ("equations", "trace_s", "lower_s", "compile_s", "flops", "run_s", "finite"), None
)


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("programs", __doc__)
    parser.add_argument("names", nargs="*", help=f"functions, of {', '.join(FUNCTIONS)}")
    parser.add_argument("--examples", nargs="*", choices=EXAMPLES, default=EXAMPLES)
    parser.add_argument("--kinds", nargs="*", choices=KINDS, default=KINDS)
    parser.add_argument("--batches", nargs="*", type=int, choices=BATCHES, default=BATCHES)
    parser.add_argument(
        "--limit", type=float, default=_LIMIT, help="processor time of a program [s]"
    )
    parser.add_argument("--add", action="store_true", help="keep other programs of earlier runs")
    parser.add_argument(
        "--beside",
        type=Path,
        metavar="FOLDER",
        help="measure each program also in this checkout of another commit, at the same time",
    )
    parser.add_argument("--against", type=Path, metavar="JSON", help="print ratios to an older run")
    given = parser.parse_args(argv)
    refuse_unknown(parser, "function", given.names, FUNCTIONS)
    return given


def measured(
    example: str, name: str, kind: str, batch: int, limit: float, tree: Path | None = None
) -> dict[str, Any]:
    """One program in a process of its own.

    **Arguments:**

    - `example`, `name`, `kind`, `batch`: as for `program`.
    - `limit`: processor time [s].
    - `tree`: folder of another checkout, whose package is measured.

    **Returns:** what the worker measured. What went wrong is the row's `error`; a program that
    took more processor time has its `limit_s`, too.
    """
    row = {"example": example, "function": name, "kind": kind, "batch": batch, **_EMPTY}
    words = [example, name, kind, str(batch), "--limit", str(limit)]
    words += ["--tree", str(tree.resolve())] if tree else []
    done = run_worker("programs.worker", words, _WAITING * limit)
    if done is None:
        return {**row, "error": f"not done in {_WAITING * limit:g} s on the clock"}
    if hasattr(signal, "SIGXCPU") and done.returncode == -signal.SIGXCPU:
        return {**row, "error": f"not done in {limit:g} s", "limit_s": limit}
    if done.returncode:
        return {**row, "error": f"ended with status {done.returncode}"}
    return row | json.loads(done.stdout)


def _commit(tree: Path) -> str:
    words = ["git", "-C", str(tree), "log", "-1", "--format=%h of %as"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def _key(row: dict[str, Any]) -> tuple[int, int, int, int]:
    return (
        EXAMPLES.index(row["example"]),
        list(FUNCTIONS).index(row["function"]),
        KINDS.index(row["kind"]),
        row["batch"],
    )


def _chosen(given: argparse.Namespace) -> list[tuple[str, str, str, int]]:
    return [
        (example, name, kind, batch)
        for example in given.examples
        for name in given.names or FUNCTIONS
        for kind in given.kinds
        if kind != "hessian" or FUNCTIONS[name][1] is not None
        for batch in given.batches
    ]


def main(argv: list[str] | None = None) -> int:
    """Entry point; a program that fails is a row with its error, and the exit status stays 0."""
    given = _arguments(argv)
    if given.page is not None:
        print(f"programs: {write_page(read_json(given.page), given.docs or given.out)}")
        return 0
    path = given.out / "programs.json"
    trees: dict[str, Path | None] = {"programs": None}
    if given.beside is not None:
        trees["beside"] = given.beside
    document: dict[str, Any] = read_json(path) if given.add and path.exists() else {}
    if given.beside is not None:
        commit = _commit(given.beside)
        if document.get("beside_commit") != commit:
            document |= {"beside_commit": commit, "beside": []}
    rows = {key: {_key(r): r for r in document.get(key, [])} for key in ("programs", "beside")}
    for program in _chosen(given):
        with ThreadPoolExecutor(len(trees)) as at_once:
            runs = {
                key: at_once.submit(measured, *program, given.limit, tree)
                for key, tree in trees.items()
            }
        for key, run in runs.items():
            row = run.result()
            rows[key][_key(row)] = row
            print(key, *program, row["compile_s"], row["error"], flush=True)
        if given.beside is None:
            # Not measured at the same time any more.
            rows["beside"].pop(_key(row), None)
        document |= of_this_run(1) | {k: [r[key] for key in sorted(r)] for k, r in rows.items()}
        write_json(path, document)
    print(tables(document["programs"]))
    if document["beside"]:
        print(totals(document))
    if given.against is not None:
        print(compared(document, read_json(given.against)))
    if given.docs is not None:
        print(f"programs: {write_page(document, given.docs)}")
    return 0
