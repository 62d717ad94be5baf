"""Verbs that improve a design: sensitivity, optimise, sweep."""

import math
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter

from ..._errors import PrsmError
from ...mechanism import Mechanism, find_parameters
from ...optimisation import optimise as run_optimise
from ...process import folder_for_results, make_folder
from ...quantities import assumptions
from ...sensitivities import sensitivity as run_sensitivity
from ...sweeps import sweep as run_sweep
from .._app import app
from .._common import Common, checked, emit, value_of, words_of, write_text
from .._optimised import optimised_text
from .._progress import counted, doing, expect_programs
from .._tables import prose, terminal_width

_DEFAULT = Common()
_NAMES = "Names from `prsm quantities`, separated by commas."


@app.command
def sensitivity(
    file: str,
    *,
    quantities: Annotated[str | None, Parameter(help=_NAMES)] = None,
    parameters: Annotated[
        str | None, Parameter(help="Names of numbers in the file, separated by commas.")
    ] = None,
    common: Common = _DEFAULT,
) -> int:
    """Exact derivatives of quantities with respect to parameters, absolute and relative."""
    mechanism = common.load(file)
    expect_programs("_sensitivity")
    table = run_sensitivity(mechanism, words_of(quantities), words_of(parameters))
    if common.out is not None:
        from ...report import save_figures, sensitivity_bars

        bars = sensitivity_bars(table.quantities, table.parameters, table.elasticity)
        save_figures(common.out, {"sensitivity": bars})
    valid = emit(
        common,
        table.to_dict(),
        lambda: table.text(terminal_width()),
        assumptions(mechanism, table.quantities),
        checked(mechanism),
    )
    return int(not valid)


@app.command
def optimise(
    file: str,
    *,
    method: Annotated[
        str | None, Parameter(help="auto, slsqp, trust-constr, lbfgs or adam.")
    ] = None,
    starts: Annotated[int | None, Parameter(help="Number of starts.")] = None,
    keep_infeasible: Annotated[
        bool,
        Parameter(negative="", help="Write the best design found even if it breaks a limit."),
    ] = False,
    common: Common = _DEFAULT,
) -> int:
    """Improve the design as the file's [optimise] table says; writes the optimised file.

    Errors of `prsm check` are constraints, too. The optimised mechanism is written to the
    folder of --out (default out/optimise), unless it breaks a constraint; exit status 1 if no
    design satisfies the constraints and the optimality conditions.
    """
    common.check_targets("out/optimise")
    mechanism = common.load(file)
    expect_programs("_values", "_derivatives")
    best = run_optimise(mechanism, method=method, starts=starts, progress=told_of_search)
    path = None
    if best.feasible or keep_infeasible:
        folder = Path("out/optimise") if common.out is None else common.out
        make_folder(folder)
        path = folder / f"{Path(file).stem}-optimised.toml"
        write_text(path, optimised_text(file, mechanism, best))
    results = best.to_dict() | {"mechanism": path, "valid": best.feasible}

    def text() -> str:
        where = f"optimised mechanism: {path}"
        if path is None:
            where = "no file written: the best design found breaks limits (--keep-infeasible)"
        elif not best.feasible:
            where = f"best design found, which breaks limits: {path}"
        return f"{best.text(terminal_width())}\n\n{where}"

    terms = (*best.problem.objectives, *best.problem.constraints)
    rests_on = assumptions(best.mechanism, [term.quantity for term in terms])
    emit(common, results, text, rests_on, best.findings_optimum)
    return int(not best.converged)


def told_of_search(start: int, starts: int, iteration: int) -> None:
    """Show the progress of an optimisation on the terminal."""
    doing(f"start {start} of {starts}, iteration {iteration}")


def _axis(mechanism: Mechanism, text: str) -> tuple[str, np.ndarray]:
    """`NAME=FIRST:LAST:COUNT` or `NAME=VALUE,VALUE,…`, values as in `--set`."""
    name, equals, numbers = (part.strip() for part in text.partition("="))
    if not (name and equals and numbers):
        raise PrsmError(f"--axis {text}: must be NAME=FIRST:LAST:COUNT or NAME=VALUE,VALUE,…")

    def value(word: str) -> float:
        return value_of(mechanism, name, word, f"--axis {text}")

    parts = numbers.split(":")
    if len(parts) == 1:
        return name, np.asarray([value(word) for word in numbers.split(",")])
    if len(parts) != 3 or not parts[2].strip().isdigit() or int(parts[2]) < 2:
        raise PrsmError(
            f"--axis {text}: a range is FIRST:LAST:COUNT with a count of at least 2, such as "
            "'lead=5 mm:15 mm:11'"
        )
    return name, np.linspace(value(parts[0]), value(parts[1]), int(parts[2]))


def _counted(codes: Any) -> dict[str, int]:
    """Number of designs with each code other than 0, by its meaning."""
    meanings = codes.attrs["flag_meanings"].split()
    distinct, counts = np.unique(codes.values, return_counts=True)
    pairs = zip(distinct.astype(int), counts, strict=True)
    return {meanings[code]: int(count) for code, count in pairs if code}


def _listed(counts: dict[str, int]) -> str:
    return ", ".join(f"{name.replace('_', ' ')} ({count})" for name, count in counts.items())


@app.command
def sweep(
    file: str,
    *,
    axis: Annotated[
        list[str],
        Parameter(
            negative="",
            help="NAME=FIRST:LAST:COUNT or NAME=VALUE,VALUE,…, such as 'lead=5 mm:15 mm:11'; "
            "repeat for a grid.",
        ),
    ],
    quantities: Annotated[str, Parameter(help=_NAMES)] = "efficiency,max_pressure",
    common: Common = _DEFAULT,
) -> int:
    """Quantities over the full grid of any parameters, into a zarr store in --out (default out)."""
    common.check_targets("out")
    mechanism = common.load(file)
    axes = dict(_axis(mechanism, text) for text in axis)
    folder = Path("out") if common.out is None else common.out
    store = folder / f"{Path(file).stem}-sweep.zarr"
    # Integers are part of the program: each combination of them needs its own.
    fixed = [
        len(values) for name, values in axes.items() if find_parameters(mechanism, name)[0].static
    ]
    expect_programs("evaluate_chunk", times=math.prod(fixed))
    with folder_for_results(folder):
        data = run_sweep(
            mechanism,
            axes,
            words_of(quantities) or [],
            progress=lambda done, total: counted(done, total, "designs"),
            store=store,
        )
    points, failed = int(data.attrs["points"]), int(data.attrs["failed"])

    reasons, errors = _counted(data["code"]), _counted(data["error"].where(~data["failed"], 0))

    def text() -> str:
        words = f"{points} designs, {failed} failed"
        if reasons:
            words += ": " + _listed(reasons)
        if errors:
            words += f"; errors of prsm check in {sum(errors.values())} more: {_listed(errors)}"
        return prose(words) + str(store)

    findings = checked(mechanism)
    results: dict[str, Any] = {
        "store": store,
        "points": points,
        "failed": failed,
        "reasons": reasons,
        # Designs that did not fail, by the first error that `check` finds in them.
        "errors": errors,
        # Of the mechanism in the file; each design has its own code.
        "findings": list(dict.fromkeys(f.name for f in findings if f.severity != "note")),
        "valid": failed < points,
    }
    if common.out is not None and len(axes) == 2:
        from ...report import save_figure, sweep_map

        for name in words_of(quantities) or []:
            if data[name].ndim == 2:
                save_figure(sweep_map(data, name), common.out / f"sweep-{name}")
    emit(common, results, text, assumptions(mechanism, words_of(quantities)))
    return 0
