"""One size of one task in a process of its own: `python -m benchmarks.load.worker TASK SIZE`.

Prints one JSON object. Run times are those of compiled programs. Memory is what the process has at
most while it calculates, over what it had before; with the programs and all modules it is the peak.
"""

import argparse
import gc
import json
import sys
import time
from pathlib import Path

import jax

from .tasks import TASKS

_STATUS, _FORGET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def _status(key: str) -> int | None:
    """A line of the kernel's account of this process [bytes]; `None` where it keeps none."""
    try:
        lines = _STATUS.read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith(key)), None)


def _forget_peak() -> bool:
    try:
        _FORGET.write_text("5", encoding="ascii")
    except OSError:
        return False
    return True


def _peak() -> int | None:
    try:
        import resource
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def measure(name: str, size: int, seconds: float) -> dict:
    """Times, memory and error of one size.

    **Arguments:**

    - `name`, `size`: of the task.
    - `seconds`: time to spend on samples; at least two are taken.
    """
    work = TASKS[name].build(size)
    begin = time.perf_counter()
    found = jax.block_until_ready(work.call())
    first = time.perf_counter() - begin
    error = work.error(found)
    del found
    gc.collect()
    before, told = _status("VmRSS"), _forget_peak()
    times = []
    while len(times) < 2 or sum(times) < seconds:
        begin = time.perf_counter()
        jax.block_until_ready(work.call())
        times.append(time.perf_counter() - begin)
    highest = _status("VmHWM")
    taken = highest - before if told and highest is not None and before is not None else None
    return {
        "task": name,
        "size": size,
        "count": work.count,
        "first_call_s": first,
        "best_s": min(times),
        "samples": len(times),
        "error": error,
        "run_bytes": taken,
        "peak_bytes": _peak(),
    }


def main() -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.load.worker", description=__doc__)
    parser.add_argument("task", choices=TASKS)
    parser.add_argument("size", type=int)
    parser.add_argument("--seconds", type=float, default=1.0)
    given = parser.parse_args()
    print(json.dumps(measure(given.task, given.size, given.seconds)))


if __name__ == "__main__":
    main()
