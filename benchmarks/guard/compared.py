"""When a measured error or ratio is worse than the stored one by more than noise."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

#: An error may grow by less than this. Another processor changes rounding by two or three.
ERROR_GROWTH = 10.0
#: Errors below are rounding, and count as this one.
ROUNDING = 1e-15
#: A ratio may fall by less than this.
RATIO_FALL = 2.0


@dataclass(frozen=True)
class Numbers:
    """What a benchmark stores, each number under the words that a failure names it with.

    - `errors`: largest error; infinite where no value is finite.
    - `not_finite`: how many values are not finite, where some are.
    - `ratios`: larger is better, such as the speed over that of a rival.
    - `costs`: smaller is better, each with a limit of its own.
    """

    errors: Mapping[str, float] = field(default_factory=dict)
    not_finite: Mapping[str, float] = field(default_factory=dict)
    ratios: Mapping[str, float] = field(default_factory=dict)
    costs: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Failure:
    """A number that is worse than it may be; `timed` where it depends on a clock."""

    name: str
    stored: float
    measured: float | None
    limit: float
    timed: bool

    def __str__(self):
        found = "nothing: it is not measured any more" if self.measured is None else (
            f"{self.measured:.3g}"
        )  # fmt: skip
        return f"{self.name}: stored {self.stored:.3g}, limit {self.limit:.3g}, measured {found}"


def compare(
    stored: Numbers,
    measured: Numbers,
    limits: Mapping[str, float] | None = None,
    *,
    clock: bool = True,
) -> list[Failure]:
    """What is worse than it may be.

    An error fails that is at least ten times the stored one, a count of values that are not finite
    if it is larger, a ratio at half of the stored one or below, or below its limit, a cost above
    its limit, and every stored number that is not measured any more. Numbers that are not stored
    are not judged.

    **Arguments:**

    - `stored`, `measured`: of the same benchmark.
    - `limits`: of every cost, and of those ratios that vary by more than two on a busy machine.
    - `clock`: whether to judge ratios and costs.

    **Raises:** `ValueError` for a stored cost without a limit.
    """
    limits = limits or {}
    unlimited = sorted(set(stored.costs) - set(limits))
    if unlimited:
        raise ValueError(f"no limit for the stored cost {', '.join(unlimited)}")
    found = []
    for name, value in stored.errors.items():
        limit = ERROR_GROWTH * max(value, ROUNDING)
        now = measured.errors.get(name)
        # Written so that NaN fails.
        if now is None or not (now < limit or math.isinf(value)):
            found.append(Failure(name, value, now, limit, timed=False))
    for name, now in measured.not_finite.items():
        before = stored.not_finite.get(name, 0)
        if now > before:
            found.append(Failure(f"{name}, values not finite", before, now, before, timed=False))
    if not clock:
        return found
    for name, value in stored.ratios.items():
        limit = limits.get(name, value / RATIO_FALL)
        now = measured.ratios.get(name)
        if now is None or not now > limit:
            found.append(Failure(name, value, now, limit, timed=now is not None))
    for name, value in stored.costs.items():
        now = measured.costs.get(name)
        if now is None or not now <= limits[name]:
            found.append(Failure(name, value, now, limits[name], timed=now is not None))
    return found


def recurring(first: Sequence[Failure], again: Sequence[Failure]) -> list[Failure]:
    """Failures of the first measurement, those by the clock only if the next has them as well."""
    names = {one.name for one in again}
    return [one for one in first if not one.timed or one.name in names]


def conservative(measurements: Sequence[Numbers]) -> Numbers:
    """The worst of several measurements, which is what to store."""
    return Numbers(
        errors=_merged([one.errors for one in measurements], max),
        not_finite=_merged([one.not_finite for one in measurements], max),
        ratios=_merged([one.ratios for one in measurements], min),
        costs=_merged([one.costs for one in measurements], max),
    )


def _merged(parts, worst):
    names = dict.fromkeys(name for part in parts for name in part)
    return {name: worst(part[name] for part in parts if name in part) for name in names}
