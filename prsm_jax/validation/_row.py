"""One published number beside the computed one, with a verdict that the numbers decide."""

import dataclasses
import decimal
from typing import Literal, TypeAlias, get_args

import numpy as np

Verdict: TypeAlias = Literal[
    "reproduced",
    "trend reproduced",
    "misprint explained",
    "differs because",
    "not reproduced",
]
#: What a row can say. "not reproduced" is what any of the first three turns into when the numbers
#: stop bearing it out; "differs because" is a known difference, with its reason in the note.
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)


@dataclasses.dataclass(frozen=True)
class Row:
    """A published number (or stated trend), the computed one, and the verdict.

    `tolerance` is the absolute difference that "reproduced" allows, in `unit`: half a unit of the
    last printed digit unless the note says otherwise. For "misprint explained" it is that of the
    corrected number. Trends are described in words and have neither difference nor tolerance.
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

    def to_dict(self) -> dict[str, float | str | None]:
        """The row as JSON types."""
        return dataclasses.asdict(self)


def half_unit(printed: str) -> float:
    """Half a unit of the last digit of a printed number: `half_unit("2.078e8")` is 5e4."""
    exponent = decimal.Decimal(printed).as_tuple().exponent
    if not isinstance(exponent, int):
        raise ValueError(f"the printed number is {printed!r}; it must be finite")
    return 0.5 * 10.0**exponent


def _relative(computed: float, published: float) -> float | None:
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

    - `item`: where it stands and what it is.
    - `published`: as printed; its digits set the tolerance.
    - `computed`: the toolkit's number, in `unit`.
    - `tolerance`: absolute difference allowed instead; the note then says why.
    """
    value, computed = float(published), float(computed)
    # A rounding of the sum itself must not decide a number that lies on the edge.
    allowed = half_unit(published) * (1 + 1e-9) if tolerance is None else float(tolerance)
    verdict: Verdict = "reproduced" if abs(computed - value) <= allowed else "not reproduced"
    difference = _relative(computed, value)
    return Row("", item, value, computed, difference, verdict, note, unit, allowed)


def at_most(item: str, published: str, computed: float, unit: str = "1", *, note: str = "") -> Row:
    """A printed upper bound; it counts as reproduced up to 5 % below it, where it says something.

    **Arguments:** as `number`.
    """
    value, computed = float(published), float(computed)
    allowed = 0.05 * abs(value)
    verdict: Verdict = "reproduced" if 0 <= value - computed <= allowed else "not reproduced"
    difference = _relative(computed, value)
    return Row("", item, value, computed, difference, verdict, note, unit, allowed)


def misprint(
    item: str, published: str, computed: float, unit: str = "1", *, correct: str, note: str
) -> Row:
    """A printed number that cannot stand as it is, where the toolkit gives the corrected one.

    **Arguments:**

    - `published`: as printed.
    - `correct`: what should have been printed, to as many digits; sets the tolerance.
    - `note`: the evidence.
    """
    row = number(item, correct, computed, unit, note=note)
    verdict: Verdict = "misprint explained" if row.verdict == "reproduced" else "not reproduced"
    value = float(published)
    difference = _relative(float(computed), value)
    return dataclasses.replace(
        row, published=value, relative_difference=difference, verdict=verdict
    )


def trend(item: str, published: str, computed: str, holds: bool | np.bool_, note: str = "") -> Row:
    """A statement in words that the computed curves bear out or not.

    **Arguments:**

    - `published`, `computed`: the statement, and what was found, with numbers.
    - `holds`: whether the computed numbers bear the statement out.
    """
    verdict: Verdict = "trend reproduced" if bool(holds) else "not reproduced"
    return Row("", item, published, computed, None, verdict, note)


def differs(
    item: str, published: str, computed: float | str, unit: str = "1", *, because: str
) -> Row:
    """A published number or statement from which the toolkit differs for a known reason."""
    try:
        value: float | str = float(published)
    except ValueError:
        value = published
    difference = None
    if isinstance(value, float) and not isinstance(computed, str):
        computed = float(computed)
        difference = _relative(computed, value)
    return Row("", item, value, computed, difference, "differs because", because, unit)
