"""Definition of an optimisation: variables, objective and constraints, as static data."""

import itertools
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...fields import Limit, check_fields, choice

_STARTS = Limit(1.0, 10_000.0, "a whole number from 1 to 10000", True, True)
_POINTS = Limit(3.0, 1000.0, "a whole number from 3 to 1000", True, True)
_SIGMAS = Limit(0.0, 10.0, "above 0 and at most 10", False, True)
#: In place of operating points: the phases of the mechanism's duty cycle.
DUTY_CYCLE = "duty_cycle"
_SEED = Limit(0.0, 2.0**32 - 1, "a whole number from 0 to 4294967295", True, True)


@dataclass(frozen=True)
class Variable:
    """A design variable with its bounds [SI]."""

    name: str = choice("name of a parameter")
    lower: float = choice("lower bound")
    upper: float = choice("upper bound")

    def __post_init__(self) -> None:
        if not self.lower < self.upper:
            raise ValueError(
                f"variable {self.name!r}: lower bound {self.lower} is not below upper bound "
                f"{self.upper}; swap or widen them"
            )


@dataclass(frozen=True)
class Objective:
    """One term of the objective: a quantity, its direction, its weight, and how points count.

    With several operating points the term is the mean of the quantity over them, by their shares,
    or its worst value at any of them.
    """

    quantity: str = choice("name of a quantity")
    sense: Literal["maximise", "minimise"] = choice(
        'direction: "maximise" or "minimise"', default="minimise"
    )
    weight: float = choice("weight in the sum of values in SI units", default=1.0)
    over: Literal["mean", "worst"] = choice(
        'over several operating points: "mean" by their shares, or "worst" of them', default="mean"
    )

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class Constraint:
    """A limit on a quantity [SI]: `lower`, `upper`, or `equal`."""

    quantity: str = choice("name of a quantity")
    lower: float | None = choice("lower limit", default=None)
    upper: float | None = choice("upper limit", default=None)
    equal: float | None = choice("value", default=None)

    def __post_init__(self) -> None:
        for name in ("lower", "upper", "equal"):
            value = getattr(self, name)
            if value != value:
                raise ValueError(
                    f"constraint on {self.quantity!r}: {name} is nan; give a number, or None for "
                    "no limit"
                )
        if self.equal is None and self.lower is None and self.upper is None:
            raise ValueError(
                f"constraint on {self.quantity!r} has no limit; give lower, upper or equal"
            )
        if self.equal is not None and not (self.lower is None and self.upper is None):
            raise ValueError(
                f"constraint on {self.quantity!r} has equal and a bound; give one or the other"
            )
        if self.lower is not None and self.upper is not None and self.lower > self.upper:
            raise ValueError(
                f"constraint on {self.quantity!r}: lower limit {self.lower} is above upper limit "
                f"{self.upper}; swap or widen them"
            )


@dataclass(frozen=True)
class Choice:
    """Values of a parameter of which one is chosen [SI]; of whole numbers, too."""

    name: str = choice("name of a parameter")
    values: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.values:
            raise ValueError(f"choice {self.name!r} has no values; list at least one")
        for value in self.values:
            if not math.isfinite(value):
                raise ValueError(f"choice {self.name!r} lists {value}; give finite numbers")
        if len(set(self.values)) < len(self.values):
            raise ValueError(f"choice {self.name!r} lists a value twice; leave one out")


@dataclass(frozen=True)
class OperatingCase:
    """A speed and a load at which a design is judged, and its share in the mean [rad/s, N, 1]."""

    speed: float = choice("speed of the body that turns")
    load: float = choice("axial load")
    share: float = choice("share in the mean", default=1.0)

    def __post_init__(self) -> None:
        for name in ("speed", "load", "share"):
            if not math.isfinite(getattr(self, name)):
                raise ValueError(
                    f"operating point: {name} is {getattr(self, name)}; give a finite number"
                )
        if self.share <= 0:
            raise ValueError(f"operating point: share is {self.share}; it must be positive")


@dataclass(frozen=True)
class DesignProblem:
    """Variables, objectives and constraints, choices, and settings of the search.

    With `nut_speed` [m/s] the screw turns as fast as each design needs for this speed of the nut;
    otherwise its speed is that of the operating point. With `operating_points` each objective is
    the mean over them by their shares, or the worst of them, and each constraint holds at every
    one; `"duty_cycle"` stands for the phases of the mechanism's duty cycle, with their durations as
    shares. With `tolerance_sigmas` each objective and each limit is taken so many standard
    deviations to the worse side of the mean. `method_options` are fields of the object for which
    `method` stands, as pairs of name and value; the method refuses those that it does not take.
    With `avoid_warnings` warnings of `check` are constraints, too, as far as they depend on the
    variables.
    """

    variables: tuple[Variable, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...] = ()
    starts: int = choice("number of searches", default=1, limit=_STARTS)
    seed: int = choice("seed of their starting points", default=0, limit=_SEED)
    method: str = choice("method of the search", default="auto")
    points: int = choice("number of points of a front", default=20, limit=_POINTS)
    choices: tuple[Choice, ...] = ()
    nut_speed: float | None = choice("axial speed of the last nut", default=None)
    operating_points: tuple[OperatingCase, ...] | Literal["duty_cycle"] = ()
    tolerance_sigmas: float | None = choice(
        "standard deviations by which tolerances worsen objectives and limits", default=None
    )
    method_options: tuple[tuple[str, float | int], ...] = ()
    avoid_warnings: bool = choice(
        "whether warnings of `prsm check` are constraints, as its errors are", default=False
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if self.nut_speed is not None and not 0 < self.nut_speed < math.inf:
            raise ValueError(f"nut_speed is {self.nut_speed} m/s; it must be positive")
        if isinstance(self.operating_points, str) and self.operating_points != DUTY_CYCLE:
            raise ValueError(
                f'operating_points is {self.operating_points!r}; write "{DUTY_CYCLE}", or give '
                "(speed, load, share) for each"
            )
        if self.tolerance_sigmas is not None and not _SIGMAS.admits(self.tolerance_sigmas):
            raise ValueError(
                f"tolerance_sigmas is {self.tolerance_sigmas}; it must be {_SIGMAS.allowed}"
            )
        names = [name for name, _ in self.method_options]
        if len(set(names)) < len(names):
            raise ValueError(f"method_options are {', '.join(names)}; give each one once")
        if self.nut_speed is not None and self.operating_points:
            raise ValueError(
                "nut_speed and operating_points are both given, and both set the speed of the "
                "screw; give one"
            )


def operating_range(
    speeds: tuple[float, float], loads: tuple[float, float], points: int = 3
) -> tuple[tuple[float, float], ...]:
    """Operating points on a grid over a range of speeds and loads, its corners included.

    **Arguments:**

    - `speeds`, `loads`: least and largest [rad/s, N]; two equal numbers give one.
    - `points`: in each direction.

    **Returns:** (speed, load) of each, for `operating_points`.

    **Raises:** `ValueError` for a range in the wrong order, or fewer than two points.
    """
    if points < 2:
        raise ValueError(f"points is {points}; it must be at least 2")
    axes: list[list[float]] = []
    for name, (low, high) in (("speeds", speeds), ("loads", loads)):
        if not low <= high:
            raise ValueError(f"{name} are ({low}, {high}); give the lower one first")
        axes.append([low] if low == high else np.linspace(low, high, points).tolist())
    return tuple(itertools.product(*axes))  # pyright: ignore[reportReturnType]
