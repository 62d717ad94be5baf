"""Numbers as they are printed, turned back to SI by `pint` and not by the package's own units."""

import re
from dataclasses import dataclass

import numpy as np
import pint

_REGISTRY = pint.UnitRegistry()
_SPACES = "\u202f\u00a0\u2009"
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
MINUS = "\N{MINUS SIGN}"
#: Digits in groups of three, or in one; a fraction; a power of ten as 10⁶ or as e+06.
NUMBER = re.compile(
    rf"[+\-{MINUS}]?(?:\d{{1,3}}(?:[{_SPACES}]\d{{3}})+|\d+)(?:\.\d+)?"
    r"(?:·10(?P<super>[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)|e(?P<power>[+-]?\d+))?"
)
#: Units as they are printed that `pint` knows by another name.
_NAMES = {
    "°": "degree",
    "turns": "dimensionless",
    "": "dimensionless",
    "1": "dimensionless",
    # Of a ratio of powers: differences of percentages.
    "points": "percent",
}


def unit(label: str) -> pint.Unit:
    """The unit behind a printed label."""
    words = _NAMES.get(label, label)
    for sign, power in (("²", "**2"), ("³", "**3"), ("·", "*")):
        words = words.replace(sign, power)
    if words == "%":
        words = "percent"
    return _REGISTRY.Unit(words)


def to_si(values, label: str):
    """Numbers in the unit of a label, in SI (radians, hertz as 1/s, ratios as ratios)."""
    return _REGISTRY.Quantity(np.asarray(values, float), unit(label)).to_base_units().magnitude


def same_dimension(label: str, expected: str) -> bool:
    """Whether two labels measure the same; a frequency is no speed and a ratio is no angle."""
    families = {"rad": "angle", "deg": "angle", "°": "angle", "rad/s": "speed", "rpm": "speed"}
    families |= {"Hz": "frequency", "kHz": "frequency", "%": "ratio", "points": "ratio"}
    families |= {"": "ratio", "1": "ratio", "turns": "ratio"}
    first, second = families.get(label), families.get(expected)
    if first is not None or second is not None:
        return first == second
    return unit(label).dimensionality == unit(expected).dimensionality


@dataclass(frozen=True)
class Printed:
    """A number with the unit behind it, as printed."""

    value: float
    #: Half a unit of the last digit.
    rounding: float
    label: str

    def is_near(self, expected: float, si_unit: str, coarse: bool = False) -> bool:
        """Whether this is how an SI number reads, to the last digit printed.

        **Arguments:**

        - `expected`: [SI].
        - `si_unit`: its unit, whose dimension the label must have.
        - `coarse`: whether fewer than three digits are enough.
        """
        if not same_dimension(self.label, si_unit):
            return False
        value, rounding = (float(to_si(v, self.label)) for v in (self.value, self.rounding))
        if not coarse and rounding > 0.005001 * abs(value) and value != 0:
            return False
        # Binary rounding may carry a half to either side.
        return abs(value - expected) <= 1.000001 * rounding + 1e-12 * abs(expected)


def parse(text: str) -> tuple[float, float]:
    """Value and half a unit of the last digit of a printed number."""
    found = NUMBER.fullmatch(text.strip())
    if found is None:
        raise AssertionError(f"{text!r} is no number")
    plain = text.strip().replace(MINUS, "-")
    for space in _SPACES:
        plain = plain.replace(space, "")
    power = 0
    if found["super"]:
        power = int(found["super"].translate(_SUPERSCRIPTS))
    elif found["power"]:
        power = int(found["power"])
    mantissa = re.split(r"·10|e", plain)[0]
    decimals = len(mantissa.partition(".")[2])
    return float(mantissa) * 10.0**power, 0.5 * 10.0 ** (power - decimals)


#: A number, and what may be its unit.
_WITH_UNIT = re.compile(
    rf"(?P<number>{NUMBER.pattern})"
    rf"(?:[ {_SPACES}]?(?P<unit>(?:kg·mm²|mm²|kg/m³|N·s/m|mm·rpm|N/µm|N·m|mm/s|m/s|MPa|GPa|kHz|Hz|"
    r"rpm|deg|°|%|points|turns|µm|mm|km|kN|kW|kJ|mJ|kg|ms|Pa|N|W|J|m|g|s|h)(?![\w/·²]))?)?"
)


def numbers(text: str) -> list[Printed]:
    """Every number of a text with its unit, in order; digits inside words are none."""
    found = []
    for match in _WITH_UNIT.finditer(text):
        before = text[match.start() - 1] if match.start() else " "
        if before.isalpha() or before in "₀_":
            continue
        value, rounding = parse(match["number"])
        found.append(Printed(value, rounding, match["unit"] or ""))
    return found


def assert_reads(text: str, *expected: tuple, coarse: bool = False) -> None:
    """The numbers of a text are these, in this order: `(SI value, SI unit)`."""
    found = numbers(text)
    assert len(found) == len(expected), f"{text!r} has {found}, expected {expected}"
    for one, (value, si_unit, *rest) in zip(found, expected, strict=True):
        good = one.is_near(float(value), si_unit, coarse or bool(rest))
        assert good, f"{one} in {text!r} is not {value} {si_unit}"


def label_unit(label: str) -> str:
    """The unit that an axis or a column names: what follows the word `in`; none is a ratio."""
    found = re.search(r"(?:^|[\s,])in (?!the\b)(\S+)", label)
    return "" if found is None else found[1].rstrip(",;")
