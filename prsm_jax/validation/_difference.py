"""Rows that do not reproduce a printed number: the reason, bounds of the difference, and evidence.

Each builder decides its verdict by numbers: if a computed number or the evidence leaves its bounds,
the row becomes "not reproduced".
"""

import dataclasses

from ._row import Bounds, Row, Verdict, half_unit, number, relative


def _value(published: str) -> float | str:
    try:
        return float(published)
    except ValueError:
        return published


def _inside(value: float, bounds: Bounds) -> bool:
    low, high = bounds
    if not low <= high:
        raise ValueError(f"bounds are {bounds}; give the lower one first")
    # Allows for rounding where a bound is the number itself, such as a count.
    slack = 1e-12 * max(abs(low), abs(high))
    return bool(low - slack <= value <= high + slack)


def _bounded(
    verdict: Verdict,
    item: str,
    published: str,
    computed: float,
    unit: str,
    between: Bounds,
    note: str,
) -> Row:
    value, computed = _value(published), float(computed)
    difference = None if isinstance(value, str) else relative(computed, value)
    decided: Verdict = verdict if _inside(computed, between) else "not reproduced"
    return Row("", item, value, computed, difference, decided, note, unit, bounds=between)


def differs(
    item: str,
    published: str,
    computed: float,
    unit: str = "1",
    *,
    between: Bounds,
    because: str,
    evidence: float,
    evidence_between: Bounds,
) -> Row:
    """A published number or statement from which the toolkit differs, for a computed reason.

    **Arguments:**

    - `item`, `published`, `unit`: as `number`; a statement may be given in words.
    - `computed`: the toolkit's number.
    - `between`: bounds of the computed number.
    - `because`: the reason, and the meaning of `evidence`.
    - `evidence`: the result with the reason taken into account, or the number that supports it.
    - `evidence_between`: bounds of the evidence.
    """
    row = _bounded("differs because", item, published, computed, unit, between, because)
    evidence = float(evidence)
    decided = row.verdict if _inside(evidence, evidence_between) else "not reproduced"
    return dataclasses.replace(
        row, verdict=decided, evidence=evidence, evidence_bounds=evidence_between
    )


def unexplained(
    item: str, published: str, computed: float, unit: str = "1", *, between: Bounds, note: str
) -> Row:
    """A published number that the toolkit does not give; the reason cannot be computed.

    **Arguments:** as `differs`; `note` says what was tried.
    """
    return _bounded("unexplained", item, published, computed, unit, between, note)


def not_comparable(
    item: str, published: str, computed: float, unit: str = "1", *, between: Bounds, missing: str
) -> Row:
    """A published number that depends on data that the paper does not print.

    **Arguments:** as `differs`; `missing` names the data, and those used for the computed number.
    """
    return _bounded("not comparable", item, published, computed, unit, between, missing)


def fault(
    item: str, published: str, computed: float, unit: str = "1", *, own: float, note: str
) -> Row:
    """A printed number that follows, to its digits, from a fault of the paper.

    **Arguments:**

    - `computed`: the number with the fault.
    - `own`: the number of the toolkit's own model, which differs.
    - `note`: the fault.

    **Raises:** `ValueError` if the toolkit gives the printed number as well.
    """
    row = number(item, published, computed, unit, note=note)
    if abs(float(own) - float(published)) <= half_unit(published):
        raise ValueError(f"{item}: the toolkit gives {own} too; that is reproduced, not a fault")
    return dataclasses.replace(_if_equal("fault reproduced", row), own=float(own))


def _if_equal(verdict: Verdict, row: Row) -> Row:
    """A row of two numbers with the given verdict, if they agree."""
    decided: Verdict = verdict if row.verdict == "reproduced" else "not reproduced"
    return dataclasses.replace(row, verdict=decided)


def formula(
    item: str,
    value: str,
    computed: float,
    unit: str = "1",
    *,
    tolerance: float | None = None,
    note: str,
) -> Row:
    """A formula of a paper or a textbook, evaluated here as a second way, not a printed number.

    **Arguments:** as `number`; `value` is the formula's, to the digits that are compared.
    """
    row = number(item, value, computed, unit, tolerance=tolerance, note=note)
    return _if_equal("formula agrees", row)


def consistent(
    item: str,
    published: str,
    other: float,
    unit: str = "1",
    *,
    tolerance: float | None = None,
    note: str,
) -> Row:
    """Two statements of one paper that agree with each other; the toolkit is not involved.

    **Arguments:** as `number`; `other` follows from other printed data of the paper.
    """
    row = number(item, published, other, unit, tolerance=tolerance, note=note)
    return _if_equal("paper consistent", row)


def inconsistent(
    item: str, published: str, other: float, unit: str = "1", *, between: Bounds, note: str
) -> Row:
    """Two statements of one paper that contradict each other; the toolkit is not involved.

    **Arguments:** as `consistent`; `between`: bounds of `other`.
    """
    return _bounded("paper inconsistent", item, published, other, unit, between, note)
