"""The numbers that tolerances move, and how far."""

import dataclasses
from collections.abc import Iterable

import numpy as np

from .._mechanism import Mechanism
from ..parts import Tolerance
from ._check_tolerance import check_tolerance
from ._parameters import find_parameters
from ._set_parameters import check_independent


@dataclasses.dataclass(frozen=True)
class ToleranceZones:
    """Tolerances of a mechanism and the numbers that they move.

    Each tolerance has one standardised deviation with mean 0 and variance 1; all are independent.
    A name that applies to several stages moves their numbers by the same deviation.

    - `tolerances`: the tolerances.
    - `paths`: full names of the numbers.
    - `nominal`: their values [SI].
    - `offsets`: from the nominal values to the middle of the tolerance zones [SI].
    - `directions`: change of the numbers for one standard deviation of each tolerance [SI],
      tolerances × numbers.
    - `units`: SI unit of each tolerance.
    """

    tolerances: tuple[Tolerance, ...]
    paths: tuple[str, ...]
    nominal: np.ndarray
    offsets: np.ndarray
    directions: np.ndarray
    units: tuple[str, ...]


def tolerance_zones(
    mechanism: Mechanism, tolerances: Iterable[Tolerance] | None = None
) -> ToleranceZones:
    """Check tolerances and look up their numbers.

    **Arguments:**

    - `mechanism`: the mechanism, whose numbers are the nominal values.
    - `tolerances`: in place of the mechanism's own.

    **Raises:** `ValueError` without tolerances, for a whole number, a limit out of range, or two
    that set the same number; `UnknownNameError` for an unknown name.
    """
    chosen = tuple((mechanism.tolerances or ()) if tolerances is None else tolerances)
    if not chosen:
        raise ValueError(
            "the mechanism has no tolerances; give tolerances, or a [tolerances] table in its file "
            'such as lead = "±0.02 mm"'
        )
    paths: list[str] = []
    nominal: list[float] = []
    units: list[str] = []
    owner: list[int] = []
    for index, one in enumerate(chosen):
        parameters = find_parameters(mechanism, one.name)
        units.append(parameters[0].unit)
        check_tolerance(mechanism, one, parameters)
        for parameter in parameters:
            paths.append(parameter.path)
            nominal.append(float(np.asarray(parameter.get(mechanism))))
            owner.append(index)
    check_independent(mechanism, [one.name for one in chosen])
    directions = np.zeros((len(chosen), len(paths)))
    for number, index in enumerate(owner):
        directions[index, number] = chosen[index].standard_deviation
    offsets = np.array([chosen[index].middle for index in owner])
    return ToleranceZones(
        chosen, tuple(paths), np.array(nominal), offsets, directions, tuple(units)
    )
