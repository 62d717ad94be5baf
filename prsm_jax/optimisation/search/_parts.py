"""The programs with derivatives of a search: one, or two that are compiled beside each other."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...programs import runs_one_verb
from ...quantities import by_friction

#: Places of quantities and margins among the inputs of `outputs_at`.
_QUANTITIES, _MARGINS = 2, 3


def parts_of(inputs: tuple[Any, ...]) -> tuple[tuple[Any, ...], ...]:
    """Inputs of `outputs_at` by program.

    A process that runs one verb compiles the quantities with friction, which share little with the
    others, as a program of their own: it is traced while the compiler is at work on the other one.
    """
    quantities, scatter = inputs[_QUANTITIES], inputs[-1]
    friction, rest = by_friction(quantities)
    # With tolerances the outputs of every quantity are in three places.
    if scatter is not None or not friction or not rest or not runs_one_verb():
        return (inputs,)
    # The larger program first.
    return _with(inputs, rest, inputs[_MARGINS]), _with(inputs, friction, None)


def _with(inputs: tuple[Any, ...], quantities: tuple[str, ...], margins: Any) -> tuple[Any, ...]:
    return *inputs[:_QUANTITIES], quantities, margins, *inputs[_MARGINS + 1 :]


def order_of(
    inputs: tuple[Any, ...],
    parts: Sequence[tuple[Any, ...]],
    sizes: Mapping[str, int],
    margins: int,
) -> np.ndarray:
    """Where the numbers of one program stand among those of all parts, one part after the other.

    **Arguments:**

    - `inputs`: of `outputs_at`, without tolerances.
    - `parts`: `parts_of(inputs)`, at least two.
    - `sizes`: number of components by the name of a quantity.
    - `margins`: number of margins.
    """
    found: dict[str, np.ndarray] = {}
    of_margins, first = np.zeros(0, int), 0
    for part in parts:
        for name in part[_QUANTITIES]:
            found[name] = first + np.arange(sizes[name])
            first += sizes[name]
        if part[_MARGINS] is not None:
            of_margins = first + np.arange(margins)
            first += margins
    return np.concatenate([*(found[name] for name in inputs[_QUANTITIES]), of_margins])
