"""`python -m tests.mutation`: puts single faults into the core and counts those that tests see.

Faults are drawn by a seed from all operators, comparisons, constants, signs and names of the core,
evenly over its text. Each is put into a copy of the package and tried against the quick tests of
its room until the first one fails; tests that fail without a fault are left out. Results go to a
JSON file as they come, so that a run can be stopped and taken up again. Faults that no test sees
are listed at the end, with the reason where `reasons.json` has one. A fault takes about a minute.
"""

import argparse
import concurrent.futures
import dataclasses
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from .operators import Fault, faults
from .rooms import ROOMS, core_files, quick_tests

_ROOT = Path(__file__).parents[2]
_PACKAGE = _ROOT / "prsm_jax"
_REASONS = Path(__file__).parent / "reasons.json"
#: A fault that makes a test run for so long has been seen [s].
_PATIENCE = 900.0


def draw(count: int, seed: int, rooms: tuple[str, ...]) -> list[Fault]:
    """So many faults, the same ones for the same seed and the same files."""
    pool = []
    for path in core_files(_PACKAGE):
        name = str(path.relative_to(_PACKAGE))
        if name.partition("/")[0] in rooms:
            pool += faults(name, path.read_text())
    return random.Random(seed).sample(pool, min(count, len(pool)))


def _words(fault: Fault) -> str:
    line = (_PACKAGE / fault.path).read_text().splitlines()[fault.line - 1].strip()
    return f"{fault.path}:{fault.line}: {fault.old!r} → {fault.new!r} in `{line}`"


def _copy(folder: Path) -> None:
    """The tree without what is built, for a worker of its own."""
    for name in ("prsm_jax", "tests", "docs", "benchmarks"):
        if (_ROOT / name).exists():
            ignore = shutil.ignore_patterns("__pycache__", "images", "*.png", "*.svg")
            shutil.copytree(_ROOT / name, folder / name, ignore=ignore)
    shutil.copy(_ROOT / "pyproject.toml", folder)


def _failures(test: str, folder: Path, *options: str) -> list[str]:
    """Names of the quick tests of a file that fail."""
    words = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-m", "not slow"]
    words += ["-p", "no:cacheprovider", *options, f"tests/{test}"]
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    done = subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, timeout=_PATIENCE
    )
    if done.returncode in (0, 5):
        return []
    lines = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return [line.split(" ")[1] for line in lines] or [f"tests/{test}"]


def _failing(chosen: list[Fault], folder: Path) -> list[str]:
    """Tests that fail without any fault, which tell nothing."""
    every = dict.fromkeys(test for fault in chosen for test in quick_tests(fault.path))
    found = []
    for test in every:
        failing = _failures(test, folder)
        print(f"{len(failing):3} fail without a fault: {test}", flush=True)
        found += failing
    return found


def _try(fault: Fault, folder: Path, failing: list[str]) -> dict:
    """Put a fault in, run its tests, take it out."""
    target = folder / "prsm_jax" / fault.path
    sound = target.read_text()
    options = ["-x", *(f"--deselect={name}" for name in failing)]
    began = time.monotonic()
    seen, by = "", ""
    try:
        target.write_text(fault.applied(sound))
        try:
            compile(target.read_text(), str(target), "exec")
        except SyntaxError:
            return {"seen": "no program", "by": "", "seconds": 0.0}
        for test in quick_tests(fault.path):
            try:
                found = _failures(test, folder, *options)
            except subprocess.TimeoutExpired:
                seen, by = "time", test
                break
            if found:
                seen, by = "test", found[0]
                break
    finally:
        target.write_text(sound)
    return {"seen": seen, "by": by, "seconds": round(time.monotonic() - began, 1)}


def _run(chosen: list[Fault], output: Path, jobs: int) -> list[dict]:
    known: dict[str, dict] = {}
    if output.exists():
        known = {row["fault"]: row for row in json.loads(output.read_text())["faults"]}
    rows = {_words(fault): known.get(_words(fault)) for fault in chosen}
    todo = [fault for fault in chosen if rows[_words(fault)] is None]

    def save() -> None:
        output.parent.mkdir(parents=True, exist_ok=True)
        done = [row for row in rows.values() if row is not None]
        output.write_text(json.dumps({"faults": done}, indent=1, ensure_ascii=False) + "\n")

    with tempfile.TemporaryDirectory() as place:
        free = []
        for index in range(jobs):
            free.append(Path(place) / str(index))
            _copy(free[-1])

        failing = _failing(todo, free[0])

        def work(fault: Fault) -> tuple[Fault, dict]:
            folder = free.pop()
            try:
                return fault, _try(fault, folder, failing)
            finally:
                free.append(folder)

        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            for future in concurrent.futures.as_completed([pool.submit(work, f) for f in todo]):
                fault, result = future.result()
                row = {"fault": _words(fault), **dataclasses.asdict(fault), **result}
                rows[_words(fault)] = row
                print(f"{result['seen'] or 'NOT SEEN':10} {row['seconds']:6.1f} s  {row['fault']}",
                      flush=True)  # fmt: skip
                save()
    save()
    return [row for row in rows.values() if row is not None]


def _report(rows: list[dict]) -> float:
    """Print a table by room and those that were not seen; the share of faults that was seen."""
    reasons = json.loads(_REASONS.read_text()) if _REASONS.exists() else {}
    tried = [row for row in rows if row["seen"] != "no program"]
    print(f"\n{'room':14} {'faults':>6} {'seen':>6} {'excused':>8}")
    for room in (*ROOMS, ""):
        mine = [row for row in tried if row["path"].startswith(room)]
        if not mine:
            continue
        seen = sum(bool(row["seen"]) for row in mine)
        excused = sum(not row["seen"] and _key(row) in reasons for row in mine)
        print(f"{room or 'together':14} {len(mine):6} {seen:6} {excused:8}")
    missed = [row for row in tried if not row["seen"]]
    if missed:
        print("\nnot seen:")
    for row in missed:
        print(f"  {row['fault']}\n      {reasons.get(_key(row), 'no reason known')}")
    return sum(bool(row["seen"]) for row in tried) / max(len(tried), 1)


def _key(row: dict) -> str:
    """A fault without the number of its line, which moves."""
    place, _, rest = row["fault"].partition(": ")
    return f"{place.rpartition(':')[0]}: {rest}"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description=__doc__)
    parser.add_argument("--count", type=int, default=150, help="how many faults")
    parser.add_argument("--seed", type=int, default=13)
    parser.add_argument("--rooms", default=",".join(ROOMS), help="separated by commas")
    parser.add_argument("--jobs", type=int, default=1, help="faults tried at once")
    parser.add_argument("--output", type=Path, default=Path("out/mutation.json"))
    parser.add_argument("--least", type=float, default=0.9, help="share that has to be seen")
    parser.add_argument("--list", action="store_true", help="only print the faults")
    given = parser.parse_args()
    chosen = draw(given.count, given.seed, tuple(given.rooms.split(",")))
    if given.list:
        print("\n".join(_words(fault) for fault in chosen))
        return 0
    share = _report(_run(chosen, given.output, given.jobs))
    print(f"\n{100 * share:.1f} % of the faults were seen")
    return int(share < given.least)


if __name__ == "__main__":
    raise SystemExit(main())
