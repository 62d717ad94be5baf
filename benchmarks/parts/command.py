"""`python -m benchmarks parts`: every example with and without each optional part; JSON, page."""

import argparse
import json
import time
from typing import Any

import prsm_jax as prsm
from prsm_jax.explanation import PROGRAMS

from ..harness import of_this_run, parser_of, read_json, run_worker, write_json
from .page import tables, write_page

#: An example that takes longer is given up [s].
_LIMIT = 900.0


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("parts", __doc__)
    parser.add_argument("examples", nargs="*", help="which examples; default all")
    parser.add_argument("--programs", nargs="*", choices=PROGRAMS, default=None)
    parser.add_argument(
        "--count-only", action="store_true", help="equations only: nothing is compiled"
    )
    parser.add_argument(
        "--add", action="store_true", help="keep the other examples of an earlier run"
    )
    parser.add_argument("--limit", type=float, default=_LIMIT, help="time limit for an example [s]")
    given = parser.parse_args(argv)
    unknown = sorted(set(given.examples) - set(prsm.file.example_names()))
    if unknown:
        parser.error(f"unknown example {', '.join(unknown)}; see `prsm example`")
    return given


def _measured(example: str, given: argparse.Namespace) -> dict[str, Any]:
    """One example in a process of its own; what went wrong is its `error`."""
    words = [example]
    if given.programs is not None:
        words += ["--programs", *given.programs]
    if given.count_only:
        words.append("--count-only")
    empty = {"example": example, "programs": [], "parts": []}
    done = run_worker("parts.worker", words, given.limit)
    if done is None:
        return {**empty, "error": f"not done in {given.limit:g} s"}
    if done.returncode:
        return {**empty, "error": done.stderr.strip().splitlines()[-1]}
    return json.loads(done.stdout)


def main(argv: list[str] | None = None) -> int:
    """Entry point; the exit status is 1 where an example failed."""
    given = _arguments(argv)
    if given.page is not None:
        print(f"parts: {write_page(read_json(given.page), given.docs or given.out)}")
        return 0
    path = given.out / "parts.json"
    rows: dict[str, Any] = {}
    if given.add and path.exists():
        rows = {r["example"]: r for r in read_json(path)["examples"]}
    document: dict[str, Any] = {}
    for example in given.examples or prsm.file.example_names():
        begin = time.perf_counter()
        rows[example] = _measured(example, given)
        print(f"{example}: {time.perf_counter() - begin:.0f} s", flush=True)
        # After each example: a run that is stopped keeps those that are done.
        examples = [rows[name] for name in prsm.file.example_names() if name in rows]
        document = of_this_run(1) | {"examples": examples}
        write_json(path, document)
    print(tables(document["examples"]))
    if given.docs is not None:
        print(f"parts: {write_page(document, given.docs)}")
    return int(any(row["error"] for row in document["examples"]))
