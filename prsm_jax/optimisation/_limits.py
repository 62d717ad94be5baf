"""The limits of the design problem beside the values of a design, for reports and the studio."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import jax.numpy as jnp
import numpy as np

from .._errors import UnknownNameError
from ..findings import Status
from ..mechanism import Constraint, DesignProblem, Mechanism, of_one_known_design
from ..quantities import (
    REASONS,
    available_quantities,
    component_names,
    compute,
    compute_coded,
    find_quantity,
)
from ._problem import robust

#: A limit that is broken by less, relative to it, is kept: a search ends within 1e-6 of an active
#: limit, its file changes constraints by up to 1e-6, and the studio takes variables of six digits.
LIMIT_ROOM = 1e-5
#: What stands for a limit of 0 in this room, by SI unit: a nanometre and a hundredth per mm.
_ZERO = {"m": 1e-3}
#: Codes with which values can be used, each by itself.
_USABLE = tuple(REASONS.index(name) for name in ("successful", "overlapping_rollers", "not_finite"))


@dataclass(frozen=True)
class LimitReading:
    """A limit of the `[optimise]` table beside its value [SI].

    - `quantity`: name, with a number in brackets for a component.
    - `margin`: distance from the limit as a share of it (from a limit of 0 in its unit), negative
      where it is broken.
    - `verdict`: `"pass"` within the tolerance of a search; `"not evaluated"`, with the value NaN,
      where the mechanism lacks data for the quantity or its analysis has no result.
    - `equal`: whether the value must be equal to the limit.
    - `speed`, `load`: operating point of the table at which the limit is nearest or broken most
      [rad/s, N]; `None` for that of the mechanism.
    """

    quantity: str
    unit: str
    value: float
    limit: float
    at_most: bool
    margin: float
    verdict: Literal["pass", "fail", "not evaluated"]
    equal: bool = False
    speed: float | None = None
    load: float | None = None

    @property
    def sense(self) -> str:
        """The limit's kind in words: `"at most"`, `"at least"` or `"equal to"`."""
        return "equal to" if self.equal else "at most" if self.at_most else "at least"

    def to_dict(self) -> dict[str, Any]:
        """Everything by the keys of the JSON."""
        return dict(vars(self))


class _Point(NamedTuple):
    """An operating point and the values there by component; those without a value are missing."""

    speed: float | None
    load: float | None
    values: Mapping[str, float]


@of_one_known_design
def limit_readings(
    mechanism: Mechanism, known: Mapping[str, float] | None = None
) -> tuple[LimitReading, ...]:
    """The limits of a mechanism's design problem beside the values of the present design.

    Values are those at the operating points of the problem, of which the one with the least margin
    is given, at its nut speed, or else at the operating point of the mechanism. Tolerances are left
    out: values are those of the nominal design, also where the search worsens them by standard
    deviations. Needs concrete numbers.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `known`: values at the operating point of the mechanism [SI] by the names of quantities and
      their components, in place of an evaluation; one that is missing has no value.

    **Returns:** a reading for every limit and component; none, and nothing is evaluated, without
    constraints.

    **Raises:** `ValueError` for operating points that are not valid, or a missing duty cycle.
    """
    problem = mechanism.design_problem
    if problem is None or not problem.constraints:
        return ()
    problem = robust(mechanism, problem, None, None, None)
    if known is None or problem.operating_points or problem.nut_speed is not None:
        points = list(_evaluated(mechanism, problem))
    else:
        points = [_Point(None, None, known)]
    return tuple(
        one for constraint in problem.constraints for one in _readings_of(constraint, points)
    )


def with_limits(status: Status, limits: Iterable[LimitReading] | None) -> Status:
    """The status of a design with the limits of its design problem: a broken one is a failure.

    **Arguments:**

    - `status`: that of checks and findings.
    - `limits`: from `limit_readings`; `None`, where they could not be read, is a warning, as is one
      that was not evaluated.
    """
    verdicts = {"not evaluated"} if limits is None else {one.verdict for one in limits}
    if "fail" in verdicts:
        return "fail"
    if "not evaluated" in verdicts:
        return "fail" if status == "fail" else "warning"
    return "pass" if status == "no checks" and "pass" in verdicts else status


