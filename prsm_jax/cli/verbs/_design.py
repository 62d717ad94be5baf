"""Verbs that improve a design: sensitivity, optimise, pareto."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...mechanism import Objective
from ...process import make_folder
from ...quantities import assumptions
from .._app import app
from .._common import Common, checked, emit, parameters_of, words_of, write_text
from .._counts import count
from .._optimised import nothing_written, optimised_text
from .._progress import counted, doing, expect_programs
from .._tables import terminal_width

_DEFAULT = Common()
_FROM = "from `prsm quantities`, separated by commas."
_NAMES = f"Names {_FROM}"
_AvoidWarnings = Annotated[
    bool,
    Parameter(
        negative="",
        help="Warnings of `prsm check` are constraints, too (avoid_warnings in [optimise]).",
    ),
]


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
    from ...sensitivities import sensitivity as run_sensitivity

    mechanism = common.load(file)
    expect_programs("_numbers", *(["_compiled_hessian"] if second else []))
    names = parameters_of(mechanism, parameters, "--parameters")
    table = run_sensitivity(mechanism, words_of(quantities), names, second=second)
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
    starts: Annotated[int | None, count(1, 10_000, help="Number of starts.")] = None,
    keep_infeasible: Annotated[
        bool,
        Parameter(negative="", help="Write the best design found even if it breaks a limit."),
    ] = False,
    avoid_warnings: _AvoidWarnings = False,
    common: Common = _DEFAULT,
) -> int:
    """Improve the design by the file's [optimise] table, and write the optimised file.

    Errors of `prsm check` are constraints, too. The optimised mechanism is written to the
    folder of --out (default out/optimise), unless it violates a constraint. Exit status 1 if no
    design satisfies the constraints and the optimality conditions.
    """
    common.check_targets("out/optimise")
    mechanism = common.load(file, is_checked=False)
    expect_programs("compiled_derivatives")
    from ...optimisation import optimise as run_optimise

    best = run_optimise(
        mechanism,
        method=method,
        starts=starts,
        progress=told_of_search,
        # The key of the file stays where the option is not given.
        avoid_warnings=avoid_warnings or None,
    )
    folder = Path("out/optimise") if common.out is None else common.out
    target = folder / f"{Path(file).stem}-optimised.toml"
    written = best.feasible or keep_infeasible
    if written:
        make_folder(folder)
        write_text(target, optimised_text(file, best))
        name = "optimised mechanism" if best.feasible else "best design found, which breaks limits"
        where = f"{name}: {target}"
    else:
        reason = "the best design found breaks limits (--keep-infeasible)"
        where = nothing_written(target, reason, common)
    results = best.to_dict() | {"mechanism": target if written else None, "valid": best.feasible}

    def text() -> str:
        return f"{best.text(terminal_width())}\n\n{where}"

    terms = (*best.problem.objectives, *best.problem.constraints)
    rests_on = assumptions(best.mechanism, [term.quantity for term in terms])
    emit(common, results, text, rests_on, best.findings_optimum)
    return int(not best.converged)


def told_of_search(start: int, starts: int, iteration: int) -> None:
    """Show the progress of an optimisation on the terminal."""
    doing(f"start {start} of {starts}, iteration {iteration}")


@app.command
def pareto(
    file: str,
    *,
    maximise: Annotated[str | None, Parameter(help=f"Quantities to maximise, {_FROM}")] = None,
    minimise: Annotated[str | None, Parameter(help=f"Quantities to minimise, {_FROM}")] = None,
    points: Annotated[int | None, count(3, 1000, help="Points of the front.")] = None,
    starts: Annotated[
        int | None, count(1, 10_000, help="Number of starts for the best of each objective.")
    ] = None,
    avoid_warnings: _AvoidWarnings = False,
    common: Common = _DEFAULT,
) -> int:
    """The front of two or three objectives, with the variables and limits of [optimise].

    The objectives are those of --maximise and --minimise, or else the file's
    [[optimise.objective]] rows. Errors of `prsm check` are constraints, too. With --out pictures
    are written: the objectives, and the designs across all variables and objectives. Exit status 1
    if no feasible design is found, or a point does not satisfy the optimality conditions.
    """
    mechanism = common.load(file)
    expect_programs("compiled_derivatives")
    objectives = [
        *(Objective(name, "maximise") for name in words_of(maximise) or ()),
        *(Objective(name, "minimise") for name in words_of(minimise) or ()),
    ]
    from ...optimisation import pareto as run_pareto

    front = run_pareto(
        mechanism,
        objectives or None,
        points=points,
        starts=starts,
        progress=lambda done, total: counted(done, total, "searches"),
        avoid_warnings=avoid_warnings or None,
    )
    results = front.to_dict() | {"valid": bool(front.points)}
    missing = ""
    if common.out is not None:
        results["pictures"] = []
        if front.points:
            from ...report import front_chart, parallel_chart, save_figures

            pictures = {"front": front_chart(front), "front-parallel": parallel_chart(front)}
            results["pictures"] = save_figures(common.out, pictures)
        else:
            reason = "without a feasible design there is no picture"
            missing = "\n\n" + nothing_written(common.out / "front.png", reason, common)
    terms = (*front.objectives, *front.problem.constraints)
    findings = checked(mechanism)
    if front.points:
        # Errors are constraints: those of the present design are not those of the front.
        findings = tuple(one for one in findings if one.severity != "error")
    valid = emit(
        common,
        results,
        lambda: front.text(terminal_width()) + missing,
        assumptions(mechanism, [term.quantity for term in terms]),
        findings,
    )
    return int(not (valid and front.converged))
