"""The verb on fronts of two or three objectives."""

from typing import Annotated

from cyclopts import Parameter

from ...mechanism import Objective
from ...quantities import assumptions
from .._app import app
from .._common import Common, checked, emit, words_of
from .._progress import counted, expect_programs
from .._tables import terminal_width

_DEFAULT = Common()
_NAMES = "from `prsm quantities`, separated by commas."


@app.command
def pareto(
    file: str,
    *,
    maximise: Annotated[str | None, Parameter(help=f"Quantities to maximise, {_NAMES}")] = None,
    minimise: Annotated[str | None, Parameter(help=f"Quantities to minimise, {_NAMES}")] = None,
    points: Annotated[int | None, Parameter(help="Points of the front.")] = None,
    starts: Annotated[
        int | None, Parameter(help="Number of starts for the best of each objective.")
    ] = None,
    common: Common = _DEFAULT,
) -> int:
    """The front of two or three objectives, with the variables and limits of [optimise].

    The objectives are those of --maximise and --minimise, or else the file's
    [[optimise.objective]] rows. Errors of `prsm check` are constraints, too. With --out pictures
    are written: the objectives, and the designs across all variables and objectives. Exit status 1
    if a point does not satisfy the optimality conditions.
    """
    mechanism = common.load(file)
    expect_programs("_values", "_derivatives")
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
    )
    if common.out is not None and front.points:
        from ...report import front_chart, parallel_chart, save_figures

        pictures = {"front": front_chart(front), "front-parallel": parallel_chart(front)}
        save_figures(common.out, pictures)
    terms = (*front.objectives, *front.problem.constraints)
    findings = checked(mechanism)
    if front.points:
        # Errors are constraints: those of the present design are not those of the front.
        findings = tuple(one for one in findings if one.severity != "error")
    valid = emit(
        common,
        front.to_dict(),
        lambda: front.text(terminal_width()),
        assumptions(mechanism, [term.quantity for term in terms]),
        findings,
    )
    return int(not (valid and front.converged))
