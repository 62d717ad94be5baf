"""One program in a process of its own: `python -m benchmarks.programs.worker EXAMPLE NAME KIND N`.

Prints one JSON object.
"""

import json
import sys
import time
from typing import Any

import jax
import numpy as np

from ..load.counted import counted
from .functions import program

_SAMPLING_S = 0.3


def measure(example: str, name: str, kind: str, batch: int) -> dict[str, Any]:
    """Equations, processor time of tracing and compiling, flops and run time of one program.

    **Arguments:** as for `program`.
    """
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


if __name__ == "__main__":
    try:
        row = measure(sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4]))
    except Exception as error:
        # Why there is no such program is a row of the table.
        row = {"error": " ".join(str(error).split()) or type(error).__name__}
    print(json.dumps(row))
