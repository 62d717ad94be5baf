"""`python -m benchmarks [case …] [--quick | --smoke] [--out DIR] [--docs DIR]`, or `--list`.

`python -m benchmarks extremes` is the matrix of extremes, with options of its own (`--help`), and
`python -m benchmarks load` the growth of run time and memory with the size of what is asked, and
`python -m benchmarks joint` what derivatives of several quantities together cost,
`python -m benchmarks parts` what each optional part of each example costs,
`python -m benchmarks programs` how long programs take to compile and to run, and
`python -m benchmarks startup` the time from a command to its answer.

`--quick --compare` compares errors and ratios with stored ones, and the exit status is 1 where one
is worse; `--quick --store` renews what is stored.
"""

import argparse
import contextlib
import json
import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax

from . import guard
from .cases import case_names, find_case
from .harness import FULL, QUICK, SMOKE, Case, Problem, draw, survivors, write


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("cases", nargs="*", metavar="case", help="which cases; default all")
    parser.add_argument("--quick", action="store_true", help="smaller problems, fewer repeats")
    parser.add_argument(
        "--smoke",
        action="store_true",
        help="the quick problems or smaller ones, each method at its first and last setting, two "
        "samples: whether everything runs, and how wrong it is",
    )
    parser.add_argument(
        "--out", type=Path, default=Path("out/benchmarks"), help="folder for the results"
    )
    parser.add_argument(
        "--docs",
        type=Path,
        default=None,
        help="folder for the page accuracy_and_speed.md, its JSON and its charts, of all cases "
        "whose results are in --out",
    )
    parser.add_argument("--page", action="store_true", help="only the page: measure nothing")
    parser.add_argument("--list", action="store_true", help="name the cases and stop")
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--compare",
        action="store_true",
        help="with --quick: exit status 1 where an error is ten times the stored one or a speed "
        "half of it; without names, every case that is stored",
    )
    what.add_argument("--store", action="store_true", help="with --quick: renew what is stored")
    arguments = parser.parse_args(argv)
    if arguments.page and arguments.docs is None:
        parser.error("--page needs --docs, the folder to write the page into")
    if (arguments.compare or arguments.store) and not arguments.quick:
        parser.error("stored numbers are those of the quick form: add --quick")
    unknown = sorted(set(arguments.cases) - set(case_names()))
    if unknown:
        parser.error(f"unknown case {', '.join(unknown)}; choose from {', '.join(case_names())}")
    return arguments


def _ends(problem: Problem) -> Problem:
    """The problem with the first and the last setting of each method."""
    methods = [
        replace(one, settings=tuple(dict.fromkeys((one.settings[0], one.settings[-1]))))
        for one in problem.methods
    ]
    return replace(problem, methods=methods)


def run(case: Case, folder: Path, *, quick: bool, smoke: bool = False) -> dict[str, Any]:
    """Measure one case and write its JSON, table and charts; returns what the JSON has."""
    measured = []
    for problem in case.problems:
        start = time.perf_counter()
        if smoke:
            problem = _ends(problem)
        problem, rows = survivors(problem, SMOKE if smoke else QUICK if quick else FULL)
        measured.append((problem, rows))
        chart = draw(problem, rows, folder / f"{case.name}-{problem.name}.png")
        print(f"{case.name}: {problem.title}: {time.perf_counter() - start:.1f} s, {chart}")
    written = write(case, measured, folder, quick=quick)
    print(f"{case.name}: {', '.join(str(path) for path in written)}", flush=True)
    return json.loads(written[0].read_text(encoding="utf-8"))


def share_cores() -> None:
    """Two devices, where there are two cores and JAX is not running yet, for those who ask."""
    # Otherwise JAX is in use: one device, and methods that need two are left out.
    with contextlib.suppress(RuntimeError):
        jax.config.update("jax_num_cpu_devices", min(2, os.cpu_count() or 1))


def main(argv: list[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    given = sys.argv[1:] if argv is None else argv
    if given[:1] == ["extremes"]:
        from .extremes.command import main as extremes

        return extremes(given[1:])
    if given[:1] == ["load"]:
        from .load.command import main as load

        return load(given[1:])
    if given[:1] == ["joint"]:
        from .joint.command import main as joint

        return joint(given[1:])
    if given[:1] == ["parts"]:
        from .parts.command import main as parts

        return parts(given[1:])
    if given[:1] == ["programs"]:
        from .programs.command import main as programs

        return programs(given[1:])
    if given[:1] == ["startup"]:
        from .startup.command import main as startup

        return startup(given[1:])
    arguments = _arguments(argv)
    if arguments.page:
        return _page(arguments)
    share_cores()
    guarded = arguments.compare or arguments.store
    chosen = arguments.cases or (stored_cases() if guarded else case_names())
    quick = arguments.quick or arguments.smoke
    status = 0
    for name in chosen:
        case = find_case(name, quick=quick, smoke=arguments.smoke)
        if arguments.list:
            print(f"{case.name:12} {case.description}")
        elif guarded:
            status |= guard.guarded(
                name,
                lambda case=case: guard.numbers_of_case(run(case, arguments.out, quick=True)),
                renew=arguments.store,
            )
        else:
            run(case, arguments.out, quick=quick, smoke=arguments.smoke)
    if arguments.docs is not None and not arguments.list:
        status |= _page(arguments)
    return status


def _page(arguments: argparse.Namespace) -> int:
    from .page.write import write_page

    try:
        written = write_page(arguments.out, arguments.docs)
    except FileNotFoundError as error:
        print(error, file=sys.stderr)
        return 2
    print(f"page: {', '.join(str(path) for path in written)}")
    return 0


def stored_cases() -> list[str]:
    """Cases that the guard has numbers of."""
    return [name for name in case_names() if name in guard.read_stored()]


if __name__ == "__main__":
    sys.exit(main())
