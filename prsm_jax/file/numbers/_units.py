"""Units of files: a small pint registry, and exact factors to SI.

The registry holds only the units of this field, which makes it quick to build (pint's own list
takes forty times as long), and it treats the angle as a separate dimension, so that `25 Hz` for
a speed in rad/s is an error instead of a factor of 2π.
"""

import functools
import re
from fractions import Fraction
from typing import Any

import pint

#: The units in which numbers are written, by SI unit, the usual one first.
WRITTEN_UNITS: dict[str, tuple[str, ...]] = {
    "m": ("mm",),
    "rad": ("deg", "rad"),
    "rad/s": ("rpm", "rad/s"),
    "N": ("kN", "N"),
    "N/m": ("N/um", "N/m"),
    "N·m": ("N m",),
    "N·m/rad": ("N m/rad",),
    "N·m·s/rad": ("N m s/rad",),
    "N·s/m": ("N s/m",),
    "Pa": ("GPa", "MPa", "Pa"),
    "kg": ("kg", "g"),
    "kg·m²": ("kg mm^2", "kg m^2"),
    "kg/m³": ("kg/m^3",),
    "s": ("s", "ms", "us", "h"),
    "Hz": ("kHz", "Hz"),
    "1/s": ("1/s",),
    "rad/s²": ("rad/s^2",),
    "rad/s³": ("rad/s^3",),
    "m/s": ("mm/s", "m/s"),
    "m·rad/s": ("mm rpm", "m rad/s"),
    "W": ("W",),
}

_DEFINITIONS = """
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
second = [time] = s = sec
kilogram = [mass] = kg
radian = [angle] = rad
kelvin = [temperature] = K
gram = 1e-3 * kilogram = g
tonne = 1000 * kilogram = t
minute = 60 * second = min
hour = 60 * minute = h
turn = 6.2831853071795864769252867665590057683943387987502 * radian = _ = revolution = rev
degree = turn / 360 = deg = °
rpm = turn / minute
hertz = 1 / second = Hz
newton = kilogram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
joule = newton * meter = J
watt = joule / second = W
litre = 1e-3 * meter ** 3 = l = liter = L
inch = 0.0254 * meter = in
foot = 12 * inch = ft
pound = 0.45359237 * kilogram = lb
pound_force = 9.80665 * meter / second ** 2 * pound = lbf
psi = pound_force / inch ** 2
percent = 0.01
"""

#: Powers of the base units, as (name, power) pairs: hashable and comparable.
Dimension = frozenset[tuple[str, Fraction]]

_LONGEST = 60
_FACTOR = re.compile(r"([A-Za-zµμ°]{1,24})(?:(?:\^|\*\*)(-?[1-9])|([²³]))?")
_AROUND_OPERATORS = re.compile(r" ?(\*\*|[\^*·/]) ?")
_SUPERSCRIPTS = {"²": 2, "³": 3}
_KINDS = {
    "": "a plain number",
    "m": "a length",
    "s": "a time",
    "kg": "a mass",
    "rad": "an angle",
    "rad/s": "an angular speed",
    "Hz": "a frequency",
    "m/s": "a speed",
    "m rad/s": "a diameter times an angular speed",
    "rad/s^2": "an angular acceleration",
    "rad/s^3": "an angular jerk",
    "N": "a force",
    "N m": "a torque or an energy",
    "N m/rad": "a stiffness in rotation",
    "N/m": "a stiffness",
    "Pa": "a pressure",
    "W": "a power",
    "N s/m": "a viscous friction coefficient",
    "N m s": "a viscous friction coefficient in rotation",
    "N m s/rad": "a damping in rotation",
    "1/m": "a stiffness per force",
    "s/m": "a damping per force",
    "kg m^2": "a moment of inertia",
    "kg/m^3": "a density",
}


@functools.cache
def _registry() -> Any:
    # Returns `Any`, not `pint.UnitRegistry`: the bounds of its type parameters exist for type
    # checkers only, and run-time type checks would look them up.
    # pint's annotations allow neither an empty registry nor exact numbers, both documented.
    registry = pint.UnitRegistry(None, non_int_type=Fraction)  # type: ignore[arg-type]
    registry.load_definitions(_DEFINITIONS.strip().splitlines())
    return registry


def _unit(name: str) -> tuple[Fraction, dict[str, Fraction]]:
    """Factor to SI and dimension of one unit with or without a prefix."""
    registry = _registry()
    try:
        # Not `parse_units`: it accepts more operators than the grammar here.
        if not registry.parse_unit_name(name):
            raise KeyError(name)
        factor, base = registry.get_base_units(registry.Unit(name))
    except (pint.errors.PintError, KeyError, AttributeError, ValueError, TypeError) as error:
        raise ValueError(f"there is no unit {name!r} here") from error
    dimension = {str(k): Fraction(str(v)) for k, v in base.dimensionality.items()}
    return Fraction(str(factor)), dimension


@functools.lru_cache(maxsize=256)
def unit_factor(expression: str) -> tuple[Fraction, Dimension]:
    """Factor to SI and dimension of a unit expression.

    An expression is a product or quotient of units with integer powers below ten (`kg mm^2`,
    `N·s/m`, `1/s`); no arithmetic is evaluated, so no expression is slow.

    **Arguments:**

    - `expression`: the text; empty or `"1"` for a plain number, `"%"` for a hundredth.

    **Raises:** `ValueError` if the text is not such an expression or a unit is unknown.
    """
    if len(expression) > _LONGEST:
        raise ValueError(f"a unit of {len(expression)} characters is too long to be one")
    factor, dimension = Fraction(1), {}
    text = _AROUND_OPERATORS.sub(r"\1", " ".join(expression.split()))
    if text in ("", "1"):
        return factor, frozenset()
    if text == "%":
        return Fraction(1, 100), frozenset()
    position, sign = 0, 1
    if text.startswith("1/"):
        position, sign = 2, -1
    while True:
        match = _FACTOR.match(text, position)
        if match is None:
            raise ValueError(f"cannot read the unit {expression!r}")
        name, power, superscript = match.groups()
        exponent = sign * (int(power) if power else _SUPERSCRIPTS.get(superscript, 1))
        unit, base = _unit(name)
        factor *= unit**exponent
        for key, value in base.items():
            dimension[key] = dimension.get(key, Fraction(0)) + exponent * value
        position = match.end()
        if position == len(text):
            break
        if text[position] not in "*·/ ":
            raise ValueError(f"cannot read the unit {expression!r}")
        sign = -1 if text[position] == "/" else 1
        position += 1
    return factor, frozenset((k, v) for k, v in dimension.items() if v)


@functools.cache
def _kinds() -> dict[Dimension, str]:
    return {unit_factor(unit)[1]: kind for unit, kind in _KINDS.items()}


def kind_of(dimension: Dimension) -> str:
    """A few words for a dimension: "a length", "a stiffness", or its base units' powers."""
    if dimension in _kinds():
        return _kinds()[dimension]
    powers = sorted(dimension, key=lambda item: (item[1] < 0, item[0]))
    return " ".join(
        name.strip("[]") + ("" if power == 1 else f"^{power}") for name, power in powers
    )
