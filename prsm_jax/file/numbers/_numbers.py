"""Numbers between text and SI: read with their unit, written so that reading is exact.

Both directions go through exact fractions and round once, so the text `24 mm` is the double
nearest to 0.024, and seventeen digits are enough to restore any double in any unit.
"""

import math
import re
from decimal import Context, Decimal
from fractions import Fraction

from ...fields import Limit
from ...text import comma_in_number

_NUMBER = r"[+-]?(?:\d{1,40}(?:\.\d{0,40})?|\.\d{1,40})(?:[eE][+-]?\d{1,3})?(?![\d.])"
_PLAIN_NUMBER = re.compile(_NUMBER)
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*", re.DOTALL)
_LONGEST_TEXT = 200
_WIDE = Context(prec=60, Emax=10_000, Emin=-10_000)


def show(value) -> str:
    """A value as it stands in the file, shortened to fit in an error message."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "an array"
    if isinstance(value, int) and value.bit_length() > 200:
        return "a very large integer"
    text = f'"{value}"' if isinstance(value, str) else str(value)
    text = " ".join(text[:200].split())
    return text if len(text) <= 60 else text[:56] + '…"'


def _written_units(unit: str) -> tuple[str, ...]:
    from ._units import WRITTEN_UNITS

    return WRITTEN_UNITS.get(unit, ())


def wanted(unit: str | None) -> str:
    """What to give for a number of this SI unit (`None`: any), in words for an error message."""
    if unit is None:
        return 'give a string with a unit such as "10 mm", or a bare number in SI'
    if unit == "1":
        return "give a plain number"
    written = _written_units(unit)
    example = f'a string with a unit such as "10 {written[0]}"' if written else "a string"
    return f"give {example}, or a bare number in {unit}"


def _rounded(value: Fraction) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def read_quantity(text: str, unit: str | None) -> float:
    """The SI value of a number with a unit.

    **Arguments:**

    - `text`: such as `"24 mm"` or `"1500 rpm"`.
    - `unit`: the SI unit whose dimension it must have, or `None` for any.

    **Raises:** `ValueError` if the text is not a number with a unit, or has another dimension.
    """
    from ._units import kind_of, unit_factor

    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST_TEXT else None
    if match is None:
        raise ValueError(f"not a number with a unit; {wanted(unit)}")
    number, expression = match.groups()
    if comma := comma_in_number(text):
        raise ValueError(comma)
    try:
        factor, dimension = unit_factor(expression)
    except ValueError as error:
        raise ValueError(f"{error}; {wanted(unit)}") from error
    if unit is not None:
        expected = unit_factor(unit)[1]
        if dimension != expected:
            raise ValueError(
                f"wrong unit: {kind_of(dimension)} where {kind_of(expected)} is expected; "
                f"{wanted(unit)}"
            )
    value = _rounded(Fraction(number) * factor)
    return math.copysign(value, -1.0) if number.startswith("-") else value


def refuse_shares(value: object) -> None:
    """Refuse a deviation in per cent, which a reader takes for a share of the number.

    **Raises:** `ValueError` for a text that ends in `%`.
    """
    if isinstance(value, str) and value.rstrip().endswith("%"):
        raise ValueError(
            f"{value.strip()!r} does not say of what; give the deviation itself, such as 0.003"
        )


def read_number(value: object, unit: str | None, limit: Limit) -> float:
    """The SI value of a number from a file: bare, or a string with a unit.

    **Raises:** `ValueError` if it is of the wrong type, unit or sign, too large, or not finite.
    """
    if isinstance(value, str):
        number = read_quantity(value, unit)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        number = _rounded(Fraction(value)) if isinstance(value, int) else value
    else:
        raise ValueError(f"not a number; {wanted(unit)}")
    if not math.isfinite(number):
        raise ValueError("not a finite number")
    if not limit.admits(number):
        raise ValueError(f"must be {limit.words}")
    return number


def read_numbers(value: object, unit: str, limit: Limit, least: int = 1) -> tuple[float, ...]:
    """The SI values of a list of numbers, each bare or a string with a unit.

    **Raises:** `ValueError` if it is not a list, has fewer numbers than `least`, or `read_number`
    refuses a number in it.
    """
    if not isinstance(value, list) or len(value) < least:
        many = f"{'two' if least == 2 else least} or more " if least > 1 else ""
        raise ValueError(f"must be an array of {many}numbers; for each of them {wanted(unit)}")
    numbers = []
    for place, one in enumerate(value, start=1):
        try:
            numbers.append(read_number(one, unit, limit))
        except ValueError as error:
            raise ValueError(f"number {place} of the array, {show(one)}: {error}") from error
    return tuple(numbers)


def read_integer(value: object, limit: Limit) -> int:
    """A whole number from a file.

    **Raises:** `ValueError` if it is not an integer or outside the limit.
    """
    if isinstance(value, bool) or not isinstance(value, int) or not limit.admits(value):
        raise ValueError(f"must be {limit.words}")
    return value


def is_plain_number(text: str) -> bool:
    """Whether a text is a number without a unit."""
    return len(text) <= _LONGEST_TEXT and _PLAIN_NUMBER.fullmatch(text.strip()) is not None


def _decimal_text(value: Decimal) -> str:
    if -5 <= value.adjusted() < 9:
        return f"{value:f}"
    sign, digits, _ = value.as_tuple()
    mantissa = "".join(map(str, digits)).rstrip("0") or "0"
    mantissa = mantissa[0] + ("." + mantissa[1:] if len(mantissa) > 1 else "")
    return f"{'-' if sign else ''}{mantissa}e{value.adjusted()}"


def _in_unit(value: float, factor: Fraction) -> str | None:
    """The shortest decimal that, times the factor, rounds to exactly this value."""
    exact = Fraction(value) / factor
    wide = _WIDE.divide(Decimal(exact.numerator), Decimal(exact.denominator))
    for digits in range(1, 18):
        candidate = Context(prec=digits, Emax=10_000, Emin=-10_000).plus(wide)
        if _rounded(Fraction(candidate) * factor) == value:
            return _decimal_text(candidate.normalize(_WIDE))
    return None


def _length(text: str) -> int:
    # A power of ten is short, but harder to read.
    return len(text) + (4 if "e" in text else 0)


def write_number(value: float, unit: str) -> str:
    """A number as TOML: a string with the unit that needs the fewest digits, or bare.

    **Arguments:**

    - `value`: the SI value, finite.
    - `unit`: its SI unit.

    **Returns:** text that `read_number` turns into exactly the same double.
    """
    from ._units import unit_factor

    best = None
    for written in _written_units(unit):
        text = "-0" if math.copysign(1, value) < 0 else "0"
        if value != 0:
            text = _in_unit(value, unit_factor(written)[0])
        if text is not None and (best is None or _length(text) < _length(best[0])):
            best = (text, written)
    if best is None:
        return bare_number(value)
    text = f"{best[0]} {best[1]}"
    # The fallback should never be needed; the promise of an exact round trip is checked anyway.
    same = math.isfinite(value) and read_quantity(text, unit).hex() == value.hex()
    return f'"{text}"' if same else bare_number(value)


def bare_number(value: float) -> str:
    """A float as TOML, in the shortest form that reads back exactly."""
    if value == 0 or not math.isfinite(value):
        return repr(value)
    return _decimal_text(Decimal(repr(value)).normalize())


def round_in_unit(value: float, unit: str, digits: int) -> float:
    """An SI value rounded to `digits` significant digits in the unit in which it is written.

    **Arguments:**

    - `value`: the SI value, finite.
    - `unit`: its SI unit.
    - `digits`: significant digits.
    """
    from ._units import unit_factor

    written = _written_units(unit)
    factor = unit_factor(written[0])[0] if written else Fraction(1)
    exact = Fraction(value) / factor
    wide = _WIDE.divide(Decimal(exact.numerator), Decimal(exact.denominator))
    short = Context(prec=digits, Emax=10_000, Emin=-10_000).plus(wide)
    return _rounded(Fraction(short) * factor)
