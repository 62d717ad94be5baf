"""Definition of an optimisation: variables, objective and constraints, as static data."""

from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True)
class Variable:
    """A design variable with its bounds [SI]."""

    name: str
    lower: float
    upper: float

    def __post_init__(self) -> None:
        if not self.lower < self.upper:
            raise ValueError(
                f"variable {self.name!r}: lower bound {self.lower} is not below upper bound "
                f"{self.upper}; swap or widen them"
            )


@dataclass(frozen=True)
class Objective:
    """One term of the objective: a quantity, its direction and its weight."""

    quantity: str
    sense: Literal["maximise", "minimise"] = "minimise"
    weight: float = 1.0


@dataclass(frozen=True)
class Constraint:
    """A limit on a quantity [SI]: `lower`, `upper`, or `equal`."""

    quantity: str
    lower: float | None = None
    upper: float | None = None
    equal: float | None = None

    def __post_init__(self) -> None:
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
class DesignProblem:
    """Variables, objectives and constraints, and settings of the search."""

    variables: tuple[Variable, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...] = field(default=())
    starts: int = 1
    seed: int = 0
    method: str = "auto"
