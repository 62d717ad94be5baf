"""First-order optimality: how far a point is from satisfying the Karush–Kuhn–Tucker conditions."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Optimality:
    """The Karush–Kuhn–Tucker conditions at a point, in scaled units.

    Multipliers fulfil `gradient = Σ multiplier · slope`, positive for a lower limit, negative for
    an upper one. Each is the change of the least cost per change of the limit.
    """

    #: Largest component of `gradient − Σ multiplier · slope`.
    stationarity: float
    #: Largest violation of a limit or a bound.
    violation: float
    #: Largest product of a multiplier and the distance to its limit.
    complementarity: float
    #: One per constraint row.
    multipliers: np.ndarray
    #: One per variable, for its bounds.
    bound_multipliers: np.ndarray
    #: −1 at the lower limit, +1 at the upper, 0 between; equalities are 1.
    active: np.ndarray
    #: −1 at the lower bound of the box, +1 at the upper, 0 between.
    active_bounds: np.ndarray

    @property
    def residual(self) -> float:
        """The largest of stationarity, violation and complementarity."""
        return max(self.stationarity, self.violation, self.complementarity)


def optimality(
    position: np.ndarray,
    gradient: np.ndarray,
    values: np.ndarray,
    jacobian: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    *,
    active_tolerance: float = 1e-6,
) -> Optimality:
    r"""Check the Karush–Kuhn–Tucker conditions of a minimum in the unit box.

    The multipliers are the non-negative least-squares solution of $\nabla f = \sum \lambda_i
    \nabla c_i$ over the active limits and bounds (Nocedal and Wright 2006, section 12.3); no
    optimiser is involved.

    **Arguments:**

    - `position`: the point, in [0, 1] (variables).
    - `gradient`: of the cost (variables).
    - `values`, `jacobian`: of the constraint rows (rows; rows × variables).
    - `lower`, `upper`: limits of the rows; infinite where there is none, equal for an equality.
    - `active_tolerance`: a limit nearer than this is active.

    **Returns:** an `Optimality`; all arguments and results are without units, as scaled by the
    search.
    """
    equality = lower == upper
    at_lower = ~equality & (values - lower <= active_tolerance)
    at_upper = ~equality & (upper - values <= active_tolerance)
    low_bound, high_bound = position <= active_tolerance, 1 - position <= active_tolerance
    count = len(position)
    unit = np.eye(count)
    rows = np.concatenate(
        [np.flatnonzero(at_lower), np.flatnonzero(at_upper), np.tile(np.flatnonzero(equality), 2)]
    ).astype(int)
    signs = np.concatenate(
        [
            np.ones(at_lower.sum()),
            -np.ones(at_upper.sum()),
            np.ones(equality.sum()),
            -np.ones(equality.sum()),
        ]
    )
    columns = np.concatenate(
        [(signs[:, None] * jacobian[rows]).reshape(-1, count), unit[low_bound], -unit[high_bound]]
    ).T
    solution = _non_negative_least_squares(columns, gradient, bool(len(rows)))
    multipliers, bounds = np.zeros(len(values)), np.zeros(count)
    np.add.at(multipliers, rows, signs * solution[: len(rows)])
    split = len(rows) + low_bound.sum()
    np.add.at(bounds, np.flatnonzero(low_bound), solution[len(rows) : split])
    np.add.at(bounds, np.flatnonzero(high_bound), -solution[split:])

    outside = [0.0, np.max(-position), np.max(position - 1)]
    if len(values):
        outside += [np.max(lower - values), np.max(values - upper)]
    slack = np.where(multipliers > 0, values - lower, upper - values)
    slack = np.where(multipliers == 0, 0.0, slack)
    bound_slack = np.where(bounds > 0, position, 1 - position)
    products = np.concatenate([np.abs(multipliers * slack), np.abs(bounds * bound_slack)])
    return Optimality(
        stationarity=float(np.max(np.abs(gradient - columns @ solution))),
        violation=float(max(outside)),
        complementarity=float(np.max(products, initial=0.0)),
        multipliers=multipliers,
        bound_multipliers=bounds,
        active=np.where(equality | at_upper, 1, np.where(at_lower, -1, 0)),
        active_bounds=np.where(high_bound, 1, np.where(low_bound, -1, 0)),
    )


def worst_case_optimality(
    position: np.ndarray,
    gradient: np.ndarray,
    values: np.ndarray,
    jacobian: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    parts: Sequence[tuple[np.ndarray, np.ndarray]],
    *,
    active_tolerance: float = 1e-6,
) -> tuple[Optimality, np.ndarray]:
    r"""As `optimality`, for a smooth cost plus the largest function of each of several sets.

    The conditions are those of the smooth cost plus one level for each set. No function of a set
    exceeds its level, which equals the largest of them.

    **Arguments:**

    - `position`, `values`, `jacobian`, `lower`, `upper`, `active_tolerance`: as in `optimality`.
    - `gradient`: of the smooth part of the cost (variables).
    - `parts`: of each set the values and their derivatives (functions; functions × variables).

    **Returns:** the conditions, and the multipliers of the functions, at most 0; those of one set
    sum to -1.
    """
    rows, variables, levels = len(values), len(position), len(parts)
    blocks = [np.concatenate([jacobian, np.zeros((rows, levels))], axis=1)]
    above = []
    for place, (functions, slopes) in enumerate(parts):
        columns = np.zeros((len(functions), levels))
        columns[:, place] = -1.0
        blocks.append(np.concatenate([slopes, columns], axis=1))
        above.append(functions - np.max(functions))
    more = sum(map(len, above))
    judged = optimality(
        # A level inside of the box has no bounds.
        np.append(position, np.full(levels, 0.5)),
        np.append(gradient, np.ones(levels)),
        np.concatenate([values, *above]),
        np.concatenate(blocks),
        np.append(lower, np.full(more, -np.inf)),
        np.append(upper, np.zeros(more)),
        active_tolerance=active_tolerance,
    )
    design = replace(
        judged,
        multipliers=judged.multipliers[:rows],
        active=judged.active[:rows],
        bound_multipliers=judged.bound_multipliers[:variables],
        active_bounds=judged.active_bounds[:variables],
    )
    return design, judged.multipliers[rows:]


def _non_negative_least_squares(
    columns: np.ndarray, target: np.ndarray, constrained: bool
) -> np.ndarray:
    if columns.shape[1] == 0:
        return np.zeros(0)
    if not constrained:
        # Only bounds: their normals are unit vectors, so each multiplier is one gradient component.
        return np.maximum(columns.T @ target, 0.0)
    from scipy.optimize import nnls

    return nnls(columns, target)[0]
