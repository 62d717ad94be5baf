"""Run time of a task on one device, beside what the device can do at most."""

import time
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.sweeps import map_in_chunks

from .tasks import TASKS, Task

#: Results of so many designs are compared with those of the processor in float64.
_COMPARED = 1000
#: Designs at a time on a processor, whose cache they have to fit; on another device all of them.
_CHUNK = 1000
#: At most so many designs at a time on any device: what lies between its steps has to fit.
_MOST = 1_000_000
_REPEATS = 3


def _best(call: Any) -> float:
    jax.block_until_ready(call())
    taken = []
    for _ in range(_REPEATS):
        begin = time.perf_counter()
        jax.block_until_ready(call())
        taken.append(time.perf_counter() - begin)
    return min(taken)


def ceilings(device: Any, dtype: Any) -> dict[str, float]:
    """What a device does at most, measured: bytes a second of a copy, operations a second.

    The operations are multiplications and additions of numbers that stay in registers.
    """
    processor = device.platform == "cpu"
    size = 2**25 if processor else 2**28
    with jax.default_device(device):
        copied = jnp.ones(size, dtype)
        scale = jax.jit(lambda x: 1.0000001 * x)
        moved = 2 * size * copied.dtype.itemsize / _best(lambda: scale(copied))
        count, rounds = (2**16 if processor else 2**22), 256

        @jax.jit
        def chained(x):
            # Eight chains apart, so that none waits for the one before.
            chains = [x + k for k in range(8)]
            for _ in range(rounds):
                chains = [1.0000001 * c + 1e-9 for c in chains]
            return sum(chains)

        numbers = jnp.ones(count, dtype)
        operations = 2 * 8 * rounds * count / _best(lambda: chained(numbers))
    return {"bytes_per_second": moved, "operations_per_second": operations}


def _cost(compiled: Any) -> tuple[float, float]:
    """Operations and bytes of a compiled program by XLA; a loop counts one trip."""
    found = compiled.cost_analysis()
    found = found[0] if isinstance(found, list) else found or {}
    return float(found.get("flops", np.nan)), float(found.get("bytes accessed", np.nan))


def _converted(inputs: Any, dtype: Any) -> Any:
    return jax.tree.map(lambda x: np.asarray(x, dtype), inputs)


def reference(task: Task) -> Any:
    """Results of the first designs in float64 on the processor."""
    function, inputs = task.build(_COMPARED)
    with jax.default_device(jax.devices("cpu")[0]):
        return jax.device_get(jax.jit(jax.vmap(function))(_converted(inputs, np.float64)))


def _error(found: Any, expected: Any) -> float:
    """Largest difference of any result over the largest entry of that result."""
    worst = 0.0
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        one, other = np.asarray(one, float)[:_COMPARED], np.asarray(other, float)
        one, other = one[: len(other)], other[: len(one)]
        if not np.isfinite(one).all():
            return float("inf")
        worst = max(worst, float(np.max(np.abs(one - other)) / np.max(np.abs(other))))
    return worst


def measured(
    name: str, size: int, device: Any, dtype: Any, expected: Any, ceiling: dict[str, Any]
) -> dict[str, Any]:
    """One row: a task in one size on one device, in one precision."""
    function, inputs = TASKS[name].build(size)
    processor = device.platform == "cpu"
    chunk = min(size, _CHUNK if processor else _MOST)
    given = jax.device_put(_converted(inputs, dtype), device)
    with jax.default_device(device):
        solve = jax.jit(lambda x: map_in_chunks(function, x, chunk=chunk))
        begin = time.perf_counter()
        compiled = solve.lower(given).compile()
        compiling = time.perf_counter() - begin
        seconds = _best(lambda: compiled(given))
        found = jax.tree.map(lambda x: x[:_COMPARED], compiled(given))
        # Operations of one chunk, without the loop over them.
        first = jax.tree.map(lambda x: x[:chunk], given)
        operations, moved = _cost(jax.jit(jax.vmap(function)).lower(first).compile())
    operations, moved = operations * size / chunk, moved * size / chunk
    inputs_and_results = sum(
        x.nbytes * (size / len(x)) for x in jax.tree.leaves((first, found)) if len(x)
    )
    least = max(
        operations / ceiling["operations_per_second"],
        inputs_and_results / ceiling["bytes_per_second"],
    )
    return {
        "task": name,
        "designs": size,
        "device": device.device_kind,
        "precision": np.dtype(dtype).name,
        "chunk": chunk,
        "seconds": seconds,
        "designs_per_second": size / seconds,
        "compile_seconds": compiling,
        "operations_per_design": operations / size,
        "bytes_per_design": moved / size,
        "needed_bytes_per_design": inputs_and_results / size,
        "share_of_ceiling": least / seconds,
        "error": _error(jax.device_get(found), expected),
    }
