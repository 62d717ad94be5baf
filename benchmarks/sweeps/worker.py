"""One measurement in a process of its own: `python -m benchmarks.sweeps.worker KIND …`.

Prints one JSON object. Times are by the clock and by the processor (all threads of the process).
"""

import argparse
import functools
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import prsm_jax as prsm
from prsm_jax.sweeps._plan import blocks_of

from . import rival
from .plans import QUANTITIES, SCENES, VARIABLES, Study, calls, kernel, study

_Times = dict[str, float]


def _timed(work: Callable[[], Any]) -> tuple[_Times, Any]:
    wall, processor = time.perf_counter(), time.process_time()
    found = work()
    return {
        "wall_s": time.perf_counter() - wall,
        "processor_s": time.process_time() - processor,
    }, found


def peak_bytes() -> int | None:
    """The most memory that this process has had; `None` where the system does not tell."""
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    (line,) = (line for line in lines if line.startswith("VmHWM"))
    return int(line.split()[1]) * 1024


def _stored_bytes(store: Path) -> tuple[int, int]:
    """Bytes and number of the files of a store."""
    sizes = [path.stat().st_size for path in store.rglob("*") if path.is_file()]
    return sum(sizes), len(sizes)


def _swept(of: Study, store: Path, shard: tuple[int, int] | None = None):
    return prsm.sweep(
        of.mechanism,
        of.axes,
        list(QUANTITIES),
        findings=of.job.findings,
        store=store,
        shard=shard,
    )


def _compiled(of: Study, folder: Path) -> _Times:
    """Trace, compile, and compute the first block."""
    times, _ = _timed(lambda: _swept(of, folder / "first.zarr", (1, len(of.job.blocks))))
    return times


def throughput(scene: str, side: int, findings: bool, rounds: int, theirs: int) -> dict[str, Any]:
    """Sweeps into a store, the kernel alone, and the rival, in turn.

    **Arguments:**

    - `scene`: what is varied.
    - `side`: values of each axis.
    - `findings`: whether errors of `check` are looked for.
    - `rounds`: how often each is measured.
    - `theirs`: designs of the rival in each round; 0 leaves it out.
    """
    of = study(scene, side, findings)
    threads = len(os.sched_getaffinity(0))
    rows: list[dict[str, Any]] = []
    memory: dict[str, int | None] = {}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        compiling = _compiled(of, folder)
        memory["compiled"] = peak_bytes()
        given: list[Any] = []
        size = (0, 0)
        data: Any = None
        error: dict[str, float] | None = None
        for number in range(rounds):
            store = folder / f"{number}.zarr"
            ours, data = _timed(lambda store=store: _swept(of, store))
            memory.setdefault("swept", peak_bytes())
            size = _stored_bytes(store)
            given = given or calls(of)
            alone, _ = _timed(functools.partial(kernel, of, given, threads))
            row = {"sweep": ours, "kernel": alone}
            if theirs:
                error = error or _error(of, data, 50)
                row["rival"] = _rival(of, theirs, number)
            rows.append(row)
        failed = int(data.attrs["failed"])
    return {
        "scene": scene,
        "points": of.points,
        "findings": findings,
        "threads": threads,
        "block": of.job.blocks.size,
        "blocks": len(of.job.blocks),
        "call": of.job.task(0).settings.size,
        "compile": compiling,
        "rounds": rows,
        "rival_designs": theirs,
        "memory": memory,
        "stored_bytes": size[0],
        "files": size[1],
        "failed": failed,
        "error": error,
    }


def _some(of: Study, count: int, seed: int) -> np.ndarray:
    """Places of random designs in the grid, a row each."""
    generator = np.random.default_rng(seed)
    return generator.integers(0, of.job.plan.shape, (count, len(VARIABLES)))


def _values(of: Study, place) -> list[float]:
    return [float(of.axes[name][index]) for name, index in zip(VARIABLES, place, strict=True)]


def _rival(of: Study, count: int, seed: int) -> _Times:
    designs = [_values(of, place) for place in _some(of, count, seed)]
    times, _ = _timed(lambda: [rival.design(*design) for design in designs])
    return times


