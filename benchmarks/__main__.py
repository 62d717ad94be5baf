"""`python -m benchmarks [case …] [--quick | --smoke] [--out DIR] [--docs DIR]`, or `--list`.

Each of these is a command with options of its own (`--help`):

* `python -m benchmarks extremes`: the matrix of extremes;
* `… load`: growth of run time and memory with the size of the task;
* `… joint`: cost of joint derivatives of several quantities;
* `… parts`: cost of each optional part of each example;
* `… programs`: how long programs take to compile and to run;
* `… startup`: the time from a command to its answer;
* `… devices`: designs per second on each device that JAX finds;
* `… fronts`: fronts by gradients against NSGA-II;
* `… starts`: many starts at once against searches one by one;
* `… sweeps`: a million designs into a store, against a loop with SciPy;
* `… catalogue`: the best design within the envelope of each size of a catalogue.

`--quick --compare` compares errors and ratios with stored ones; the exit status is 1 if one is
worse. `--quick --store` renews the stored numbers.
"""

import argparse
import contextlib
import importlib
import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax

from . import guard
from .cases import case_names, find_case
from .harness import FULL, QUICK, SMOKE, Case, Problem, draw, read_json, survivors, write

#: Folders with a `command` of their own.
_COMMANDS = (
    "extremes",
    "load",
    "joint",
    "parts",
    "programs",
    "startup",
    "devices",
    "catalogue",
    "fronts",
    "starts",
    "sweeps",
)


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("cases", nargs="*", metavar="case", help="which cases; default all")
    parser.add_argument("--quick", action="store_true", help="smaller problems, fewer repeats")
    parser.add_argument(
        "--smoke",
        action="store_true",
        help="the quick problems or smaller ones, each method at its first and last setting, two "
        "samples: shows whether everything runs, and its errors",
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
    parser.add_argument("--list", action="store_true", help="list the cases and exit")
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--compare",
        action="store_true",
        help="with --quick: exit status 1 if an error is ten times the stored one or a speed half "
        "of the stored one; without names, of all stored cases",
    )
    what.add_argument("--store", action="store_true", help="with --quick: renew the stored numbers")
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
    return read_json(written[0])


def share_cores() -> None:
    """Two devices, where there are two cores and JAX is not running yet, for those who ask."""
    # Otherwise JAX is in use: one device, and methods that need two are left out.
    with contextlib.suppress(RuntimeError):
        jax.config.update("jax_num_cpu_devices", min(2, os.cpu_count() or 1))


def main(argv: list[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    given = sys.argv[1:] if argv is None else argv
    if given and given[0] in _COMMANDS:
        command = importlib.import_module(f".{given[0]}.command", __package__)
        return command.main(given[1:])
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
