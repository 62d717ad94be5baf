"""`python -m benchmarks fronts`: fronts by gradients against NSGA-II, in one run.

Both see the same variables, constraints and margins of `check`. The volume is that which the
designs dominate, up to a reference point that is worse than the front of the gradients by 10 % of
its range, over the volume of the box from the ideal point. Each evaluation of derivatives counts
as one more design, and in another column as many as there are variables. NSGA-II gets `--times` as
many designs, once with as many in a generation as the front has points, and once with a hundred.
"""

import argparse
import dataclasses
import time
from pathlib import Path
from typing import Any

import numpy as np

import prsm_jax as prsm
from prsm_jax.mechanism import DesignProblem, Mechanism, Objective
from prsm_jax.optimisation import hypervolume
from prsm_jax.optimisation.front import senses

from ..harness import of_this_run, parser_of, read_json, refuse_unknown, why_left_out, write_json
from .page import write_page
from .rival import nsga2

#: Objectives by problem, on the variables and constraints of the example `actuator`.
PROBLEMS = {
    "efficiency_size": (
        Objective("efficiency", "maximise"),
        Objective("nut_outer_diameter", "minimise"),
    ),
    "efficiency_pressure_size": (
        Objective("efficiency", "maximise"),
        Objective("max_pressure_shared", "minimise"),
        Objective("nut_outer_diameter", "minimise"),
    ),
}


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("fronts", __doc__)
    parser.add_argument("problems", nargs="*", metavar="problem", help="which; default all")
    parser.add_argument("--points", type=int, default=40, help="points of the front")
    parser.add_argument("--times", type=float, default=20.0, help="designs of NSGA-II over ours")
    parser.add_argument("--seeds", type=int, default=3, help="runs of NSGA-II; the best counts")
    given = parser.parse_args(argv)
    refuse_unknown(parser, "problem", given.problems, PROBLEMS)
    return given


def compared(
    mechanism: Mechanism, problem: DesignProblem, times: float, seeds: int
) -> dict[str, Any]:
    """The front by gradients and those of NSGA-II: volumes, designs evaluated, run times.

    Without pymoo there are none of NSGA-II, `left_out` says why, and the ratios are `None`.

    **Arguments:**

    - `mechanism`, `problem`: as for `pareto`.
    - `times`: designs of NSGA-II over those of the gradients, derivatives counted as designs.
    - `seeds`: runs of NSGA-II for each size of a generation.
    """
    prsm.pareto(mechanism, problem=problem, points=3)  # compiles
    begin = time.perf_counter()
    front = prsm.pareto(mechanism, problem=problem)
    seconds = time.perf_counter() - begin
    signs = senses(problem.objectives)
    ideal, corner = (signs * np.array(list(p.values())) for p in (front.ideal, front.reference))
    spent = front.evaluations + front.derivative_evaluations
    rivals, left_out = [], why_left_out("pymoo")
    for population in dict.fromkeys((len(front.points), 100)):
        for seed in range(seeds if left_out is None else 0):
            found, count, rival_s = nsga2(
                mechanism, problem, population, round(times * spent), seed + 1
            )
            volume = hypervolume((found - ideal) / (corner - ideal), np.ones(len(ideal)))
            rivals.append(
                {
                    "population": population,
                    "seed": seed + 1,
                    "evaluations": count,
                    "points": len(found),
                    "hypervolume": volume,
                    "seconds": rival_s,
                }
            )
    return {
        "points": len(front.points),
        "evaluations": front.evaluations,
        "derivative_evaluations": front.derivative_evaluations,
        "evaluations_by_variables": front.evaluations
        + len(problem.variables) * front.derivative_evaluations,
        "largest_kkt_residual": max(one.kkt_residual for one in front.points),
        "converged": front.converged,
        "hypervolume": front.hypervolume,
        "seconds": seconds,
        "nsga2": rivals,
        "left_out": left_out,
        "evaluation_ratio": min(one["evaluations"] for one in rivals) / spent if rivals else None,
        "hypervolume_ratio": (
            front.hypervolume / max(one["hypervolume"] for one in rivals) if rivals else None
        ),
    }


def main(argv: list[str] | None = None) -> int:
    """Entry point; returns the exit status: 1 where NSGA-II has the larger volume."""
    arguments = _arguments(argv)
    if arguments.page is not None:
        return _written(read_json(arguments.page), arguments.docs or arguments.out, arguments.out)
    mechanism = prsm.load("actuator")
    assert mechanism.design_problem is not None
    document = {**of_this_run(1), "problems": {}}
    status = 0
    for name in arguments.problems or PROBLEMS:
        problem = dataclasses.replace(
            mechanism.design_problem, objectives=PROBLEMS[name], points=arguments.points, starts=1
        )
        one = compared(mechanism, problem, arguments.times, arguments.seeds)
        document["problems"][name] = one
        print(
            f"{name}: {one['points']} points, volume {one['hypervolume']:.5f}, "
            f"{one['evaluations']} values and {one['derivative_evaluations']} derivatives "
            f"(as {one['evaluations_by_variables']} values), {one['seconds']:.1f} s, "
            f"largest KKT residual {one['largest_kkt_residual']:.1e}"
        )
        for rival in one["nsga2"]:
            print(
                f"  NSGA-II, {rival['population']} a generation, seed {rival['seed']}: volume "
                f"{rival['hypervolume']:.5f}, {rival['evaluations']} values, "
                f"{rival['seconds']:.1f} s",
                flush=True,
            )
        if one["nsga2"]:
            print(
                f"  designs of NSGA-II over ours {one['evaluation_ratio']:.1f}; our volume over "
                f"its best {one['hypervolume_ratio']:.4f}"
            )
            status |= one["hypervolume_ratio"] < 1
        else:
            print(f"  NSGA-II {one['left_out']}")
        write_json(arguments.out / "fronts.json", document)
    if arguments.docs is not None:
        _written(document, arguments.docs, arguments.out)
    return int(status)


def _written(document: dict[str, Any], docs: Path, out: Path) -> int:
    """Write the page, with the starts of `out` if they were measured there."""
    starts = out / "starts.json"
    path = write_page(document, read_json(starts) if starts.exists() else None, docs)
    print(f"page: {path}")
    return 0
