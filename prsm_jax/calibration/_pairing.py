"""Pairing of measured with computed components, such as frequencies with modes."""

import jax.numpy as jnp
import numpy as np

from ..quantities import quantity_of
from ._problem import CalibrationProblem


def open_rows(problem: CalibrationProblem, unnumbered: set[str]) -> dict[str, np.ndarray]:
    """Rows of each quantity whose components have to be paired, by quantity."""
    owner = np.array([quantity_of(label).name for label in problem.components])
    of_row = owner[np.asarray(problem.component)]
    several = {name for name in unnumbered if (owner == name).sum() > 1}
    return {name: np.flatnonzero(of_row == name) for name in sorted(several)}


def paired(
    problem: CalibrationProblem, rows: dict[str, np.ndarray], computed: np.ndarray
) -> CalibrationProblem:
    """The problem with each measured value paired with a computed one of the same quantity.

    The pairs minimise the sum of |ln(measured/computed)| over the values measured at one point.
    Each component has at most one measured value.

    **Arguments:**

    - `problem`: the problem.
    - `rows`: from `open_rows`.
    - `computed`: all computed components, points × components.

    **Raises:** `ValueError` where more values were measured than there are components.
    """
    from scipy.optimize import linear_sum_assignment

    component = np.array(problem.component)
    point, measured = np.asarray(problem.point), np.asarray(problem.measured)
    owner = np.array([quantity_of(label).name for label in problem.components])
    for name, of_quantity in rows.items():
        columns = np.flatnonzero(owner == name)
        for place in np.unique(point[of_quantity]):
            here = of_quantity[point[of_quantity] == place]
            if len(here) > len(columns):
                raise ValueError(
                    f"{len(here)} values of {name} were measured under the same conditions, and "
                    f"the mechanism has {len(columns)}; remove those that belong to other modes, "
                    f"or give repeated measurements in a column per mode, such as {name}[2]"
                )
            values = computed[place, columns]
            tiny = np.finfo(float).tiny
            distance = np.abs(
                np.log(np.maximum(np.abs(measured[here]), tiny))[:, None]
                - np.log(np.maximum(np.abs(values), tiny))[None, :]
            )
            chosen = linear_sum_assignment(np.where(np.isfinite(distance), distance, 1e6))[1]
            component[here] = columns[chosen]
    return _with_components(problem, component)


def _with_components(problem: CalibrationProblem, component: np.ndarray) -> CalibrationProblem:
    import equinox as eqx

    same = jnp.asarray(component, problem.component.dtype)
    return eqx.tree_at(lambda p: p.component, problem, same)
