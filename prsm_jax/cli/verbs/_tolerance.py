"""The verb on tolerances: scatter, yield and contributions."""

import sys
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ...mechanism import Mechanism
from ...quantities import assumptions
from .._app import app
from .._common import Common, checked, emit, words_of
from .._counts import MOST_DESIGNS, count, share
from .._progress import clear, counted, expect_programs
from .._tables import terminal_width

if TYPE_CHECKING:
    from ...uncertainty import ToleranceAnalysis

_DEFAULT = Common()
#: Quantities with a picture of the ends of their tolerances; those with limits come first.
_TORNADOES = 6
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
        int,
        count(16, MOST_DESIGNS, help="Designs of Monte Carlo, rounded up to 8 times a power of 2."),
    ] = 4096,
    seed: Annotated[int, count(0, help="Seed of Monte Carlo.")] = 0,
    wanted_yield: Annotated[
        float | None,
        share("Find the tolerances of least cost for this share, such as 0.99."),
    ] = None,
    common: Common = _DEFAULT,
) -> int:
    """Scatter of quantities due to the file's [tolerances], the yield, and contributions.

    Limits are the constraints in the file's [optimise] table; by Monte Carlo a mechanism with an
    error of `prsm check` also counts as outside of the limits. With --out, pictures are written
    to that folder: distributions, contributions, ends of the tolerance zones (tornado), a pair of
    quantities, yield and cost.
    """
    mechanism = common.load(file)
    expect_programs(*_PROGRAMS.get(method, ()))
    from ...uncertainty import allocate_tolerances, tolerance as run_tolerance

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
    if common.out is not None and analysis.valid:
        _save_pictures(common, mechanism, analysis, samples, seed)
    valid = emit(
        common,
        results,
        lambda: "\n\n".join(part(terminal_width()) for part in parts),
        assumptions(mechanism, analysis.quantities),
        checked(mechanism),
    )
    return int(not valid)


def _save_pictures(
    common: Common, mechanism: Mechanism, analysis: "ToleranceAnalysis", samples: int, seed: int
) -> None:
    """Write the pictures that the analysis and its limits allow."""
    from ...report import (
        contribution_bars,
        cost_chart,
        save_figures,
        tolerance_histograms,
        tolerance_scatter,
        tornado_chart,
        yield_chart,
    )
    from ...uncertainty import cost_curve, yield_curve

    assert common.out is not None
    pictures = {
        "tolerance-distributions": tolerance_histograms(analysis),
        "tolerance-contributions": contribution_bars(analysis),
    }
    pairs = zip(analysis.quantities, analysis.limits, strict=True)
    limited = [name for name, limit in pairs if limit is not None]
    ranked = [*limited, *(name for name in analysis.quantities if name not in limited)]
    if len(analysis.methods) > 1 and len(ranked) > 1:
        pictures["tolerance-scatter"] = tolerance_scatter(analysis, *ranked[:2])
    for name in ranked[:_TORNADOES]:
        # A component, such as drive_torque[2], has brackets, which shells interpret.
        file = name.replace("[", "-").replace("]", "").replace(",", "-")
        try:
            pictures[f"tolerance-tornado-{file}"] = tornado_chart(analysis, name)
        except ValueError as error:
            clear()
            print(f"prsm: no tornado of {name}: {error}", file=sys.stderr)
    if limited:
        curve = yield_curve(
            mechanism,
            method="all" if len(analysis.methods) > 1 else analysis.method,
            samples=samples,
            seed=seed,
            progress=lambda done, total: counted(done, total, "designs of the yield curve"),
        )
        pictures["tolerance-yield"] = yield_chart(curve)
        try:
            pictures["tolerance-cost"] = cost_chart(cost_curve(mechanism))
        except ValueError as error:
            # If the design itself violates a limit, no tolerances reach a yield.
            clear()
            print(f"prsm: no picture of the cost: {error}", file=sys.stderr)
    save_figures(common.out, pictures)
