"""Optimisation of a mechanism: starts, searches, and the best result."""

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal

import numpy as np

from ..fields import Scalar
from ..findings import prepare_check
from ..mechanism import (
    Constraint,
    DesignProblem,
    Mechanism,
    Variable,
    of_one_known_design,
    set_parameters,
)
from ..quantities import QuantityLike
from ._choices import best_of_choices, choices_of
from ._problem import (
    avoiding,
    number,
    present_design,
    problem_of,
    refuse_opposed,
    robust,
    whole_number,
)
from ._searches import Searches
from ._starts import starting_positions
from .results import Design, Optimum, Reporter, optimum_of
from .search import Evaluator, SearchMethod, Slsqp, search_of


@of_one_known_design
def optimise(
    mechanism: Mechanism,
    variables: Mapping[str, tuple[Any, ...]] | Iterable[Variable] | None = None,
    maximise: QuantityLike | Mapping[Any, float | int] | None = None,
    minimise: QuantityLike | Mapping[Any, float | int] | None = None,
    constraints: Mapping[Any, Any] | Iterable[Constraint] | None = None,
    *,
    choices: Mapping[str, Any] | None = None,
    problem: DesignProblem | None = None,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    nut_speed: float | None = None,
    operating_points: Iterable[tuple[float, ...]] | Literal["duty_cycle"] | None = None,
    worst_case: bool | None = None,
    tolerance_sigmas: float | None = None,
    method: SearchMethod | str | None = None,
    starts: int | None = None,
    seed: int | None = None,
    tolerance: float = 1e-6,
    max_iterations: int | None = None,
    progress: bool | Callable[[int, int, int], None] = False,
    watch: Callable[[int, int, int, Design], None] | None = None,
    respect_findings: bool = True,
    avoid_warnings: bool | None = None,
) -> Optimum:
    r"""Find the best design within bounds and constraints, by exact gradients from several starts.

    Variables are scaled by their bounds to [0, 1], the objective and the constraints by typical
    magnitudes. A design that fails (no meshing, a pulling contact, a value that is not finite)
    counts as infeasible: a search that reaches one steps back, and a start at one is reported and
    skipped. The result is judged by the Karush–Kuhn–Tucker residual, whatever the method reports.

    Errors of `check` are constraints by default: rollers that overlap, teeth that interfere, a
    load above the static capacity, and so on. Numbers that must be whole (starts, teeth) are
    continuous at first; then the search continues with the whole numbers on either side. An error
    that no variable changes makes the problem infeasible and is named.

    **Arguments:**

    - `mechanism`: the mechanism; the first start is its present design, moved into the bounds.
    - `variables`: (lower, upper) bounds [SI] by the name of a parameter, or `Variable` objects.
    - `maximise`, `minimise`: a quantity, or weights by quantity; together they form one sum of
      weight × value [SI], with a minus for what is maximised. A function of a mechanism that
      returns one number may stand for the name of a quantity, here and in `constraints`.
    - `constraints`: (lower, upper) limits [SI] by quantity, `None` for no limit, one number for an
      equality; or `Constraint` objects. A quantity with components is limited in each.
    - `choices`: lists of values [SI] to choose from, by the name of a parameter, such as
      `{"roller_count": range(7, 13), "lead": [5e-3, 10e-3]}`: numbers that must be whole, or those
      of `standard_modules` (for `gear_module`), `standard_leads` and `preferred_numbers` of
      `prsm_jax.mechanism`. Every combination is searched; listed numbers share a compiled
      program, and so do numbers of rollers from 4 on; other whole numbers that shape the
      mechanism need their own.
    - `problem`: supplies the arguments above that are omitted; default that of the mechanism.
    - `speed`, `load`: operating point [rad/s, N]; default that of the mechanism.
    - `nut_speed`: axial speed of the last nut [m/s] in place of the screw speed, which then follows
      for each design; default that of the problem.
    - `operating_points`: several (speed, load) or (speed, load, share) in place of one: every
      objective is their mean by shares, and every constraint and margin holds at each.
      `"duty_cycle"`: the phases of the mechanism's duty cycle, with their durations as shares.
    - `worst_case`: whether each objective is its worst value at any operating point, in place of
      the mean; default is `over` of each objective.
    - `tolerance_sigmas`: number of first-order standard deviations, due to the mechanism's
      tolerances, by which each objective and each limited quantity is worsened from its mean;
      default that of the problem. Margins of `check` are those in the middle of the tolerances.
    - `method`: `"slsqp"` or `"trust-constr"` (SciPy), or, for bounds only, `"lbfgs"` or `"adam"`
      (optax), or `"multi-start"`: Adam from all starts at once, then SLSQP from the best few.
      `"auto"`: SLSQP with constraints, L-BFGS without. Default that of the problem, with its
      `method_options`. Or an object
      that carries its own options: `Slsqp`, `TrustConstr`, `Lbfgs`, `Adam`, `MultiStart`, `Optax`,
      `Scipy` of `prsm_jax.optimisation`, or a `SearchMethod` of your own.
    - `starts`, `seed`: number of starts, and seed of the Latin hypercube of all but the first.
      Default those of the problem.
    - `tolerance`: for the Karush–Kuhn–Tucker residual and for constraints, in scaled units.
    - `max_iterations`: per start, for a method given by a word; default by method.
    - `progress`: show a progress bar over the starts; or a function that is called at every
      iteration with the number of the start (from 1), the number of starts, and the iteration.
    - `watch`: called at every iteration with the same numbers and the `Design`. An exception that
      it raises ends the search.
    - `respect_findings`: whether errors of `check` are constraints; if not, the result may be a
      design that cannot be built.
    - `avoid_warnings`: whether warnings of `check` are constraints, too, where they depend on the
      variables and have a derivative; default that of the problem.

    **Returns:** an `Optimum`. Infeasible problems and failed searches are reported there
    (`converged`, `message`), not raised.

    **Raises:** `UnknownNameError` for unknown names; `ValueError` for an invalid problem, or for a
    method that is unknown, does not accept the constraints, or does not take an option;
    `MissingDataError` where the mechanism lacks data.
    """
    problem = problem_of(mechanism, problem, variables, maximise, minimise, constraints)
    refuse_opposed(problem)
    if nut_speed is not None:
        problem = dataclasses.replace(problem, nut_speed=nut_speed)
    problem = robust(mechanism, problem, operating_points, worst_case, tolerance_sigmas)
    problem = avoiding(problem, avoid_warnings, respect_findings)
    if choices is not None:
        problem = dataclasses.replace(problem, choices=choices_of(choices))

    def search_one(moved: Mechanism, inner: DesignProblem, counts: dict[str, float]) -> Optimum:
        return _of_fixed_choices(
            moved,
            inner,
            counts,
            speed=number(speed, "speed"),
            load=number(load, "load"),
            method=method,
            starts=starts,
            seed=seed,
            tolerance=tolerance,
            max_iterations=max_iterations,
            progress=progress,
            watch=watch,
            respect_findings=respect_findings,
        )

    if problem.choices:
        return best_of_choices(mechanism, problem, search_one)
    return search_one(mechanism, problem, {})


