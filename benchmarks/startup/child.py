"""One command in a process of its own, with a clock: `python …/startup/child.py FILE VERB …`.

It writes to FILE where the time of the command went, as JSON. Nothing of the package or of JAX is
imported before the clock runs. Intervals that lie in each other (a function that is traced inside
another) count once.
"""

import builtins
import itertools
import json
import sys
import time

#: From the start of this file; what was before is the interpreter.
_BEGAN = time.time()
_COMPILED, _LOWERED, _IMPORTED, _TRACED = "compiling", "lowering", "imports", "tracing"
#: Of two intervals that overlap the earlier of these names counts.
ORDER: tuple[str, ...] = (_COMPILED, _LOWERED, _IMPORTED, _TRACED)
_EVENTS = {
    "/jax/core/compile/jaxpr_trace_duration": _TRACED,
    "/jax/core/compile/jaxpr_to_mlir_module_duration": _LOWERED,
    "/jax/core/compile/backend_compile_duration": _COMPILED,
}


def divided(intervals: list[tuple[float, float, str]]) -> dict[str, float]:
    """Seconds of each kind, where every moment counts for one kind only.

    **Arguments:**

    - `intervals`: beginning, end and kind of each, in any order.
    """
    found = dict.fromkeys(ORDER, 0.0)
    moments = sorted({moment for begin, end, _ in intervals for moment in (begin, end)})
    changes = sorted(
        [(begin, 1, kind) for begin, _, kind in intervals]
        + [(end, -1, kind) for _, end, kind in intervals],
        key=lambda change: change[0],
    )
    running: dict[str, int] = dict.fromkeys(ORDER, 0)
    at = 0
    for now, then in itertools.pairwise(moments):
        while at < len(changes) and changes[at][0] <= now:
            running[changes[at][2]] += changes[at][1]
            at += 1
        kind = next((kind for kind in ORDER if running[kind] > 0), None)
        if kind is not None:
            found[kind] += then - now
    return found


def main() -> int:
    """Run the command of `sys.argv` as `prsm` does."""
    path, words = sys.argv[1], sys.argv[2:]
    # The package sees that it is the command line.
    sys.argv = ["prsm", *words]
    intervals: list[tuple[float, float, str]] = []
    plain, depth, listening = builtins.__import__, 0, False

    def heard(event: str, duration_secs: float, **_) -> None:
        if event in _EVENTS:
            now = time.perf_counter()
            intervals.append((now - duration_secs, now, _EVENTS[event]))

    def timed(*args, **kwargs):
        nonlocal depth, listening
        begin, depth = time.perf_counter(), depth + 1
        try:
            return plain(*args, **kwargs)
        finally:
            depth -= 1
            if depth == 0:
                intervals.append((begin, time.perf_counter(), _IMPORTED))
                if not listening and "jax.monitoring" in sys.modules:
                    listening = True
                    sys.modules["jax.monitoring"].register_event_duration_secs_listener(heard)

    begin = time.perf_counter()
    builtins.__import__ = timed
    from prsm_jax.cli import main as command

    status = 1
    try:
        status = command()
    finally:
        builtins.__import__ = plain
        total = time.perf_counter() - begin
        parts = divided(intervals)
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"began": _BEGAN, "command_s": total, "status": status, **parts}, file)
    return status


if __name__ == "__main__":
    sys.exit(main())
