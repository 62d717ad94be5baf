"""One program in a process of its own: `python -m benchmarks.programs.worker EXAMPLE NAME KIND N`.

Prints one JSON object.
"""

import argparse
import json
import math
import sys
import time
from pathlib import Path
from typing import Any

_SAMPLING_S = 0.3


def measure(example: str, name: str, kind: str, batch: int) -> dict[str, Any]:
    """Equations, processor time of tracing and compiling, flops and run time of one program.

    **Arguments:** as for `program`.
    """
    # Not at the top: `--tree` decides which package is imported.
    import jax
    import numpy as np

    from ..load.counted import counted
    from .functions import program

    function, numbers = program(example, name, kind, batch)
    begin = time.process_time()
    equations = counted(function, numbers).equations
    traced = time.process_time()
    lowered = jax.jit(function).lower(numbers)
    ready = time.process_time()
    compiled = lowered.compile()
    done = time.process_time()
    cost = compiled.cost_analysis() or {}
    found = jax.block_until_ready(compiled(numbers))
    best, started = float("inf"), time.perf_counter()
    while best == float("inf") or time.perf_counter() - started < _SAMPLING_S:
        start = time.perf_counter()
        jax.block_until_ready(compiled(numbers))
        best = min(best, time.perf_counter() - start)
    finite = all(np.isfinite(np.asarray(leaf)).all() for leaf in jax.tree.leaves(found))
    return {
        "equations": equations,
        "trace_s": traced - begin,
        "lower_s": ready - traced,
        "compile_s": done - ready,
        "flops": cost.get("flops"),
        "run_s": best / batch,
        "finite": bool(finite),
        "error": None,
    }


def _end_after(seconds: float) -> None:
    """End this process by a signal when it has used so much processor time."""
    try:
        import resource
    except ImportError:
        return
    limit = math.ceil(seconds)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))


def main() -> None:
    """Measure what the words of the command line say; why it failed is in the row."""
    parser = argparse.ArgumentParser()
    for word in ("example", "name", "kind"):
        parser.add_argument(word)
    parser.add_argument("batch", type=int)
    parser.add_argument("--limit", type=float, required=True, help="processor time [s]")
    parser.add_argument("--tree", type=Path, help="folder whose prsm_jax is imported")
    given = parser.parse_args()
    if given.tree is not None:
        sys.path.insert(0, str(given.tree))
    _end_after(given.limit)
    try:
        row = measure(given.example, given.name, given.kind, given.batch)
    except Exception as error:
        # Why there is no such program is a row of the table.
        row = {"error": " ".join(str(error).split()) or type(error).__name__}
    print(json.dumps(row))


if __name__ == "__main__":
    main()