def _error(of: Study, data: Any, count: int) -> dict[str, float]:
    """Largest relative difference between the store and the rival, by quantity."""
    largest: dict[str, float] = dict.fromkeys(QUANTITIES, 0.0)
    for place in _some(of, count, 99):
        here = data.isel(dict(zip(VARIABLES, place.tolist(), strict=True)))
        theirs = rival.design(*_values(of, place))
        for name, other in zip(QUANTITIES, theirs, strict=True):
            ours = np.sort(np.ravel(here[name].values))
            largest[name] = max(largest[name], float(np.max(np.abs(ours / other - 1))))
    return largest


def call_sizes(scene: str, sizes: list[int], rounds: int) -> dict[str, Any]:
    """The kernel alone on one thread with calls of several sizes, in turn."""
    whole = study(scene, round(max(sizes) ** (1 / 3)), False)
    # One block, so that a call may be as large as all designs.
    blocks = blocks_of(whole.job.plan.shape, whole.points)
    studies = {
        size: whole._replace(job=replace(whole.job, blocks=blocks, call=size)) for size in sizes
    }
    given = {size: calls(of) for size, of in studies.items()}
    for size, of in studies.items():
        kernel(of, given[size][:1], 1)
    best: dict[int, _Times] = {}
    for _ in range(rounds):
        for size, of in studies.items():
            times, _ = _timed(lambda of=of, size=size: kernel(of, given[size], 1))
            old = best.get(size, times)
            best[size] = {key: min(value, old[key]) for key, value in times.items()}
    designs = {size: len(given[size]) * studies[size].job.task(0).settings.size for size in sizes}
    return {
        "scene": scene,
        "points": whole.points,
        "sizes": [
            {
                "call": studies[size].job.task(0).settings.size,
                **{name.replace("_s", "_us"): 1e6 * v / designs[size] for name, v in t.items()},
            }
            for size, t in best.items()
        ],
    }


def share(
    scene: str, side: int, shard: tuple[int, int], store: Path, cores: int, place: int
) -> dict[str, Any]:
    """One of several processes that sweep together: it compiles, waits for a line, and begins.

    **Arguments:**

    - `scene`, `side`: as for `throughput`.
    - `shard`: its number, from 1, and the number of processes.
    - `store`: where all of them write.
    - `cores`, `place`: number of its cores, and its place among processes of as many, from 0.
    """
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[place * cores :][:cores])
    of = study(scene, side, False)
    with tempfile.TemporaryDirectory() as folder:
        compiling = _compiled(of, Path(folder))
    print("ready", flush=True)
    sys.stdin.readline()
    begin = time.time()
    times, _ = _timed(lambda: _swept(of, store, shard))
    return {
        "points": of.points,
        "compile": compiling,
        "began": begin,
        "ended": time.time(),
        **times,
    }


def main() -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.sweeps.worker", description=__doc__)
    kinds = parser.add_subparsers(dest="kind", required=True)
    one = kinds.add_parser("throughput")
    one.add_argument("--findings", action="store_true")
    one.add_argument("--rival", type=int, default=0)
    two = kinds.add_parser("calls")
    two.add_argument("--sizes", type=int, nargs="+", required=True)
    three = kinds.add_parser("share")
    three.add_argument("--shard", type=int, nargs=2, required=True)
    three.add_argument("--store", type=Path, required=True)
    three.add_argument("--cores", type=int, required=True)
    three.add_argument("--place", type=int, required=True)
    for kind in (one, two, three):
        kind.add_argument("--scene", choices=SCENES, default=next(iter(SCENES)))
    for kind in (one, three):
        kind.add_argument("--side", type=int, required=True)
    for kind in (one, two):
        kind.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    if given.kind == "throughput":
        found = throughput(given.scene, given.side, given.findings, given.rounds, given.rival)
    elif given.kind == "calls":
        found = call_sizes(given.scene, given.sizes, given.rounds)
    else:
        first, count = given.shard
        shard = first, count
        found = share(given.scene, given.side, shard, given.store, given.cores, given.place)
    print(json.dumps(found))


if __name__ == "__main__":
    main()
