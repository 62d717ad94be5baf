"""First and later calls in Python: `python -m benchmarks.startup.calls` prints them as JSON."""

import json
import time
from collections.abc import Callable
from typing import Any

import jax

import prsm_jax as prsm

#: Later calls, of which the fastest counts: other work on the machine can only delay one.
_CALLS = 30


def calls_of(mechanism: prsm.Mechanism) -> dict[str, Callable[[], Any]]:
    """Calls as a user writes them, without `jax.jit`, by their text."""

    def efficiency(mechanism):
        return prsm.steady_state(mechanism).efficiency

    def lowest(mechanism):
        return prsm.modal(mechanism).frequencies[0]

    def pressure(mechanism):
        return prsm.compute(mechanism, ["max_pressure"])["max_pressure"]

    return {
        "steady_state(m)": lambda: prsm.steady_state(mechanism),
        "modal(m)": lambda: prsm.modal(mechanism),
        'compute(m, ["max_pressure"])': lambda: pressure(mechanism),
        "grad(lambda m: steady_state(m).efficiency)(m)": lambda: jax.grad(efficiency)(mechanism),
        "grad(lambda m: modal(m).frequencies[0])(m)": lambda: jax.grad(lowest)(mechanism),
        'grad(lambda m: compute(m, ["max_pressure"])["max_pressure"])(m)': lambda: jax.grad(
            pressure
        )(mechanism),
    }


def timed_call(call: Callable[[], Any]) -> dict[str, float]:
    """Seconds of the first call, and of the fastest of the later ones."""
    begin = time.perf_counter()
    jax.block_until_ready(call())
    first = time.perf_counter() - begin
    best = float("inf")
    for _ in range(_CALLS):
        begin = time.perf_counter()
        jax.block_until_ready(call())
        best = min(best, time.perf_counter() - begin)
    return {"first_s": first, "later_s": best}


if __name__ == "__main__":
    calls = calls_of(prsm.load("wu2022"))
    print(json.dumps([{"call": text, **timed_call(call)} for text, call in calls.items()]))
