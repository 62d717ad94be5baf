"""Verbs that improve a design: sensitivity, optimise."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ...mechanism import Mechanism
from ...process import make_folder
from ...quantities import assumptions
from .._app import app
from .._common import Common, checked, emit, words_of, write_text
from .._optimised import optimised_text
from .._programs import run_stored, runs_one_verb
from .._progress import doing, expect_programs
from .._tables import terminal_width

if TYPE_CHECKING:
    from ...sensitivities import Sensitivity

_DEFAULT = Common()
_NAMES = "Names from `prsm quantities`, separated by commas."


def _sensitivity(
    mechanism: Mechanism,
    quantities: list[str] | None,
    parameters: list[str] | None,
    second: bool = False,
) -> "Sensitivity":
    from ...sensitivities import sensitivity as run_sensitivity, sensitivity_by

    if second or not runs_one_verb():
        expect_programs("_numbers", *(["_compiled_hessian"] if second else []))
        return run_sensitivity(mechanism, quantities, parameters, second=second)
    name = f"sensitivity {quantities} {parameters}"

    def evaluate(function, shift):
        return run_stored(name, function, mechanism, shift)

    return sensitivity_by(evaluate, mechanism, quantities, parameters)


@app.command
def sensitivity(
    file: str,
    *,
    quantities: Annotated[str | None, Parameter(help=_NAMES)] = None,
    parameters: Annotated[
        str | None, Parameter(help="Names of numbers in the file, separated by commas.")
    ] = None,
    second: Annotated[
        bool, Parameter(negative="", help="Also second derivatives; they compile for minutes.")
    ] = False,
    common: Common = _DEFAULT,
) -> int:
    """Exact derivatives of quantities with respect to parameters, absolute and relative."""
    mechanism = common.load(file)
    table = _sensitivity(mechanism, words_of(quantities), words_of(parameters), second)
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
        str | None, Parameter(help="auto, slsqp, trust-constr, lbfgs, adam or multi-start.")
    ] = None,
    starts: Annotated[int | None, Parameter(help="Number of starts.")] = None,
    keep_infeasible: Annotated[
        bool,
        Parameter(negative="", help="Write the best design found even if it breaks a limit."),
    ] = False,
    common: Common = _DEFAULT,
) -> int:
    """Improve the design by the file's [optimise] table, and write the optimised file.

    Errors of `prsm check` are constraints, too. The optimised mechanism is written to the
    folder of --out (default out/optimise), unless it violates a constraint. Exit status 1 if no
    design satisfies the constraints and the optimality conditions.
    """
    common.check_targets("out/optimise")
    mechanism = common.load(file)
    expect_programs("_values", "_derivatives")
    from ...optimisation import optimise as run_optimise

    best = run_optimise(mechanism, method=method, starts=starts, progress=told_of_search)
    path = None
    if best.feasible or keep_infeasible:
        folder = Path("out/optimise") if common.out is None else common.out
        make_folder(folder)
        path = folder / f"{Path(file).stem}-optimised.toml"
        write_text(path, optimised_text(file, best))
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
