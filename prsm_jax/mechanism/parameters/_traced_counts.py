"""Numbers of rollers that a program takes as numbers, so that several share it."""

from collections.abc import Callable, Mapping
from typing import Any

import equinox as eqx

from ...fields import Scalar
from .._mechanism import Mechanism, Stage
from ._parameters import find_parameters


def with_traced_counts(mechanism: Mechanism, counts: Mapping[str, Scalar]) -> Mechanism:
    """The mechanism with traced numbers in place of numbers of rollers.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `counts`: numbers of `FEWEST_TRACED` or more, by names for which `stages_of_count` has stages.
    """
    for name, value in counts.items():
        for index in stages_of_count(mechanism, name):
            where = _count_of_stage(index)
            mechanism = eqx.tree_at(where, mechanism, value)
    return mechanism


def _count_of_stage(index: int) -> Callable[[Mechanism], Any]:
    return lambda mechanism: mechanism.stages[index].roller_count


def stages_of_count(mechanism: Mechanism, name: str) -> tuple[int, ...]:
    """Stages, from 0, whose number of rollers this name sets, if a trace may hold it as a number.

    Empty for other whole numbers, and where rollers differ: each of them has its own equations.
    """
    paths = {f"stage.{i + 1}.roller_count": i for i in range(len(mechanism.stages))}
    stages = [paths.get(parameter.path) for parameter in find_parameters(mechanism, name)]
    known = tuple(i for i in stages if i is not None and _equal_rollers(mechanism.stages[i]))
    return known if len(known) == len(stages) else ()


def _equal_rollers(stage: Stage) -> bool:
    return not stage.unequal_roller and not stage.rollers_carry_otherwise
