"""Optimisation of a mechanism: starts, searches, and the best of what they find."""

from collections.abc import Callable, Iterable, Mapping

import jax.numpy as jnp
import numpy as np

from ..mechanism import Constraint, DesignProblem, Mechanism, Scalar, Variable
from ._evaluator import Evaluator, Guarded, Point
from ._methods import find_search
from ._optimality import Optimality, optimality
from ._optimum import Optimum, Run
from ._problem import present_design, problem_of
from ._reporting import Reporter, optimum_of, run_report
from ._search import Search
from ._starts import starting_positions

_ITERATIONS = {"adam": 2000, "lbfgs": 500, "slsqp": 300, "trust-constr": 3000}


def optimise(
    mechanism: Mechanism,
    variables: Mapping[str, tuple] | Iterable[Variable] | None = None,
    maximise: str | Mapping | None = None,
    minimise: str | Mapping | None = None,
    constraints: Mapping | Iterable[Constraint] | None = None,
    *,
    problem: DesignProblem | None = None,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    method: str | None = None,
    starts: int | None = None,
    seed: int | None = None,
    tolerance: float = 1e-6,
    max_iterations: int | None = None,
    progress: bool | Callable[[int, int, int], None] = False,
) -> Optimum:
    r"""Find the best design within bounds and constraints, by exact gradients from several starts.

    Variables are scaled by their bounds to [0, 1], the objective and the constraints by typical
    magnitudes. A design that fails (no meshing, a pulling contact, a value that is not finite)
    counts as infeasible: a search that meets one steps back, and a start on one is reported and
    left. The result is judged by the Karush–Kuhn–Tucker residual, whatever the method says.

    **Arguments:**

    - `mechanism`: the mechanism; the first start is its present design, moved into the bounds.
    - `variables`: (lower, upper) bounds [SI] by the name of a parameter, or `Variable` objects.
    - `maximise`, `minimise`: a quantity, or weights by quantity; together they form one sum.
    - `constraints`: (lower, upper) limits [SI] by quantity, `None` for no limit, one number for an
      equality; or `Constraint` objects. A quantity with components is limited in each.
    - `problem`: supplies what the arguments above leave out; default that of the mechanism.
    - `speed`, `load`: operating point [rad/s, N]; default that of the mechanism.
    - `method`: `"slsqp"` or `"trust-constr"` (SciPy), or, for bounds only, `"lbfgs"` or `"adam"`
      (optax). `"auto"`: SLSQP with constraints, L-BFGS without. Default that of the problem.
    - `starts`, `seed`: number of starts, of which all but the first form a Latin hypercube.
      Default those of the problem.
    - `tolerance`: for the Karush–Kuhn–Tucker residual and for constraints, in scaled units.
    - `max_iterations`: per start; default by method.
    - `progress`: show a progress bar over the starts; or a function that is told, at every
      iteration, the number of the start (from 1), how many there are, and the iteration.

    **Returns:** an `Optimum`. Infeasible problems and failed searches are reported there
    (`converged`, `message`), not raised.

    **Raises:** `UnknownNameError` for unknown names; `ValueError` for a problem that makes no
    sense; `MissingDataError` where the mechanism lacks data; `MissingExtraError` without SciPy, if
    there are constraints.
    """
    problem = problem_of(mechanism, problem, variables, maximise, minimise, constraints)
    present = present_design(mechanism, problem.variables)
    count = problem.starts if starts is None else starts
    if count < 1:
        raise ValueError(f"starts is {count}; it must be at least 1")
    if not 0 < tolerance < 1:
        raise ValueError(f"tolerance is {tolerance}; it must be between 0 and 1")
    method, search = find_search(
        problem.method if method is None else method, bool(problem.constraints)
    )
    iterations = _ITERATIONS[method] if max_iterations is None else max_iterations
    if iterations < 1:
        raise ValueError(f"max_iterations is {iterations}; it must be at least 1")

    evaluator = Evaluator(mechanism, problem, _number(speed), _number(load))
    report = Reporter(evaluator, problem)
    initial = (present - evaluator.lower) / evaluator.width
    positions = starting_positions(initial, count, problem.seed if seed is None else seed)
    for position in positions:
        if evaluator.point(position).good:
            evaluator.scale_from(position)
            break

    runs, ends = [], []
    tell = progress if callable(progress) else None
    for number, position in enumerate(_progress(positions, progress is True), start=1):

        def step(iteration: int, number: int = number) -> None:
            if tell is not None:
                tell(number, count, iteration)

        run, end = _run(evaluator, report, search, position, tolerance, iterations, step)
        runs.append(run)
        ends.append(end)
    best = _best(evaluator, ends, tolerance)
    # With no usable design at all, the design as it was is shown beside the message.
    end = ends[best][0] if ends[best] is not None else evaluator.point(initial)
    conditions = ends[best][1] if ends[best] is not None else None
    return optimum_of(
        mechanism,
        problem,
        method,
        evaluator,
        report,
        initial,
        tuple(runs),
        best,
        end,
        conditions,
        tolerance,
    )


