"""`python -m benchmarks catalogue`: the best design within the envelope of each catalogue size.

All sizes are solved in one batch, without any loss of efficiency and with a loss of half a digit of
the catalogue. Each result is built and evaluated again by itself. NSGA-II then gets the same
problem and `--times` as many designs as the batch on average, derivatives counted as designs.
"""

import argparse
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ..harness import of_this_run, parser_of, read_json, why_left_out, write_json
from .batched import Batch, solve
from .checked import checked
from .page import write_page
from .problem import ALLOWED, MEASURES, VARIABLES, Size, dimensioned, sizes
from .rival import POPULATION, Rival, nsga2
from .search import FEASIBLE, Found

#: Other upper bounds of the ratio of profile radii.
_FLATTEST = (1.0, 3.0)


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("catalogue", __doc__)
    parser.add_argument("--quick", action="store_true", help="six sizes, and one seed")
    parser.add_argument("--times", type=float, default=20.0, help="designs of NSGA-II over ours")
    parser.add_argument("--seeds", type=int, default=3, help="runs of NSGA-II")
    return parser.parse_args(argv)


def designs(batch: Batch, count: int) -> float:
    """Designs that a batch evaluates per size; each derivative by a variable counts as one."""
    return batch.evaluations * (1 + len(VARIABLES)) / count


def _number(value: float) -> float:
    """As many digits as are needed to build a design again."""
    return float(f"{value:.12g}")


def _of(names: Sequence[str], values: Iterable[float]) -> dict[str, float]:
    return {name: _number(value) for name, value in zip(names, values, strict=True)}


def result_of(size: Size, start: np.ndarray, batch: Batch) -> dict[str, Any]:
    """What is stored of one size.

    **Arguments:**

    - `size`: the size.
    - `start`: measures of its own design.
    - `batch`: the results.
    """
    found = batch.best(size)
    task = found.task
    radius = size.roller_radius(task.starts)
    angle, profile_ratio, length_ratio, count = found.variables
    return {
        "size": size.name,
        "nominal_diameter_mm": size.row["nominal_diameter_mm"],
        "lead_mm": size.row["lead_mm"],
        "own_starts": size.starts,
        "own_rollers": int(dimensioned(size, size.starts).stages[0].roller_count),
        "own": _of(MEASURES, start),
        "limits": _of(MEASURES, task.limits),
        "starts": task.starts,
        "most_starts": size.choices[-1],
        "most_rollers": int(task.mechanism.stages[0].roller_count),
        "variables": _of(VARIABLES, [angle, profile_ratio, length_ratio, round(count)]),
        "pitch_mm": _number(size.row["lead_mm"] / task.starts),
        "profile_radius_mm": _number(1e3 * profile_ratio * radius / np.cos(angle)),
        "nut_outer_diameter_mm": _number(2e3 * (task.starts * radius + size.wall)),
        "nut_length_mm": _number(size.row["nut_length_mm"] * length_ratio),
        "measures": _of(MEASURES, found.measures),
        "objective": _number(found.objective),
        "violation": found.violation,
        "kkt_residual": found.kkt_residual,
        "active": list(found.active),
        "objective_by_starts": {
            str(n): _number(batch.best(size, n).objective)
            for n in size.choices
            if batch.best(size, n).violation <= FEASIBLE
        },
        "checked": checked(size, found),
    }


def _run(one: Rival, seed: int) -> dict[str, Any]:
    return {
        "seed": seed,
        "objective": _number(one.objective),
        "starts": one.starts,
        "variables": _of(VARIABLES, one.variables),
        "evaluations": one.evaluations,
        "seconds": round(one.seconds, 3),
    }


def rivals_of(size: Size, found: Found, evaluations: int, seeds: int) -> dict[str, Any]:
    """Runs of NSGA-II on one size, by the number of its objectives; three in one run only.

    None without pymoo.
    """
    if why_left_out("pymoo"):
        return {"one": [], "three": []}
    return {
        "one": [
            _run(nsga2(size, found.task.limits, evaluations, seed, several=False), seed)
            for seed in range(1, seeds + 1)
        ],
        "three": [_run(nsga2(size, found.task.limits, evaluations, 1, several=True), 1)],
    }


def solved(chosen: Sequence[Size], loss: float) -> tuple[Batch, dict[str, Any]]:
    """The batch of one problem, and what is stored of it without NSGA-II.

    **Arguments:**

    - `chosen`: the sizes.
    - `loss`: allowed loss of efficiency.
    """
    first = solve(chosen, loss)
    # The first call compiles.
    batch = solve(chosen, loss)
    gained = {
        f"{end:g}": [_number(b.best(size).objective) for size in chosen]
        for end in _FLATTEST
        for b in [solve(chosen, loss, end)]
    }
    return batch, {
        "allowed_loss": loss,
        "evaluations": batch.evaluations,
        "designs_per_size": designs(batch, len(chosen)),
        "calls": batch.calls,
        "searches": sum(map(len, batch.found.values())),
        "seconds": batch.seconds,
        "building_s": batch.building_s,
        "first_s": first.seconds,
        "objective_by_flattest_profile": gained,
        "sizes": [
            result_of(size, start, batch) for size, start in zip(chosen, batch.starts, strict=True)
        ],
    }


def main(argv: list[str] | None = None) -> int:
    """Entry point; returns the exit status: 1 where a result is not feasible or has errors."""
    arguments = _arguments(argv)
    if arguments.page is not None:
        document = read_json(arguments.page)
        if arguments.docs is not None:
            print("page:", *write_page(document, arguments.docs))
        return 0
    chosen = sizes()[3::15] if arguments.quick else sizes()
    seeds = 1 if arguments.quick else arguments.seeds
    document: dict[str, Any] = {**of_this_run(1), "quick": arguments.quick, "seeds": seeds}
    document |= {"times": arguments.times, "population": POPULATION, "problems": {}}
    status = 0
    for name, loss in ALLOWED.items():
        batch, one = solved(chosen, loss)
        one["left_out"] = why_left_out("pymoo")
        document["problems"][name] = one
        print(
            f"{name}: {len(chosen)} sizes, {one['searches']} searches, {one['evaluations']} "
            f"evaluations with derivatives in {one['calls']} calls, {one['seconds']:.1f} s"
        )
        budget = round(arguments.times * one["designs_per_size"])
        for size, row in zip(chosen, one["sizes"], strict=True):
            row["rivals"] = rivals_of(size, batch.best(size), budget, seeds)
            runs = [run["objective"] for run in row["rivals"]["one"]]
            print(
                f"  {size.name}: {row['starts']} starts, smallest gain {row['objective']:.5f}, "
                f"NSGA-II {f'{max(runs):.5f}' if runs else one['left_out']}",
                flush=True,
            )
            again = row["checked"]
            status |= bool(again["errors"]) or again["smallest_slack"] < -FEASIBLE
        write_json(arguments.out / "catalogue.json", document)
    if arguments.docs is not None:
        print("page:", *write_page(document, arguments.docs))
    return int(status)
