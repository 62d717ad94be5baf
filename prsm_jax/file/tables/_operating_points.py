"""Operating points of the `[optimise]` table: rows, a range, or the word for the duty cycle."""

from typing import Any

from ...fields import ANY, Limit
from ...mechanism import DUTY_CYCLE, Mechanism, OperatingCase, operating_range
from ..numbers import Misplaced, Place, read_integer, read_number, read_numbers
from ._table import Key, plain, read_keys

#: Keys that give operating points, of which a table has at most one.
_KEYS = ("operating_point", "operating_points", "operating_range")
_POINTS = Limit(2.0, 100.0, "a whole number from 2 to 100", True, True)


def _pair(value: object, unit: str) -> tuple[float, float]:
    """Least and largest value, or one number that is both."""
    if not isinstance(value, list):
        number = read_number(value, unit, ANY)
        return number, number
    numbers = read_numbers(value, unit, ANY, least=2)
    if len(numbers) != 2:
        raise ValueError("must be two numbers, the lower one first, or one")
    return numbers[0], numbers[1]


_RANGE = {
    "speeds": Key(plain(_pair, "rad/s"), 'least and largest speed, as ["500 rpm", "1000 rpm"]'),
    "loads": Key(plain(_pair, "N"), 'least and largest load, as ["5 kN", "9 kN"]'),
    "points": Key(plain(read_integer, _POINTS)),
}


def read_range(value: Any, place: Place) -> tuple[OperatingCase, ...]:
    """The operating points of a range.

    **Raises:** `Misplaced` for a range that is none.
    """
    arguments = read_keys(value, place, _RANGE)
    try:
        return tuple(OperatingCase(*one) for one in operating_range(**arguments))
    except ValueError as error:
        raise Misplaced((place, str(error))) from error


def operating_points_of(table: dict[str, Any], mechanism: Mechanism) -> Any:
    """The operating points of an `[optimise]` table, or the word for those of the duty cycle.

    **Raises:** `Misplaced` where they are given twice, beside a nut speed, or without a duty cycle.
    """
    keys = [key for key in _KEYS if table.get(key)]
    if len(keys) > 1:
        other = f"[[optimise.{keys[0]}]]" if keys[0] == "operating_point" else keys[0]
        raise Misplaced((("optimise", keys[1]), f"is given beside {other}; give one of them"))
    if not keys:
        return ()
    if "nut_speed" in table:
        message = "both set the speed of the screw; give nut_speed or operating points"
        raise Misplaced((("optimise", keys[0]), message))
    points = table[keys[0]]
    if points == DUTY_CYCLE and mechanism.duty_cycle is None:
        message = 'is "duty_cycle", and the file has no [[duty_cycle]]; give its phases'
        raise Misplaced((("optimise", keys[0]), message))
    if keys[0] == "operating_point":
        return tuple(OperatingCase(**row) for row in table["operating_point"])
    return points
