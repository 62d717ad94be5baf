"""The verdict on one benchmark: measured, compared, measured again where a clock is to blame."""

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from ..harness import machine
from .compared import Numbers, compare, conservative, recurring
from .stored import STORED, read_stored, store


def guarded(
    name: str,
    measured: Callable[[], Numbers],
    limits: Mapping[str, float] | None = None,
    *,
    renew: bool = False,
    measurements: int = 3,
    path: Path = STORED,
) -> int:
    """Compare a benchmark with its stored numbers, or store them; prints what fails.

    Ratios and costs are judged only with at least as many cores as they were stored with.

    **Arguments:**

    - `name`: that of the benchmark in the file.
    - `measured`: measures it once.
    - `limits`: as in `compare`.
    - `renew`: store the worst of all measurements and compare nothing.
    - `measurements`: a number by the clock fails if it fails in as many, one after another.
    - `path`: the file.

    **Returns:** exit status: 1 where a number fails or none is stored.
    """
    if renew:
        store(name, conservative([measured() for _ in range(measurements)]), path)
        print(f"{name}: stored in {path}")
        return 0
    known = read_stored(path)
    if name not in known:
        print(f"{name}: nothing is stored; measure it once with --store", file=sys.stderr)
        return 1
    stored, cores = known[name]
    clock = machine()["cores"] >= cores
    failures = compare(stored, measured(), limits, clock=clock)
    for _ in range(measurements - 1):
        if not any(one.timed for one in failures):
            break
        failures = recurring(failures, compare(stored, measured(), limits))
    for one in failures:
        print(f"WORSE  {name}: {one}", file=sys.stderr)
    count = len(stored.errors) + clock * (len(stored.ratios) + len(stored.costs))
    unjudged = "" if clock else f"; ratios need {cores} cores"
    print(f"{name}: {count} numbers compared with {path.name}, {len(failures)} worse{unjudged}")
    return int(bool(failures))
