"""Pairing of measured with computed components, such as frequencies with modes."""

import jax.numpy as jnp
import numpy as np

from ..quantities import quantity_of
from ._measurements import Measurements, split_component
from ._problem import CalibrationProblem


def open_rows(problem: CalibrationProblem, data: Measurements) -> dict[str, np.ndarray]:
    """Rows of each quantity whose components have to be paired, by quantity.

    Those of a column with the number of a component have their pair.
    """
    owner = np.array([quantity_of(label).name for label in problem.components])
    of_row = owner[np.asarray(problem.component)]
    unnumbered = np.concatenate(
        [
            # A row for each value that was measured.
            np.full(int(np.isfinite(column).sum()), split_component(name)[1] is None)
            for name, column in data.values.items()
        ]
    )
    several = {name for name in of_row[unnumbered].tolist() if (owner == name).sum() > 1}
    return {name: np.flatnonzero((of_row == name) & unnumbered) for name in sorted(several)}


def paired(
    problem: CalibrationProblem, rows: dict[str, np.ndarray], computed: np.ndarray
) -> CalibrationProblem:
    """The problem with each measured value paired with a computed one of the same quantity.

    The pairs minimise the sum of |ln(measured/computed)| over the values measured at one point.
    Each component has at most one measured value, and none if a numbered column has values of it.

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
        numbered = np.setdiff1d(np.flatnonzero(owner[component] == name), of_quantity)
        for place in np.unique(point[of_quantity]):
            here = of_quantity[point[of_quantity] == place]
            taken = component[numbered[point[numbered] == place]]
            columns = np.setdiff1d(np.flatnonzero(owner == name), taken)
            if len(here) > len(columns):
                raise ValueError(
                    f"{len(here)} values of {name} were measured under the same conditions, and "
                    f"the mechanism has {len(columns)}{' others' if taken.size else ''}; remove "
                    "those that belong to other modes, "
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