def _number(value: float | Scalar | None) -> Scalar | None:
    # A Python number would be a constant of the program, and another speed another program.
    return None if value is None else jnp.asarray(value, jnp.result_type(float))


def _progress(positions: np.ndarray, progress: bool):
    if not progress:
        return positions
    try:
        import tqdm
    except ImportError as error:
        from .._errors import missing_extra

        raise missing_extra("sweep", "a progress bar", error) from error
    return tqdm.tqdm(positions, desc="optimise", unit=" starts")


def _conditions(evaluator: Evaluator, point: Point, tolerance: float) -> Optimality:
    return optimality(
        point.position,
        evaluator.cost_gradient(point.position),
        evaluator.constraint_values(point),
        evaluator.constraint_jacobian(point.position),
        *evaluator.scaled_limits,
        active_tolerance=max(tolerance, 1e-9),
    )


def _run(
    evaluator: Evaluator,
    report: Reporter,
    search: Search,
    start: np.ndarray,
    tolerance: float,
    iterations: int,
    step: Callable[[int], None],
) -> tuple[Run, tuple[Point, Optimality] | None]:
    """One search, and where it ended with the optimality there; `None` if nothing was usable."""
    first = evaluator.point(start)
    history = [first]
    step(0)

    def note(position: np.ndarray) -> None:
        history.append(evaluator.point(position))
        step(len(history) - 1)

    if not first.good:
        message = "the start fails: no meshing, a pulling contact, or a value that is not finite"
        return run_report(report, first, None, history, None, 0, 0, message), None
    functions = Guarded(evaluator)
    # The searches go a little further than the check asks for.
    result = search(functions, start, tolerance / 10, iterations, note)
    end = functions.best(result.position, tolerance)
    if end is None:
        failed = run_report(
            report,
            first,
            None,
            history,
            None,
            functions.failures,
            result.iterations,
            result.message,
        )
        return failed, None
    conditions = _conditions(evaluator, end, tolerance)
    if not np.array_equal(history[-1].position, end.position):
        history.append(end)
    run = run_report(
        report,
        first,
        end,
        history,
        conditions,
        functions.failures,
        result.iterations,
        result.message,
    )
    return run, (end, conditions)


def _best(evaluator: Evaluator, ends: list, tolerance: float) -> int:
    """The feasible run of least cost; of those as good as it, the first that converged."""
    usable = [index for index, end in enumerate(ends) if end is not None]
    if not usable:
        return 0
    feasible = [i for i in usable if evaluator.violation(ends[i][0]) <= tolerance]
    if not feasible:
        return min(usable, key=lambda i: evaluator.violation(ends[i][0]))
    least = min(evaluator.cost(ends[i][0]) for i in feasible)
    level = [i for i in feasible if evaluator.cost(ends[i][0]) <= least + tolerance]
    # The first start is the present design: its history is the one that a reader understands.
    return min(level, key=lambda i: (max(ends[i][1].residual, tolerance), i))
