"""Margins of findings as constraints of a search."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import equinox as eqx
import numpy as np

from ...fields import Scalar
from ...findings import Margin, evaluate_margins, margins_of, sources
from ...geometry import Severity
from ...mechanism import Mechanism
from ...programs import stored_facts
from ...quantities import Analysis, evaluate, find_quantity

#: Number of designs in the unit box that show whether a margin depends on the variables.
_PROBES = 3
#: Scale of the constraint row of a whole number [1].
WHOLE_SCALE = 0.1


@dataclass(frozen=True)
class MarginRow:
    """One margin with its limit; `place` is its index among the evaluated margins."""

    margin: Margin
    place: int
    limit: float

    @property
    def label(self) -> str:
        """Name of the finding, with its stage; a finding may have a warning and an error."""
        subject = f" of {self.margin.subject}" if self.margin.subject else ""
        severity = "" if self.limit == self.margin.error_limit else ", warning"
        return f"{self.margin.name}{subject}{severity} (stage {self.margin.stage})"

    @property
    def lower(self) -> float:
        """Lower limit for the search: the limit plus the reserve."""
        return self.limit + self.margin.reserve


@dataclass(frozen=True)
class MarginRows:
    """The margins of a design problem, sorted by how a search handles them."""

    #: Constraints.
    smooth: tuple[MarginRow, ...] = ()
    #: Numbers that must be whole and depend on the variables.
    integer: tuple[MarginRow, ...] = ()
    #: Violated margins that no variable changes, with their values.
    fixed: tuple[tuple[MarginRow, float], ...] = ()


class Respected(NamedTuple):
    """Which limits of `check` a search keeps; other ones need another program."""

    #: All sources of margins.
    origins: tuple[Any, ...]
    #: Severities of the limits.
    severities: tuple[Severity, ...]

    def limit(self, margin: Margin) -> float | None:
        """The highest limit of a margin that is kept; `None` without one, or a derivative.

        A warning between two limits, as that of `self_locking`, is no constraint.
        """
        limits = [limit for severity, limit in margin.levels if severity in self.severities]
        if not (limits and margin.smooth):
            return None
        highest = max(limits)
        between = any(
            severity not in self.severities and limit < highest for severity, limit in margin.levels
        )
        return margin.error_limit if between else highest

    def keeps(self, margin: Margin) -> bool:
        """Whether a margin is a constraint."""
        return self.limit(margin) is not None


def respected(*, warnings: bool) -> Respected:
    """The limits of all sources of margins that there are now: of errors, and of warnings, too."""
    return Respected(sources(), ("error", "warning") if warnings else ("error",))


#: Name, stage, subject and levels of a margin.
_Label: TypeAlias = tuple[str, int, str, Any]


def evaluated(
    mechanism: Mechanism,
    quantities: tuple[str, ...],
    speed: Scalar | None,
    load: Scalar | None,
    *,
    margins: Respected | None,
    after: Callable[[], object],
) -> tuple[dict[str, tuple[int, ...]], tuple[Margin, ...]]:
    """Shapes of quantities, and the margins for which the mechanism has data.

    **Arguments:**

    - `mechanism`, `quantities`, `speed`, `load`: as for `compute`.
    - `margins`: which margins there are, if any.
    - `after`: as for `stored_facts`.

    **Raises:** `MissingDataError` that names the quantity for which data are missing.
    """
    shapes, known = stored_facts(
        "shapes and margins",
        _shapes_and_margins,
        mechanism,
        quantities,
        speed,
        load,
        margins,
        # A name may be given to another quantity.
        by=tuple(map(find_quantity, quantities)),
        after=after,
    )
    if margins is None:
        return shapes, ()
    return shapes, tuple(one for one in margins_of(mechanism) if _label_of(one) in known)


def _label_of(margin: Margin) -> _Label:
    return margin.name, margin.stage, margin.subject, margin.levels


def _shapes_and_margins(
    mechanism: Mechanism,
    quantities: tuple[str, ...],
    speed: Scalar | None,
    load: Scalar | None,
    margins: Respected | None,
) -> tuple[dict[str, tuple[int, ...]], set[_Label]]:
    """From one trace; other sources have other margins."""
    known: set[_Label] = set()

    def try_all(traced, speed, load):
        analysis = Analysis(traced, speed, load)
        values = evaluate(analysis, quantities)
        if margins is not None:
            found = evaluate_margins(analysis, margins.keeps, details=False)
            pairs = zip(margins_of(traced), found, strict=True)
            known.update(_label_of(margin) for margin, numbers in pairs if numbers is not None)
        return values

    shapes = eqx.filter_eval_shape(try_all, mechanism, speed, load)
    return {name: shapes[name].shape for name in quantities}, known


def probe_positions(variables: int) -> np.ndarray:
    """A few designs spread over the unit box, the same in every run."""
    random = np.random.default_rng(12345)
    return 0.25 + 0.5 * random.random((_PROBES, variables))


def sorted_margins(margins: tuple[Margin, ...], values: np.ndarray, kept: Respected) -> MarginRows:
    """Sort margins by their values at several designs.

    Warnings that no variable changes are those of the file, and prevent no search.

    **Arguments:**

    - `margins`: the evaluated margins.
    - `values`: at several designs (designs × margins); NaN without data or meshing.
    - `kept`: the limits that the search keeps.
    """
    smooth, integer, fixed = [], [], []
    for place, margin in enumerate(margins):
        column = values[:, place]
        column = column[np.isfinite(column)]
        if not len(column):
            continue
        limit = kept.limit(margin)
        assert limit is not None
        row = MarginRow(margin, place, limit)
        # A margin that is independent of the variables has equal values to the last bit.
        if np.all(column == column[0]):
            value, limit = float(column[0]), margin.error_limit
            if limit is None:
                continue
            below = value <= limit if margin.strict else value < limit
            if below or (margin.integer and abs(value - round(value)) > 1e-6):
                fixed.append((MarginRow(margin, place, limit), value))
        elif margin.integer:
            integer.append(row)
            smooth.append(row)
        else:
            smooth.append(row)
    return MarginRows(tuple(smooth), tuple(integer), tuple(fixed))
