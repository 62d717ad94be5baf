"""The axes of a sweep: checked values of parameters, and which of them are part of the program."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..fields import refuse_complex
from ..mechanism import (
    Mechanism,
    Parameter,
    check_independent,
    check_parameter,
    find_parameters,
)


@dataclass(frozen=True)
class Axis:
    """One axis of the plan, in SI units."""

    name: str
    values: np.ndarray
    unit: str
    description: str
    #: Whether values are whole numbers (`roller_count`).
    static: bool


def axes_of(
    mechanism: Mechanism, axes: Mapping[str, Iterable[Any]], fixed: Mapping[str, object]
) -> list[tuple[Axis, Parameter]]:
    """Check the axes of a sweep.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `axes`: values [SI] by the name of a parameter.
    - `fixed`: `speed` and `load` given in addition to the axes, or `None`.

    **Returns:** the axes, and the parameter of each.

    **Raises:** `UnknownNameError` for an unknown name; `ValueError` for no axes, two axes that
    set the same number, and values that are empty, not one-dimensional, not finite, or not whole
    where they have to be, or out of range there.
    """
    if not axes:
        raise ValueError("axes is empty; give at least one, as {name: values}")
    check_independent(mechanism, axes)
    checked = []
    for name, values in axes.items():
        parameter = find_parameters(mechanism, name)[0]
        _, _, field = parameter.path.partition("operating_point.")
        if fixed.get(field) is not None:
            raise ValueError(f"{field} is given and is also an axis of the sweep; remove one")
        array = _values(name, values, parameter.static)
        if parameter.static:
            # The limits of a whole number are known: it is refused before anything is computed.
            for value in np.unique(array):
                check_parameter(mechanism, name, value)
            array = array.astype(np.int64)
        axis = Axis(name, array, parameter.unit, parameter.description, parameter.static)
        checked.append((axis, parameter))
    return checked


def _values(name: str, values, static: bool) -> np.ndarray:
    refuse_complex(f"axis {name!r}", values)
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"axis {name!r} is not a list of numbers: {error}") from error
    if array.ndim != 1:
        raise ValueError(
            f"axis {name!r} has the shape {array.shape}; give a one-dimensional list of values"
        )
    if array.size == 0:
        raise ValueError(f"axis {name!r} is empty; give at least one value")
    if not np.isfinite(array).all():
        raise ValueError(f"axis {name!r} holds {array[~np.isfinite(array)][0]}; remove it")
    if not static:
        return array
    if (array != np.round(array)).any():
        first = array[array != np.round(array)][0]
        raise ValueError(f"axis {name!r} holds {first:g}; it must hold whole numbers")
    return array
