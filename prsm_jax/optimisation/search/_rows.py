"""The evaluated numbers as objectives and constraints of a search."""

from collections.abc import Iterator

import numpy as np

from ...mechanism import Constraint, DesignProblem, Objective
from ...quantities import component_names, find_quantity
from ._margin_rows import MarginRows

#: Sides of the mean on which tolerances put a value, in the order of the evaluated numbers.
_SIDES = ("+", "-")


def _sides_of(
    constraint: Constraint, scattered: bool
) -> Iterator[tuple[str, float | None, float | None]]:
    """The side of the mean on which each limit holds, and the limits there."""
    if constraint.equal is not None:
        yield "", constraint.equal, constraint.equal
    elif not scattered:
        yield "", constraint.lower, constraint.upper
    else:
        if constraint.upper is not None:
            yield _SIDES[0], None, constraint.upper
        if constraint.lower is not None:
            yield _SIDES[1], constraint.lower, None


class Rows:
    """The constraints as rows `lower <= value <= upper`, one per component of a quantity.

    The first `explicit` rows are the constraints of the problem; those of the margins follow. With
    tolerances an upper limit holds for the mean plus `tolerance_sigmas` standard deviations, a
    lower limit for the mean minus these, and an equality for the mean.
    """

    def __init__(self, problem: DesignProblem, shapes: dict[str, tuple[int, ...]], margins: int):
        cases = problem.operating_points
        assert not isinstance(cases, str), "the phases of the duty cycle have been looked up"
        shares = np.array([one.share for one in cases] or [1.0])
        #: Share of each operating point in the mean.
        self.shares: np.ndarray = shares / shares.sum()
        for term in problem.objectives:
            if int(np.prod(shapes[term.quantity])) != 1:
                raise ValueError(
                    f"objective {term.quantity!r} has {int(np.prod(shapes[term.quantity]))} "
                    "components; an objective must be one number"
                )
            if term.over == "worst" and not cases:
                raise ValueError(
                    f"objective {term.quantity!r} is the worst over operating points, and the "
                    'problem has none; give operating_points, or over = "mean"'
                )
        if cases:
            # The operating point is the first index of a component.
            shapes = {name: (len(shares), *shape) for name, shape in shapes.items()}
        sigmas = problem.tolerance_sigmas
        sides = ("",) if sigmas is None else ("", *_SIDES)
        keys = [(name, side) for side in sides for name in shapes]
        first = np.cumsum([0, *(int(np.prod(shapes[name])) for name, _ in keys)])
        self._place: dict[tuple[str, str], int] = dict(zip(keys, map(int, first[:-1]), strict=True))
        self._scattered = sigmas is not None
        self.names: list[str] = []
        self.units: list[str] = []
        index, lower, upper, equality = [], [], [], []
        for constraint in problem.constraints:
            name = constraint.quantity
            for side, low, high in _sides_of(constraint, self._scattered):
                for offset, label in enumerate(component_names(name, shapes[name])):
                    self.names.append(f"{label} {side} {sigmas:g} sigma" if side else label)
                    self.units.append(find_quantity(name).unit)
                    index.append(self._place[name, side] + offset)
                    equality.append(constraint.equal is not None)
                    lower.append(-np.inf if low is None else low)
                    upper.append(np.inf if high is None else high)
        self.index: np.ndarray = np.array(index, dtype=int)
        self.lower: np.ndarray = np.array(lower, dtype=float)
        self.upper: np.ndarray = np.array(upper, dtype=float)
        self.equality: np.ndarray = np.array(equality, dtype=bool)
        self.explicit: int = len(self.names)
        self.first_margin: int = int(first[-1])
        self.weights: np.ndarray = np.zeros(int(first[-1]) + margins)
        #: For each worst-case objective the weights of its cost at every operating point.
        self.worst: list[np.ndarray] = []
        for term in problem.objectives:
            weight = term.weight * (-1.0 if term.sense == "maximise" else 1.0)
            if term.over == "worst":
                self.worst.append(weight * self._at_each_point(term))
            else:
                self.weights += weight * self.mean_of(term)

    def _at_each_point(self, term: Objective) -> np.ndarray:
        """Weights of all values in an objective, for each operating point."""
        side = ""
        if self._scattered:
            higher_is_worse = (term.sense == "minimise") == (term.weight > 0)
            side = _SIDES[0] if higher_is_worse else _SIDES[1]
        weights = np.zeros((len(self.shares), len(self.weights)))
        points = np.arange(len(self.shares))
        weights[points, self._place[term.quantity, side] + points] = 1.0
        return weights

    def mean_of(self, term: Objective) -> np.ndarray:
        """Weights of all values in an objective: its mean over the operating points."""
        return self.shares @ self._at_each_point(term)

    def add(self, rows: MarginRows) -> None:
        """Append the margins that a search has to respect."""
        added = rows.smooth
        self.names += [row.label for row in added]
        self.units += [row.margin.unit for row in added]
        places = [self.first_margin + row.place for row in added]
        self.index = np.concatenate([self.index, np.array(places, dtype=int)])
        self.lower = np.concatenate([self.lower, [row.lower for row in added]])
        self.upper = np.concatenate([self.upper, np.full(len(added), np.inf)])
        self.equality = np.concatenate([self.equality, np.zeros(len(added), dtype=bool)])

    def fix(self, label: str, value: float | None, lower: float) -> None:
        """Fix a margin at a whole number, or release it (`None`)."""
        row = self.names.index(label, self.explicit)
        self.equality[row] = value is not None
        self.lower[row] = lower if value is None else value
        self.upper[row] = np.inf if value is None else value
