"""One published number beside the computed one, with a verdict decided by the numbers."""

import dataclasses
import decimal
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

Verdict: TypeAlias = Literal[
    "reproduced",
    "trend reproduced",
    "formula agrees",
    "misprint explained",
    "fault reproduced",
    "paper consistent",
    "paper inconsistent",
    "differs because",
    "unexplained",
    "not comparable",
    "not reproduced",
]
#: Possible verdicts; `docs/published_tables.md` has the meaning of each. Any of the others becomes
#: "not reproduced" if the numbers no longer support it.
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
Bounds: TypeAlias = tuple[float, float]


@dataclasses.dataclass(frozen=True)
class Row:
    """A published number (or stated trend), the computed one, and the verdict.

    `tolerance` is the absolute difference that "reproduced" allows, in `unit`: half a unit of the
    last printed digit unless the note says otherwise. For "misprint explained" it is the tolerance
    of the corrected number. Trends are described in words, without difference and tolerance.
    """

    source: str
    item: str
    published: float | str
    computed: float | str
    relative_difference: float | None
    verdict: Verdict
    note: str
    unit: str = "1"
    tolerance: float | None = None
    #: Bounds of the computed number of a row that differs, in `unit`.
    bounds: Bounds | None = None
    #: The result with the reason of the note taken into account, or the number that supports the
    #: reason; the note says which. In `unit` if it is comparable with the published number.
    evidence: float | None = None
    #: Bounds of `evidence`.
    evidence_bounds: Bounds | None = None
    #: The number of the toolkit's own model, if `computed` follows from a fault of the paper.
    own: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """The row as JSON types."""
        row = dataclasses.asdict(self)
        pairs = ("bounds", "evidence_bounds")
        return row | {name: row[name] and list(row[name]) for name in pairs}


def half_unit(printed: str) -> float:
    """Half a unit of the last digit of a printed number: `half_unit("2.078e8")` is 5e4."""
    exponent = decimal.Decimal(printed).as_tuple().exponent
    if not isinstance(exponent, int):
        raise ValueError(f"the printed number is {printed!r}; it must be finite")
    return 0.5 * 10.0**exponent


def relative(computed: float, published: float) -> float | None:
    """Relative difference from a published number; `None` from zero."""
    return None if published == 0 else computed / published - 1


def number(
    item: str,
    published: str,
    computed: float,
    unit: str = "1",
    *,
    tolerance: float | None = None,
    note: str = "",
) -> Row:
    """A number that the paper prints and the toolkit should give.

    **Arguments:**

    - `item`: its place in the paper, and its name.
    - `published`: as printed; its digits set the tolerance.
    - `computed`: the toolkit's number, in `unit`.
    - `tolerance`: absolute difference allowed instead; the note then says why.
    """
    value, computed = float(published), float(computed)
    # Rounding errors of the difference must not decide a number at the edge of the tolerance.
    allowed = half_unit(published) * (1 + 1e-9) if tolerance is None else float(tolerance)
    verdict: Verdict = "reproduced" if abs(computed - value) <= allowed else "not reproduced"
    difference = relative(computed, value)
    return Row("", item, value, computed, difference, verdict, note, unit, allowed)


def at_most(item: str, published: str, computed: float, unit: str = "1", *, note: str = "") -> Row:
    """A printed upper bound; a number up to 5 % below it counts as reproduced.

    **Arguments:** as `number`.
    """
    value, computed = float(published), float(computed)
    allowed = 0.05 * abs(value)
    verdict: Verdict = "reproduced" if 0 <= value - computed <= allowed else "not reproduced"
    difference = relative(computed, value)
    return Row("", item, value, computed, difference, verdict, note, unit, allowed)


def misprint(
    item: str, published: str, computed: float, unit: str = "1", *, correct: str, note: str
) -> Row:
    """A printed number that is wrong, where the toolkit gives the corrected one.

    **Arguments:**

    - `published`: as printed.
    - `correct`: what should have been printed, to as many digits; sets the tolerance.
    - `note`: the evidence.

    **Raises:** `ValueError` if nothing is corrected.
    """
    if abs(float(correct) - float(published)) <= half_unit(correct):
        raise ValueError(f"{item}: {correct} does not correct {published}; give another verdict")
    row = number(item, correct, computed, unit, note=note)
    verdict: Verdict = "misprint explained" if row.verdict == "reproduced" else "not reproduced"
    value = float(published)
    difference = relative(float(computed), value)
    return dataclasses.replace(
        row, published=value, relative_difference=difference, verdict=verdict
    )


def trend(item: str, published: str, computed: str, holds: bool | np.bool_, note: str = "") -> Row:
    """A statement in words that the computed curves confirm or not.

    **Arguments:**

    - `published`, `computed`: the statement, and the computed result with numbers.
    - `holds`: whether the computed numbers confirm the statement.
    """
    verdict: Verdict = "trend reproduced" if bool(holds) else "not reproduced"
    return Row("", item, published, computed, None, verdict, note)
