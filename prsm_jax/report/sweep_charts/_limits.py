"""Limits of quantities over the designs of a sweep, and the best design within them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ...mechanism import Constraint
from ...optimisation import constraints_of
from ...text import display_unit, in_unit
from .._style import readable

Constraints: TypeAlias = Mapping[str, Any] | Iterable[Constraint] | None


@dataclass(frozen=True)
class QuantityLimit:
    """One limit of a quantity, and how far each design is beyond it.

    - `quantity`: its name in the data set.
    - `sign`: `"≤"`, `"≥"`, or `"="`, which no design of a sweep is expected to meet exactly: it
      has a line, and excludes no design.
    - `limit`: [SI].
    - `words`: the limit in a display unit, such as "max pressure ≤ 2100 MPa".
    - `excess`: the value minus the limit, or the limit minus the value for `"≥"` [SI]; with several
      components the largest of these. An array over the dimensions of the designs,
      NaN where a design has no value; the design is outside where it is positive.
    """

    quantity: str
    sign: str
    limit: float
    words: str
    excess: Any

    @property
    def excludes(self) -> bool:
        """Whether a design can be outside."""
        return self.sign != "="


def constraints_in(dataset: Any, constraints: Constraints) -> tuple[Constraint, ...]:
    """The constraints, whose quantities the data must have.

    **Arguments:**

    - `dataset`: from a sweep.
    - `constraints`: (lower, upper) [SI] by the name of a quantity, `None` for no limit, or one
      number for an equality; or constraints of a design problem.

    **Raises:** `ValueError` for limits that make no sense, or a quantity that the data lack.
    """
    checked = () if constraints is None else constraints_of(constraints)
    for one in checked:
        if one.quantity not in dataset:
            raise ValueError(
                f"the sweep has no {one.quantity!r}, which has a limit; add it to the quantities "
                "of the sweep, or leave it out of the constraints"
            )
    return checked


def limits_of(
    dataset: Any, constraints: Sequence[Constraint], designs: Sequence[str]
) -> tuple[QuantityLimit, ...]:
    """All limits, in the order of the constraints.

    **Arguments:**

    - `dataset`: from a sweep.
    - `constraints`: of quantities that it has.
    - `designs`: dimensions of the designs.
    """
    limits: list[QuantityLimit] = []
    for one in constraints:
        data = dataset[one.quantity]
        own = [d for d in data.dims if d not in designs]
        if one.equal is not None:
            # Each component has a line of its own.
            parts = data.stack(component=own) if own else data.expand_dims("component")
            for index in range(parts.sizes["component"]):
                part = parts.isel(component=index, drop=True)
                limits.append(_limit(data, "=", one.equal, part - one.equal))
        if one.upper is not None:
            worst = data.max(own, skipna=False)
            limits.append(_limit(data, "≤", one.upper, worst - one.upper))
        if one.lower is not None:
            worst = data.min(own, skipna=False)
            limits.append(_limit(data, "≥", one.lower, one.lower - worst))
    return tuple(limits)


def _limit(data: Any, sign: str, limit: float, excess: Any) -> QuantityLimit:
    name = str(data.name)
    shown = display_unit(str(data.attrs.get("units", "1")), limit, name)
    words = f"{readable(name)} {sign} {in_unit(limit, shown)}"
    return QuantityLimit(name, sign, limit, words, excess)


def outside_of(limits: Sequence[QuantityLimit], like: Any) -> Any:
    """Designs outside of one limit or more, over the dimensions of `like`, in their order."""
    outside = like.isnull() & False
    for one in limits:
        if one.excludes:
            outside = outside | (one.excess > 0)
    return outside.transpose(*like.dims)


def cut(limit: QuantityLimit, fixed: Mapping[str, int], like: Any) -> QuantityLimit:
    """The limit over the designs of a map, `like` gives its dimensions; others are fixed."""
    known = {d: i for d, i in fixed.items() if d in limit.excess.dims}
    excess = limit.excess.isel(known, drop=True)
    return replace(limit, excess=excess.broadcast_like(like).transpose(*like.dims))


class Best(NamedTuple):
    """The best design: its place along each dimension, its value [SI], and a description.

    If no design is within all limits, it is the best design outside of them; if all have an error
    of `check`, the best of these. The planes of a map then go through this design, but it is not
    `marked`, and the words say why.
    """

    place: tuple[int, ...]
    value: float
    words: str
    marked: bool


#: Of a sweep in which `check` finds an error in every design that did not fail.
_ALL_FLAWED = "no design without an error of prsm check"


def best_design(
    values: np.ndarray,
    flawed: np.ndarray,
    outside: np.ndarray | None,
    sense: Literal["maximise", "minimise"],
) -> Best:
    """The best of the designs that have a value, no error of `check`, and are within all limits.

    **Arguments:**

    - `values`: [SI], NaN for designs that failed.
    - `flawed`: designs with an error.
    - `outside`: designs outside of a limit; `None` if there are no limits.
    - `sense`: whether the best is the largest or the smallest.
    """
    known = np.isfinite(values)
    within = known if outside is None else known & ~outside
    words = "largest" if sense == "maximise" else "smallest"
    words += "" if outside is None else " within all limits"
    usable = within & ~flawed
    marked = bool(usable.any())
    if not marked:
        usable = known & ~flawed
        if not usable.any():
            usable, words = known, _ALL_FLAWED
        elif within.any():
            words = f"{_ALL_FLAWED} is within all limits"
        else:
            words = "no design is within all limits"
    pick = np.nanargmax if sense == "maximise" else np.nanargmin
    at = np.unravel_index(pick(np.where(usable, values, np.nan)), values.shape)
    place = tuple(int(i) for i in at)
    return Best(place, float(values[place]), words, marked)
