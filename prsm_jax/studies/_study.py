"""The function `study`: map, conflicts, front, and the results without parts of the physics."""

import os
from collections.abc import Callable, Iterable, Mapping

from ..mechanism import Constraint, DesignProblem, Mechanism, Variable, of_one_known_design
from ..optimisation import ParetoFront, pareto
from ..quantities import assumptions
from ._conflict import conflicts_of
from ._gradients import front_gradients
from ._map import at_designs, map_over_drivers
from ._problem import StudyProblem, problem_of
from ._result import DriverStudy
from ._variants import parts_of, variant_of

_OPERATING_POINT = (
    "All designs of the study are at the operating point of the mechanism; nut_speed, "
    "operating_points and tolerance_sigmas of [optimise] are not used."
)
_CONTACT_MODES = (
    "A frequency lowest_mesh_… is that of the lowest mode with more than half of its strain energy "
    "in the contacts. It jumps to another mode where the share of a mode passes one half; "
    "lowest_torsional_frequency and lowest_transverse_frequency do not."
)

#: Designs of a map, which are in memory at once.
_MOST_DESIGNS = 100_000_000


def _sentences(names: Iterable[str]) -> tuple[str, ...]:
    """Assumptions of the study itself."""
    jumps = any(name.startswith("lowest_mesh_") for name in names)
    return (_OPERATING_POINT, *((_CONTACT_MODES,) if jumps else ()))


def _check_counts(points: int, front_points: int, starts: int | None, drivers: int) -> None:
    """Refuse counts before anything is computed.

    **Raises:** `ValueError` in one line.
    """
    if not (isinstance(points, int) and points >= 2):
        raise ValueError(f"points is {points}; give a whole number of 2 or more")
    if points**drivers > _MOST_DESIGNS:
        raise ValueError(
            f"points is {points}, which makes {points**drivers:.3g} designs of {drivers} drivers; "
            f"give at most {int(_MOST_DESIGNS ** (1 / drivers) + 1e-6)}"
        )
    for name, value, least, most in (
        ("front_points", front_points, 3, 1000),
        ("starts", starts, 1, 10_000),
    ):
        if value is not None and not (isinstance(value, int) and least <= value <= most):
            raise ValueError(f"{name} is {value}; give a whole number from {least} to {most}")


@of_one_known_design
def study(
    mechanism: Mechanism,
    drivers: Mapping[str, tuple[float, float]] | Iterable[str] | None = None,
    quantities: Mapping[str, str] | None = None,
    objectives: Iterable[str] | None = None,
    limits: Iterable[Constraint] | None = None,
    *,
    points: int = 7,
    front_points: int = 11,
    without: Iterable[str] | None = None,
    starts: int | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> DriverStudy:
    r"""Study the effect of a few drivers on quantities, conflicts, and the best compromises.

    1. A map: all quantities and their exact gradients over a grid of the drivers (`sweep`).
    2. Conflicts: at each design the cosine of the angle between the elasticities
       $\frac{p}{q}\frac{\partial q}{\partial p}$ of two quantities, with the signs of their senses.
       Quantities with limits are included: where objectives conflict only with a limit, the limit
       determines the compromise.
    3. The front of two or three of the quantities within the limits (`pareto`), and the gradient at
       each of its points.
    4. The front without parts of the physics, and its designs computed with complete physics.

    The study refers to the mechanism's operating point; `nut_speed`, `operating_points` and
    `tolerance_sigmas` of the design problem are not used. Its `avoid_warnings` holds for the front.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `drivers`: ranges [SI] by the name of a number, or only names: then the ranges are those of
      the variables of its design problem, or 25 % on either side of the present value. Default
      lead, contact angle and roller radius.
    - `quantities`: `"maximise"` or `"minimise"` by the name of a quantity, two or more. Default
      efficiency and the lowest torsional and transverse frequencies of the contacts, all to be
      maximised, as far as the mechanism has data.
    - `objectives`: two or three of the quantities, the objectives of the front; default the first
      two.
    - `limits`: constraints of the front; default those of the design problem. Errors of `check` are
      constraints, too.
    - `points`: values of every driver in the map, 2 or more; 100 million designs at most.
    - `front_points`: points of a front, as `points` of `pareto`.
    - `without`: parts of the physics that are left out, one at a time; names as in `explain`, or
      their ends, such as `spin`. Default those of spin, rolling hysteresis and load sharing that
      the mechanism has.
    - `starts`: of the searches for the best of each objective; default those of the design problem.
    - `store`: directory of a zarr store of the map, which a later call continues.
    - `progress`: called with words on the present computation, the number of its finished steps
      and the total number.

    **Returns:** a `DriverStudy`, which prints itself. Without a feasible design its front has no
    points.

    **Raises:** as `sweep` and `pareto`; `ValueError` for an invalid range, sense or number of
    points, and for quantities with components; `UnknownNameError` for an unknown name.
    """
    parts = parts_of(mechanism, without)
    problem = problem_of(mechanism, drivers, quantities, objectives, limits)
    _check_counts(points, front_points, starts, len(problem.drivers))
    tell = progress or (lambda what, done, total: None)
    own = mechanism.design_problem
    searches = (4 if own is None else own.starts) if starts is None else starts

    def find_front(one: Mechanism, its: StudyProblem, what: str = "front") -> ParetoFront:
        return pareto(
            one,
            problem=DesignProblem(
                tuple(Variable(d.name, d.lower, d.upper) for d in its.drivers),
                its.front_objectives,
                its.limits,
                starts=searches,
                seed=0 if own is None else own.seed,
                points=front_points,
                avoid_warnings=False if own is None else own.avoid_warnings,
            ),
            progress=lambda done, total: tell(what, done, total),
        )

    grid, _ = map_over_drivers(
        mechanism, problem, points, store, lambda done, total: tell("map", done, total)
    )
    front = find_front(mechanism, problem)
    present = {one.name: one.present for one in problem.drivers}
    designs = [present, *(point.variables for point in front.points)]
    size = grid.usable.size
    here = at_designs(mechanism, problem, designs, problem.computed, size)
    variants = []
    for name, places in parts.items():

        def find_without(one: Mechanism, its: StudyProblem, name: str = name) -> ParetoFront:
            return find_front(one, its, f"front without {name}")

        variants.append(
            variant_of(mechanism, problem, name, places, designs, here, front, size, find_without)
        )
    return DriverStudy(
        title=mechanism.title,
        problem=problem,
        map=grid,
        conflicts=conflicts_of(problem, grid, here),
        front=front,
        designs=here,
        gradients=front_gradients(problem, front, here, 1),
        variants=tuple(variants),
        assumptions=(
            *assumptions(mechanism, problem.computed),
            *_sentences(problem.computed),
        ),
    )
