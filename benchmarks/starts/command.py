"""`python -m benchmarks starts`: many starts at once against SLSQP from each, at equal answer.

Both start from the same Latin hypercube in the problem of the example, in one run, in turn. The
first call, which compiles, is timed by itself.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import prsm_jax as prsm
from prsm_jax.optimisation import MultiStart, Optimum, Slsqp

from ..fronts.page import write_page
from ..harness import of_this_run, parser_of, read_json, write_json


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("starts", __doc__)
    parser.add_argument("--example", default="actuator", help="example; default actuator")
    parser.add_argument("--starts", type=int, default=200, help="number of starts")
    parser.add_argument("--steps", type=int, default=30, help="steps of Adam")
    parser.add_argument("--keep", type=int, default=3, help="designs that SLSQP continues")
    parser.add_argument("--rounds", type=int, default=3, help="samples of each")
    return parser.parse_args(argv)


def _timed(call: Callable[[], Optimum]) -> tuple[float, Optimum]:
    begin = time.perf_counter()
    best = call()
    return time.perf_counter() - begin, best


def main(argv: list[str] | None = None) -> int:
    """Entry point; returns the exit status: 1 where the answers differ by more than 1e-6."""
    given = _arguments(argv)
    if given.page is not None:
        return _written(read_json(given.page), given.docs or given.out, given.out)
    mechanism = prsm.load(given.example)
    methods: dict[str, Any] = {
        "one by one": Slsqp(),
        "at once": MultiStart(steps=given.steps, keep=given.keep),
    }

    def search(method: Any) -> Callable[[], Optimum]:
        return lambda: prsm.optimise(mechanism, method=method, starts=given.starts)

    rows = {}
    for name, method in methods.items():
        first, best = _timed(search(method))
        rows[name] = {"first_call_s": first, "samples_s": [], "best": best.optimum.objective}
        rows[name] |= {
            "converged": best.converged,
            "evaluations": best.evaluations,
            "derivative_evaluations": best.derivative_evaluations,
            "searches": len(best.runs),
        }
    for _ in range(given.rounds):
        for name, method in methods.items():
            rows[name]["samples_s"].append(_timed(search(method))[0])
    ratios = [
        slow / fast
        for slow, fast in zip(*(rows[name]["samples_s"] for name in methods), strict=True)
    ]
    values = [rows[name]["best"] for name in methods]
    difference = abs(values[1] - values[0]) / abs(values[0])
    for name, row in rows.items():
        print(
            f"{name}: objective {row['best']:.10g}, {min(row['samples_s']):.2f} s "
            f"(first call {row['first_call_s']:.1f} s), {row['evaluations']} values, "
            f"{row['derivative_evaluations']} derivatives, {row['searches']} searches"
        )
    print(
        f"{given.starts} starts: at once is {statistics.median(ratios):.2f} times as fast; "
        f"relative difference of the objectives {difference:.1e}"
    )
    document = {**of_this_run(1), "example": given.example, "starts": given.starts}
    document |= {"steps": given.steps, "keep": given.keep, "rows": rows}
    document |= {"speed_ratio": statistics.median(ratios), "difference": difference}
    write_json(given.out / "starts.json", document)
    if given.docs is not None:
        _written(document, given.docs, given.out)
    return int(difference > 1e-6)


def _written(document: dict[str, Any], docs: Path, out: Path) -> int:
    """Write the page, with the fronts of `out` if they were measured there."""
    fronts = out / "fronts.json"
    path = write_page(read_json(fronts) if fronts.exists() else None, document, docs)
    print(f"page: {path}")
    return 0