def _of_fixed_choices(
    mechanism: Mechanism,
    problem: DesignProblem,
    counts: dict[str, float],
    *,
    speed: Scalar | None,
    load: Scalar | None,
    method: SearchMethod | str | None,
    starts: int | None,
    seed: int | None,
    tolerance: float,
    max_iterations: int | None,
    progress: bool | Callable[[int, int, int], None],
    watch: Callable[[int, int, int, Design], None] | None,
    respect_findings: bool,
) -> Optimum:
    """`optimise` without choices; `counts` as for `Evaluator`."""
    present = present_design(mechanism, problem.variables)
    count = whole_number(problem.starts if starts is None else starts, "starts", 1)
    seed = whole_number(problem.seed if seed is None else seed, "seed", 0)
    if not 0 < tolerance < 1:
        raise ValueError(f"tolerance is {tolerance}; it must be between 0 and 1")
    requested = problem.method if method is None else method
    worst = any(one.over == "worst" for one in problem.objectives)
    # The options of the problem are for its own method.
    options = problem.method_options if method is None else ()
    search = search_of(requested, bool(problem.constraints) or worst, max_iterations, options)

    names = [variable.name for variable in problem.variables]
    placed = dict(zip(names, present, strict=True))

    def prepare() -> None:
        # Of the optimum, which has the structure of any other design of the problem.
        prepare_check(set_parameters(mechanism, placed, checked=False))

    evaluator = _evaluator(mechanism, problem, counts, speed, load, respect_findings, prepare)
    report = Reporter(evaluator, problem)
    initial = (present - evaluator.lower) / evaluator.width
    positions = list(starting_positions(initial, count, seed))
    for position in positions:
        if evaluator.point(position).good:
            evaluator.scale_from(position)
            break

    if search.chooses_starts:
        positions = search.chosen(evaluator, np.array(positions))
        count = len(positions)

    searches = Searches(evaluator, report, tolerance, count)
    searches.tell = progress if callable(progress) else None
    searches.watch = watch
    bounds_only = not search.accepts_constraints
    evaluator.guard(bounds_only)
    searches.run_all(search, _progress(positions, progress is True))
    if bounds_only and requested == "auto" and evaluator.margins.smooth and not searches.converged:
        # A margin may have stopped the search; a search with constraints can move along it.
        # SLSQP does not take other options of L-BFGS.
        both = [one for one in options if one[0] == "max_iterations"]
        search = search_of("auto", True, max_iterations, both)
        evaluator.guard(False)
        searches.clear()
        searches.run_all(search, positions)
    evaluator.guard(False)
    if evaluator.margins.integer:
        # `max_iterations` applies to the searches from the starts, not to these searches.
        searches.make_whole(search_of(requested, True) if search.accepts_constraints else Slsqp())
    best, end, conditions = searches.best(initial)
    return optimum_of(
        mechanism,
        problem,
        search.name,
        evaluator,
        report,
        initial,
        tuple(searches.runs),
        best,
        end,
        conditions,
        tolerance,
    )


def _evaluator(
    mechanism: Mechanism,
    problem: DesignProblem,
    counts: dict[str, float],
    speed: Scalar | None,
    load: Scalar | None,
    margins: bool,
    meanwhile: Callable[[], None],
) -> Evaluator:
    """With a program that takes `counts` as numbers, if there is one."""
    if counts:
        try:
            shared = Evaluator(
                mechanism, problem, speed, load, margins=margins, counts=counts, meanwhile=meanwhile
            )
            if not shared.evaluations:
                # The first call makes the program.
                shared.point(np.full(shared.variables, 0.5))
        except (TypeError, ValueError):
            # A quantity that needs the number itself has a program for each.
            pass
        else:
            return shared
    return Evaluator(mechanism, problem, speed, load, margins=margins, meanwhile=meanwhile)


def _progress(positions: list[np.ndarray], progress: bool):
    if not progress:
        return positions
    try:
        import tqdm
    except ImportError as error:
        from .._errors import missing_extra

        raise missing_extra("sweep", "a progress bar", error) from error
    return tqdm.tqdm(positions, desc="optimise", unit=" starts")
