"""`python -m benchmarks startup`: time from command to answer, cold and warm; JSON, page."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
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
)
from .child import ORDER
from .page import tables, write_page

_CHILD = Path(__file__).with_name("child.py")
#: Each verb, without pictures.
COMMANDS: dict[str, tuple[str, ...]] = {
    "steady": ("steady", "wu2022"),
    "modal": ("modal", "wu2022"),
    "check": ("check", "wu2022"),
    "contact": ("contact", "wu2022"),
    "response": ("response", "wu2022", "--points", "200"),
    "campbell": ("campbell", "wu2022"),
    "simulate": ("simulate", "wu2022"),
    "sensitivity": ("sensitivity", "wu2022"),
    "explain": ("explain", "wu2022"),
    "optimise": ("optimise", "actuator", "--starts", "1"),
    "quantities": ("quantities",),
    "example": ("example", "wu2022"),
}
_IMPORT = "import jax, diffrax"
#: A command that takes longer is given up [s].
_LIMIT = 300.0


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("startup", __doc__)
    parser.add_argument("verbs", nargs="*", help=f"which verbs, of {', '.join(COMMANDS)}")
    parser.add_argument("--rounds", type=int, default=3, help="number of warm runs of each verb")
    parser.add_argument("--add", action="store_true", help="keep other verbs of an earlier run")
    given = parser.parse_args(argv)
    refuse_unknown(parser, "verb", given.verbs, COMMANDS)
    return given


def _run(words: list[str], folder: Path | None) -> tuple[float, float, float, int]:
    """When it began, wall and processor seconds of a process, and its status."""
    environment = {**os.environ, "PRSM_JAX_CACHE": "" if folder is None else str(folder)}
    before = os.times()
    started, begin = time.time(), time.perf_counter()
    done = subprocess.run(
        [sys.executable, *words],
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=_LIMIT,
        check=False,
        cwd=None if folder is None else folder.parent,
    )
    wall, after = time.perf_counter() - begin, os.times()
    used = after.children_user + after.children_system
    processor = used - before.children_user - before.children_system
    return started, wall, processor, done.returncode


def command_row(words: tuple[str, ...], folder: Path) -> dict[str, Any]:
    """One run of a command: wall and processor seconds, and where the wall seconds went.

    **Arguments:**

    - `words`: after `prsm`.
    - `folder`: of the stored programs.
    """
    report = folder.parent / "report.json"
    report.unlink(missing_ok=True)
    started, wall, processor, status = _run([str(_CHILD), str(report), *words], folder)
    told = read_json(report)
    interpreter = told["began"] - started
    parts = {f"{name}_s": told[name] for name in ORDER}
    return {
        "wall_s": wall,
        "processor_s": processor,
        "status": status,
        "interpreter_s": interpreter,
        **parts,
        "rest_s": wall - interpreter - sum(parts.values()),
    }


def _verb(name: str, rounds: int) -> dict[str, Any]:
    """A verb cold, then warm, each warm run beside one of the imports alone."""
    words = COMMANDS[name]
    row: dict[str, Any] = {"verb": name, "command": " ".join(words)}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "programs"
        folder.mkdir()
        try:
            row["cold"] = command_row(words, folder)
            warm, alone = [], []
            for _ in range(rounds):
                _, wall, processor, _ = _run(["-c", _IMPORT], None)
                alone.append({"wall_s": wall, "processor_s": processor})
                warm.append(command_row(words, folder))
        except subprocess.TimeoutExpired:
            return {**row, "error": f"not done in {_LIMIT:g} s"}
    best = min(warm, key=lambda one: one["processor_s"])
    imports = min(alone, key=lambda one: one["processor_s"])
    ratio = best["processor_s"] / imports["processor_s"]
    return {**row, "warm": best, "imports": imports, "over_imports": ratio, "error": None}


def _calls() -> list[dict[str, Any]]:
    """First and later calls in Python, from a process of their own."""
    done = run_worker("startup.calls", [], _LIMIT)
    if done is None or done.returncode:
        print(f"startup: calls in Python failed: {done and done.stderr[-300:]}", file=sys.stderr)
        return []
    return json.loads(done.stdout)


def main(argv: list[str] | None = None) -> int:
    """Entry point; the exit status is 1 if a command did not end."""
    given = _arguments(argv)
    if given.page is not None:
        print(f"startup: {write_page(read_json(given.page), given.docs or given.out)}")
        return 0
    path = given.out / "startup.json"
    rows: dict[str, Any] = {}
    if given.add and path.exists():
        rows = {r["verb"]: r for r in read_json(path)["verbs"]}
    calls = _calls()
    document: dict[str, Any] = {}
    for name in given.verbs or COMMANDS:
        rows[name] = _verb(name, given.rounds)
        print(f"{name}: {rows[name].get('over_imports')}", flush=True)
        verbs = [rows[name] for name in COMMANDS if name in rows]
        document = of_this_run(1) | {"verbs": verbs, "calls": calls}
        write_json(path, document)
    print(tables(document["verbs"]))
    if given.docs is not None:
        print(f"startup: {write_page(document, given.docs)}")
    return int(not calls or any(row["error"] for row in document["verbs"]))
