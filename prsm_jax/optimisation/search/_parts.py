"""The programs with derivatives of a search: one, or two that are compiled beside each other."""

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from jaxtyping import Array

from ...programs import runs_one_verb
from ...quantities import by_friction

#: Outputs of a program as `outputs_at` returns them (with tolerances `None`), and derivatives.
Results: TypeAlias = tuple[Any, Sequence[Array]]
#: Places of quantities and margins among the inputs of `outputs_at`.
_QUANTITIES, _MARGINS = 2, 3


def parts_of(inputs: tuple[Any, ...]) -> tuple[tuple[Any, ...], ...]:
    """Inputs of `outputs_at` by program.

    A process that runs one verb compiles those of the friction, which share little with the others,
    as a program of their own: it is traced while the compiler is at work on the other one.
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


def joined(
    inputs: tuple[Any, ...], parts: Sequence[tuple[Any, ...]], results: Sequence[Results]
) -> Results:
    """Results of the parts in the order of one program.

    **Arguments:**

    - `inputs`: of `outputs_at`.
    - `parts`: `parts_of(inputs)`.
    - `results`: of each part.
    """
    if len(parts) == 1:
        return results[0]
    found: dict[str, tuple[Array, Array]] = {}
    margins: list[tuple[Array, Array]] = []
    for part, ((arrays, _), slopes) in zip(parts, results, strict=True):
        pairs = list(zip(arrays, slopes, strict=True))
        names = part[_QUANTITIES]
        found |= dict(zip(names, pairs[: len(names)], strict=True))
        margins += pairs[len(names) :]
    pairs = [*(found[name] for name in inputs[_QUANTITIES]), *margins]
    valid = np.all([valid for (_, valid), _ in results])
    return ([array for array, _ in pairs], valid), [slopes for _, slopes in pairs]
