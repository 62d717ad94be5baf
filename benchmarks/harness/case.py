"""What a case is: problems, and for each its methods, its reference and its rivals."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

Kind = Literal["method", "approximation", "rival"]


@dataclass(frozen=True)
class Prepared:
    """A method at one setting, ready to be called again and again.

    - `call`: does the work once; jitted functions may return arrays that are not ready yet.
    - `instances`: how many instances (contacts, designs, trajectories) one call solves.
    - `read`: turns what `call` returns into named arrays, one row per instance, in the order of
      the reference. Not timed.
    - `note`: what a reader of the table should know (steps taken, for example). Not timed either.
    """

    call: Callable[[], Any]
    instances: int
    read: Callable[[Any], Mapping[str, Any]]
    note: Callable[[Any], str] = lambda result: ""


@dataclass(frozen=True)
class Method:
    """A way to solve a problem, at one or several settings.

    - `prepare`: builds the method at a setting. What it does is not timed: make the inputs and
      the jitted function here.
    - `settings`: tolerances, numbers of steps, batch sizes …; `(None,)` for a method without.
    - `kind`: `"method"` of this package, a cheap `"approximation"`, or a `"rival"` from outside.
    - `defaults`: those of the settings that a user of this package gets without asking.
    """

    name: str
    prepare: Callable[[Any], Prepared]
    settings: Sequence[Any] = (None,)
    setting_name: str = ""
    kind: Kind = "method"
    defaults: Sequence[Any] = ()


def rival(
    name: str,
    call: Callable[[], Any],
    instances: int,
    read: Callable[[Any], Mapping[str, Any]],
) -> Method:
    """A rival without a setting; the arguments are those of `Prepared`."""
    return Method(name, lambda _: Prepared(call, instances, read), kind="rival")


@dataclass(frozen=True)
class Reference:
    """High-precision values of one quantity, one row per instance; the first few are enough.

    `scale` divides the error; without it every value is its own scale (relative error). Histories
    that pass through zero need their own.
    """

    values: np.ndarray
    scale: np.ndarray | float | None = None


@dataclass(frozen=True)
class Problem:
    """One chart: methods that solve the same instances, measured in the same run.

    - `instance`: what is counted ("contact", "design", "trajectory").
    - `reference`: computes the reference values by quantity; the labels of the charts.
    - `reference_note`: where the reference comes from and how good it is.
    - `baseline`: name of the method that ratios of run time refer to, normally a rival.
    - `target`: the largest error that an answer may have; the report then compares the cheapest
      settings that reach it, because the same tolerance means another error for every solver.
    - `yardstick`: instances per second that this machine could reach, by a measurement apart.
    - `left_out`: rivals that belong here but did not run, and why; rows of the report all the same.
    """

    name: str
    title: str
    instance: str
    methods: Sequence[Method]
    reference: Callable[[], Mapping[str, Reference]]
    reference_note: str
    baseline: str
    yardstick: float | None = None
    target: float | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self):
        names = [method.name for method in self.methods]
        if len(set(names)) < len(names):
            raise ValueError(f"problem {self.name!r}: two methods share a name: {names}")
        if self.baseline not in names:
            raise ValueError(
                f"problem {self.name!r}: the baseline {self.baseline!r} is none of its methods "
                f"({', '.join(names)})"
            )


@dataclass(frozen=True)
class Case:
    """A subject with one or several problems."""

    name: str
    description: str
    problems: Sequence[Problem]
