"""`python -m benchmarks programs`: time to compile and to run each program; JSON, page."""

import argparse
import json
from pathlib import Path
from typing import Any

from ..harness import of_this_run, parser_of, read_json, refuse_unknown, run_worker, write_json
from .functions import BATCHES, EXAMPLES, FUNCTIONS, KINDS
from .page import compared, tables, write_page

#: A program that takes longer is given up [s].
_LIMIT = 240.0
_EMPTY = dict.fromkeys(
    ("equations", "trace_s", "lower_s", "compile_s", "flops", "run_s", "finite"), None
)


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("programs", __doc__)
    parser.add_argument("names", nargs="*", help=f"functions, of {', '.join(FUNCTIONS)}")
    parser.add_argument("--examples", nargs="*", choices=EXAMPLES, default=EXAMPLES)
    parser.add_argument("--kinds", nargs="*", choices=KINDS, default=KINDS)
    parser.add_argument("--batches", nargs="*", type=int, choices=BATCHES, default=BATCHES)
    parser.add_argument("--limit", type=float, default=_LIMIT, help="time limit for a program [s]")
    parser.add_argument("--add", action="store_true", help="keep other programs of earlier runs")
    parser.add_argument("--against", type=Path, metavar="JSON", help="print ratios to an older run")
    given = parser.parse_args(argv)
    refuse_unknown(parser, "function", given.names, FUNCTIONS)
    return given


def measured(example: str, name: str, kind: str, batch: int, limit: float) -> dict[str, Any]:
    """One program in a process of its own; what went wrong is its `error`."""
    row = {"example": example, "function": name, "kind": kind, "batch": batch, **_EMPTY}
    done = run_worker("programs.worker", [example, name, kind, str(batch)], limit)
    if done is None:
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
        print(f"programs: {write_page(read_json(given.page), given.docs or given.out)}")
        return 0
    path = given.out / "programs.json"
    rows: dict[tuple[Any, ...], dict[str, Any]] = {}
    if given.add and path.exists():
        rows = {_key(r): r for r in read_json(path)["programs"]}
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
                    document = of_this_run(1) | {"programs": [rows[key] for key in sorted(rows)]}
                    write_json(path, document)
    print(tables(document["programs"]))
    if given.against is not None:
        print(compared(document, read_json(given.against)))
    if given.docs is not None:
        print(f"programs: {write_page(document, given.docs)}")
    return 0
