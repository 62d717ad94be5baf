"""One size of one task in a process of its own: `python -m benchmarks.load.worker TASK SIZE`.

Prints one JSON object. Run times are those of compiled programs, by the clock and by the processor
(all threads together), which other work on the machine lengthens less. Memory is what XLA reserves
for results and intermediate numbers, beside the arguments; the peak is that of the process, with
programs and all modules.
"""

import argparse
import gc
import json
import sys
import time
from typing import Any

import jax

from .counted import counted
from .tasks import TASKS

#: A first sample that takes longer is the only one [s].
_LONG = 15.0


def _peak() -> int | None:
    try:
        import resource
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def measure(name: str, size: int, seconds: float) -> dict[str, Any]:
    """Times, operations, memory and error of one size.

    **Arguments:**

    - `name`, `size`: of the task.
    - `seconds`: time to spend on samples; at least two are taken unless one takes long.
    """
    work = TASKS[name].build(size)
    program = counted(work.function, *work.arguments)
    begin = time.perf_counter()
    compiled = work.function.lower(*work.arguments).compile()
    compiling = time.perf_counter() - begin
    account = compiled.compiled.memory_analysis()
    gc.collect()
    walls, processor, found = [], [], None
    while len(walls) < 2 or sum(walls) < seconds:
        begin, used = time.perf_counter(), time.process_time()
        found = jax.block_until_ready(compiled(*work.arguments))
        processor.append(time.process_time() - used)
        walls.append(time.perf_counter() - begin)
        if walls[0] > _LONG:
            break
    return {
        "task": name,
        "size": size,
        "compile_s": compiling,
        "best_s": min(walls),
        "processor_s": min(processor),
        "samples": len(walls),
        "steps": None if work.steps is None else work.steps(found),
        "operations": program.operations,
        "equations": program.equations,
        "run_bytes": account.temp_size_in_bytes + account.output_size_in_bytes,
        "peak_bytes": _peak(),
        "error": work.error(found),
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
