"""`python -m benchmarks sweeps`: a million designs, call sizes, threads and shards; JSON, page."""

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Generator
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
from .page import tables, write_page

#: A measurement that takes longer is given up [s].
_LIMIT = 900.0
_WHOLE, _EQUAL = "actuator", "actuator as the rival has it"
#: Ways to share a sweep on this machine: processes, and cores of each.
_WAYS = ((1, 1), (1, 2), (2, 1))
_SIZES = (256, 512, 1024, 2048, 4096, 8192, 16384, 32768)
PARTS = ("sweeps", "calls", "scaling")


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("sweeps", __doc__)
    parser.add_argument("parts", nargs="*", help=f"which parts, of {', '.join(PARTS)}")
    parser.add_argument("--quick", action="store_true", help="27,000 designs, few call sizes")
    parser.add_argument("--add", action="store_true", help="keep other parts of an earlier run")
    given = parser.parse_args(argv)
    refuse_unknown(parser, "part", given.parts, PARTS)
    return given


def _worker(*words: object) -> dict[str, Any]:
    """One measurement in a process of its own.

    **Raises:** `RuntimeError` with what the process said if it failed.
    """
    done = run_worker("sweeps.worker", [str(word) for word in words], _LIMIT)
    if done is None or done.returncode:
        why = f"not done in {_LIMIT:g} s" if done is None else done.stderr.strip()
        raise RuntimeError(f"sweeps {' '.join(map(str, words))}: {why}")
    return json.loads(done.stdout)


def _sweeps(quick: bool) -> list[dict[str, Any]]:
    """Both scenes, and the whole one with findings."""
    side, fewer, rounds = (30, 20, 2) if quick else (100, 60, 3)
    theirs = 100 if quick else 3000
    plans = (
        ("--scene", _WHOLE, "--side", side),
        ("--scene", _WHOLE, "--side", fewer, "--findings"),
        ("--scene", _EQUAL, "--side", side, "--rival", theirs),
    )
    return [_worker("throughput", "--rounds", rounds, *plan) for plan in plans]


def _calls(quick: bool) -> list[dict[str, Any]]:
    sizes = (512, 4096) if quick else _SIZES
    scenes = (_EQUAL,) if quick else (_WHOLE, _EQUAL)
    rounds = 2 if quick else 5
    return [_worker("calls", "--scene", s, "--rounds", rounds, "--sizes", *sizes) for s in scenes]


@contextlib.contextmanager
def _programs_kept() -> Generator[None, None, None]:
    """Worker processes find programs that others of them have compiled."""
    names = ("JAX_COMPILATION_CACHE_DIR", "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS")
    before = {name: os.environ.get(name) for name in names}
    with tempfile.TemporaryDirectory() as folder:
        os.environ |= dict(zip(names, (folder, "0"), strict=True))
        try:
            yield
        finally:
            for name, value in before.items():
                os.environ.pop(name, None)
                if value is not None:
                    os.environ[name] = value


def _scaling(quick: bool) -> list[dict[str, Any]]:
    """One sweep by one thread, by two, and by two processes of one thread."""
    scene, side, rounds = (_EQUAL, 30, 1) if quick else (_WHOLE, 60, 2)
    ways = [way for way in _WAYS if way[0] * way[1] <= len(os.sched_getaffinity(0))]
    rows: list[dict[str, Any]] = []
    with _programs_kept():
        for _ in range(rounds):
            rows += [_shared(scene, side, processes, cores) for processes, cores in ways]
    return rows


def _shared(scene: str, side: int, processes: int, cores: int) -> dict[str, Any]:
    """One sweep by several processes that begin together."""
    with tempfile.TemporaryDirectory() as place:
        store = Path(place) / "a.zarr"
        workers = [
            _waiting(scene, side, (number + 1, processes), store, cores)
            for number in range(processes)
        ]
        try:
            for worker in workers:
                assert worker.stdout is not None
                if worker.stdout.readline().strip() != "ready":
                    raise RuntimeError(f"sweeps: a shard of {scene} ended before it began")
            told = [worker.communicate("\n", timeout=_LIMIT)[0] for worker in workers]
        finally:
            for worker in workers:
                worker.kill()
                worker.wait()
    found = [json.loads(text) for text in told]
    return {
        "scene": scene,
        "points": found[0]["points"],
        "processes": processes,
        "cores": cores,
        "wall_s": max(one["ended"] for one in found) - min(one["began"] for one in found),
        "processor_s": sum(one["processor_s"] for one in found),
        "compile": found[0]["compile"],
    }


def _waiting(
    scene: str, side: int, shard: tuple[int, int], store: Path, cores: int
) -> subprocess.Popen[str]:
    words = ["share", "--scene", scene, "--side", side, "--shard", *shard]
    words += ["--store", store, "--cores", cores, "--place", shard[0] - 1]
    return subprocess.Popen(
        [sys.executable, "-m", "benchmarks.sweeps.worker", *map(str, words)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def main(argv: list[str] | None = None) -> int:
    """Entry point; the exit status is 1 where the rival's numbers differ by more than 1e-9."""
    given = _arguments(argv)
    if given.page is not None:
        print(f"sweeps: {write_page(read_json(given.page), given.docs or given.out)}")
        return 0
    path = given.out / "sweeps.json"
    kept = read_json(path) if given.add and path.exists() else {}
    document = {**kept, **of_this_run(1), "quick": given.quick}
    measured = {"sweeps": _sweeps, "calls": _calls, "scaling": _scaling}
    for name in given.parts or PARTS:
        document[name] = measured[name](given.quick)
        print(f"sweeps: {name} done", flush=True)
        write_json(path, document)
        write_text(path.with_suffix(".md"), tables(document))
    print(tables(document))
    if given.docs is not None:
        print(f"sweeps: {write_page(document, given.docs)}")
    errors = [row["error"] for row in document.get("sweeps", []) if row["error"]]
    return int(any(value > 1e-9 for row in errors for value in row.values()))
