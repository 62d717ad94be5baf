"""A tolerance against the numbers that it moves."""

from collections.abc import Iterable

import numpy as np

from .._mechanism import Mechanism
from ..parts import Tolerance
from ._parameters import Parameter


def check_tolerance(
    mechanism: Mechanism, tolerance: Tolerance, parameters: Iterable[Parameter]
) -> None:
    """Refuse a tolerance of a whole number, or one whose limits are no possible values.

    **Arguments:**

    - `mechanism`: the mechanism, whose numbers are the nominal values.
    - `tolerance`: the tolerance.
    - `parameters`: the numbers of its name.

    **Raises:** `ValueError`.
    """
    owner = f"tolerance {tolerance.name!r}: "
    for parameter in parameters:
        if parameter.static:
            raise ValueError(f"{owner}a whole number has no tolerance; sweep over it instead")
        nominal = float(np.asarray(parameter.get(mechanism)))
        for side, deviation in (("lower", tolerance.lower), ("upper", tolerance.upper)):
            if not parameter.limit.admits(nominal + deviation):
                raise ValueError(
                    f"{owner}at its {side} limit {parameter.path} is out of range: it is "
                    f"{nominal + deviation:.6g} {parameter.unit} and must be "
                    f"{parameter.limit.allowed}"
                )
