"""The verb on tolerances: scatter, yield and contributions."""

from typing import Annotated

from cyclopts import Parameter

from ...quantities import assumptions
from ...uncertainty import allocate_tolerances, tolerance as run_tolerance
from .._app import app
from .._common import Common, checked, emit, words_of
from .._progress import counted, expect_programs
from .._tables import terminal_width

_DEFAULT = Common()
_PROGRAMS = {
    "first_order": ("derivatives_along",),
    "second_order": ("derivatives_along",),
    "monte_carlo": ("evaluate_designs",),
    "all": ("derivatives_along", "evaluate_designs"),
}


@app.command
def tolerance(
    file: str,
    *,
    quantities: Annotated[
        str | None, Parameter(help="Names from `prsm quantities`, separated by commas.")
    ] = None,
    method: Annotated[
        str, Parameter(help="first_order, second_order, monte_carlo or all.")
    ] = "all",
    samples: Annotated[
        int, Parameter(help="Designs of Monte Carlo, rounded up to 8 times a power of 2.")
    ] = 4096,
    seed: Annotated[int, Parameter(help="Seed of Monte Carlo.")] = 0,
    wanted_yield: Annotated[
        float | None,
        Parameter(help="Find the tolerances of least cost for this share, such as 0.99."),
    ] = None,
    common: Common = _DEFAULT,
) -> int:
    """Scatter of quantities due to the file's [tolerances], the yield, and what contributes.

    Limits are those of the constraints in the file's [optimise] table; by Monte Carlo an error of
    `prsm check` also counts as a mechanism outside of the limits.
    """
    mechanism = common.load(file)
    expect_programs(*_PROGRAMS.get(method, ()))
    analysis = run_tolerance(
        mechanism,
        words_of(quantities),
        method=method,
        samples=samples,
        seed=seed,
        progress=lambda done, total: counted(done, total, "designs"),
    )
    results, parts = analysis.to_dict(), [analysis.text]
    if wanted_yield is not None:
        allocation = allocate_tolerances(mechanism, wanted_yield, samples=samples, seed=seed)
        results["allocation"] = allocation.to_dict()
        parts.append(allocation.text)
    valid = emit(
        common,
        results,
        lambda: "\n\n".join(part(terminal_width()) for part in parts),
        assumptions(mechanism, analysis.quantities),
        checked(mechanism),
    )
    return int(not valid)
