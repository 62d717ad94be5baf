"""Margins of findings as constraints: which of them a search has to respect, and by how much."""

from dataclasses import dataclass

import numpy as np

from ...findings import Margin

#: Designs in the unit box at which is seen whether a margin depends on the variables at all.
_PROBES = 3
#: A whole number must be met this closely [of one].
WHOLE_SCALE = 0.1


@dataclass(frozen=True)
class MarginRow:
    """One margin with an error limit; `place` is its place among those that are evaluated."""

    margin: Margin
    place: int

    @property
    def label(self) -> str:
        """Name of the finding, with its stage."""
        subject = f" of {self.margin.subject}" if self.margin.subject else ""
        return f"{self.margin.name}{subject} (stage {self.margin.stage})"

    @property
    def lower(self) -> float:
        """What the search keeps: the limit and the reserve."""
        assert self.margin.error_limit is not None
        return self.margin.error_limit + self.margin.reserve


@dataclass(frozen=True)
class MarginRows:
    """The margins of a design problem, sorted by what a search can do about them."""

    #: Constraints.
    smooth: tuple[MarginRow, ...] = ()
    #: Numbers that have to be whole and move with the variables.
    whole: tuple[MarginRow, ...] = ()
    #: Violated, and no variable changes them, with their value.
    fixed: tuple[tuple[MarginRow, float], ...] = ()


def is_constraint(margin: Margin) -> bool:
    """Whether a margin has a limit that makes a finding an error, and a derivative."""
    return margin.error_limit is not None and margin.smooth


def probe_positions(variables: int) -> np.ndarray:
    """A few designs spread over the unit box, the same in every run."""
    random = np.random.default_rng(12345)
    return 0.25 + 0.5 * random.random((_PROBES, variables))


def sorted_margins(margins: tuple[Margin, ...], values: np.ndarray) -> MarginRows:
    """Sort margins by their values at several designs.

    **Arguments:**

    - `margins`: those that were evaluated.
    - `values`: at several designs (designs × margins); NaN where one lacks data or does not mesh.
    """
    smooth, whole, fixed = [], [], []
    for place, margin in enumerate(margins):
        column = values[:, place]
        column = column[np.isfinite(column)]
        if not len(column):
            continue
        row = MarginRow(margin, place)
        # What the variables do not enter is computed from the same numbers: equal to the last bit.
        if np.all(column == column[0]):
            value, limit = float(column[0]), margin.error_limit
            assert limit is not None
            below = value <= limit if margin.strict else value < limit
            if below or (margin.whole and abs(value - round(value)) > 1e-6):
                fixed.append((row, value))
        elif margin.whole:
            whole.append(row)
            smooth.append(row)
        else:
            smooth.append(row)
    return MarginRows(tuple(smooth), tuple(whole), tuple(fixed))