def _evaluated(mechanism: Mechanism, problem: DesignProblem) -> Iterator[_Point]:
    """Every operating point of the problem, with the values that can be used."""
    cases = [(one.speed, one.load) for one in problem.operating_points] or [(None, None)]  # pyright: ignore[reportAttributeAccessIssue]
    names = tuple(dict.fromkeys(one.quantity for one in problem.constraints if _is_known(one)))
    for speed, load in cases:
        if problem.nut_speed is not None:
            one = compute(mechanism, ("nut_speed",), speed=jnp.ones(()))["nut_speed"]
            speed = problem.nut_speed / float(one)
        yield _Point(speed, load, _values_at(mechanism, names, _number(speed), _number(load)))


def _values_at(
    mechanism: Mechanism, names: tuple[str, ...], speed: Any, load: Any
) -> dict[str, float]:
    """Values of quantities by component, as far as the mechanism has their data; none unless valid.

    Outside of a trace; the program is compiled once for all operating points.
    """
    found = available_quantities(mechanism, names, speed=speed, load=load)
    if not found:
        return {}
    values, code = compute_coded(mechanism, found, speed=speed, load=load)
    if int(code) not in _USABLE:
        return {}
    return {
        label: number
        for name, value in values.items()
        for label, number in zip(
            component_names(name, np.shape(value)), np.ravel(value).tolist(), strict=True
        )
    }


def _number(value: float | None) -> Any:
    return None if value is None else jnp.asarray(float(value))


def _is_known(constraint: Constraint) -> bool:
    """Whether the catalogue has the quantity; one of a plugin that is not loaded is missing."""
    try:
        find_quantity(constraint.quantity)
    except UnknownNameError:
        return False
    return True


def _readings_of(constraint: Constraint, points: list[_Point]) -> Iterator[LimitReading]:
    name = constraint.quantity
    known = dict.fromkeys(label for point in points for label in point.values)
    for label in [one for one in known if one.partition("[")[0] == name] or [name]:
        for side in ("lower", "upper", "equal"):
            limit = getattr(constraint, side)
            if limit is not None and math.isfinite(limit):
                every = [_reading(constraint, side, label, point) for point in points]
                yield min(every, key=_rank)


def limit_scale(constraint: Constraint, unit: str) -> float:
    """The magnitude [SI] to which the violation of a limit is relative.

    As in a search, a lower and an upper limit have the scale of the larger one; a limit of 0 has
    that of a typical value in its unit.
    """
    limits = (constraint.lower, constraint.upper, constraint.equal)
    finite = [abs(one) for one in limits if one is not None and math.isfinite(one)]
    return max(finite, default=0.0) or _ZERO.get(unit, 1.0)


def _rank(one: LimitReading) -> tuple[int, float]:
    """Smaller for the more serious verdict, and of two equal ones for the smaller margin."""
    order = ("fail", "not evaluated", "pass").index(one.verdict)
    return order, -math.inf if math.isnan(one.margin) else one.margin


def _reading(constraint: Constraint, side: str, label: str, point: _Point) -> LimitReading:
    unit = find_quantity(constraint.quantity).unit if _is_known(constraint) else "1"
    limit, value = float(getattr(constraint, side)), point.values.get(label, math.nan)
    at_most, equal = side != "lower", side == "equal"
    distance = -abs(value - limit) if equal else limit - value if at_most else value - limit
    # NaN, a value that does not exist, does not keep its limit.
    verdict = "pass" if distance >= -LIMIT_ROOM * limit_scale(constraint, unit) else "fail"
    return LimitReading(
        label,
        unit,
        value,
        limit,
        at_most,
        distance / abs(limit) if limit else distance,
        verdict if label in point.values else "not evaluated",
        equal,
        point.speed,
        point.load,
    )
