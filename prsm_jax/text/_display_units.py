"""Display units: SI numbers as an engineer writes them."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, SupportsFloat

MINUS = "\N{MINUS SIGN}"
#: A non-breaking space that is narrower than a space between words.
_THIN = "\N{NARROW NO-BREAK SPACE}"


@dataclass(frozen=True)
class DisplayUnit:
    """A unit as it is shown, and the factor from SI to it."""

    label: str
    per_si: float

    def __call__(self, value: Any) -> Any:
        """An SI number, or array of them, in this unit."""
        return value * self.per_si

    def heading(self, name: str) -> str:
        """A name with this unit, as a table heads it: "lead [mm]"."""
        return f"{name} [{self.label}]" if self.label else name


#: Display units of each SI unit, the smallest first.
_SHOWN: dict[str, tuple[DisplayUnit, ...]] = {
    "m": (
        DisplayUnit("µm", 1e6),
        DisplayUnit("mm", 1e3),
        DisplayUnit("m", 1.0),
        DisplayUnit("km", 1e-3),
    ),
    "m²": (DisplayUnit("mm²", 1e6),),
    "rad": (DisplayUnit("deg", 180 / math.pi),),
    "rad/s": (DisplayUnit("rpm", 30 / math.pi),),
    "N": (DisplayUnit("N", 1.0), DisplayUnit("kN", 1e-3)),
    "N/m": (DisplayUnit("N/µm", 1e-6),),
    "N·m": (DisplayUnit("N·m", 1.0),),
    "N·m/rad": (DisplayUnit("N·m/rad", 1.0),),
    "N·m·s/rad": (DisplayUnit("N·m·s/rad", 1.0),),
    "N·s/m": (DisplayUnit("N·s/m", 1.0),),
    "Pa": (DisplayUnit("MPa", 1e-6),),
    "kg": (DisplayUnit("g", 1e3), DisplayUnit("kg", 1.0)),
    "kg·m²": (DisplayUnit("kg·mm²", 1e6),),
    "kg/m³": (DisplayUnit("kg/m³", 1.0),),
    "s": (DisplayUnit("ms", 1e3), DisplayUnit("s", 1.0), DisplayUnit("h", 1 / 3600)),
    "Hz": (DisplayUnit("Hz", 1.0), DisplayUnit("kHz", 1e-3)),
    "W": (DisplayUnit("W", 1.0), DisplayUnit("kW", 1e-3)),
    "J": (DisplayUnit("J", 1.0), DisplayUnit("kJ", 1e-3)),
    "m/s": (DisplayUnit("mm/s", 1e3), DisplayUnit("m/s", 1.0)),
    "m·rad/s": (DisplayUnit("mm·rpm", 1e3 * 30 / math.pi),),
    "1": (DisplayUnit("", 1.0),),
}
#: The smallest magnitude, in the unit itself, for which a unit is taken instead of a smaller one.
_WORTH = {
    "mm": 0.1,
    "m": 100.0,
    "km": 1.0,
    "h": 1.0,
    "kN": 1.0,
    "kg": 0.1,
    "s": 0.1,
    "kHz": 10.0,
    "kW": 10.0,
    "kJ": 10.0,
    "m/s": 1.0,
}
_PERCENT = DisplayUnit("%", 100.0)
_TURNS = DisplayUnit("turns", 1.0)
#: Quantities that count revolutions: lives.
_COUNT_TURNS = ("rating_life", "modified_rating_life")
#: Labels of all units that follow a number in text.
UNIT_LABELS = frozenset(
    {one.label for units in (*_SHOWN.values(), (_PERCENT, _TURNS)) for one in units if one.label}
)


def is_efficiency(quantity: str) -> bool:
    """Whether a quantity of the catalogue is a ratio of powers, shown in per cent."""
    return "efficiency" in quantity


def state_without_efficiency(quantity: str, value: SupportsFloat) -> str:
    """The state shown instead of an efficiency below 0; empty if there is an efficiency.

    The number is then power that has to be put in from elsewhere.
    """
    if not is_efficiency(quantity) or not float(value) < 0:
        return ""
    # Otherwise it is a thread that jams, a self-locking one that the load does not turn, or a load
    # that sinks while the screw drives.
    return "self-locking" if quantity.startswith("efficiency_backward") else "none"


def display_unit(
    unit: str, values: Iterable[float] | float | int = (), quantity: str = ""
) -> DisplayUnit:
    """The unit in which SI numbers are shown.

    **Arguments:**

    - `unit`: SI unit as in the catalogue of quantities; an unknown one is shown as it is.
    - `values`: the numbers to be shown together; the largest decides between mm and µm.
    - `quantity`: name of the quantity, if any: efficiencies are shown in per cent, and lives as a
      number of `turns`.
    """
    if unit == "1" and is_efficiency(quantity):
        return _PERCENT
    if unit == "1" and quantity.partition("[")[0] in _COUNT_TURNS:
        return _TURNS
    choices = _SHOWN.get(unit, (DisplayUnit(unit, 1.0),))
    numbers = [values] if isinstance(values, int | float) else list(values)
    largest = max((abs(float(v)) for v in numbers if math.isfinite(v)), default=math.inf)
    if largest == 0:
        # The SI unit itself, unless it is too large for the usual numbers, as a metre is.
        return next((c for c in choices[:2] if c.per_si == 1), choices[:2][-1])
    fitting = [c for c in choices if c(largest) >= _WORTH.get(c.label, 0.0)]
    return fitting[-1] if fitting else choices[0]


class NumberText(str):
    """A number as it is shown, with the number itself, for programs that calculate further.

    - `value`: the number, not rounded, in the unit of the text.
    - `unit`: label of the unit; empty if there is none.
    - `relation`: words before the number, such as `at most`; empty if there are none.
    """

    value: float
    unit: str
    relation: str

    def __new__(cls, digits: str, value: float, unit: str = "", relation: str = "") -> "NumberText":
        text = super().__new__(cls, f"{relation} {digits}" if relation else digits)
        text.value, text.unit, text.relation = value, unit, relation
        return text

    def __reduce__(self) -> tuple[type["NumberText"], tuple[str, float, str, str]]:
        digits = str(self).removeprefix(self.relation).lstrip(" ")
        return NumberText, (digits, self.value, self.unit, self.relation)


def related(relation: str, shown: str) -> str:
    """A shown number with words before it: "at most 2100 MPa"."""
    if isinstance(shown, NumberText):
        return NumberText(str(shown), shown.value, shown.unit, relation)
    return f"{relation} {shown}"


def number(value: SupportsFloat, digits: int = 4) -> str:
    """A number with `digits` significant digits; an exponent only below 1e-4 and from 1e7 on.

    **Returns:** a `NumberText`, or plain words where there is no finite number.
    """
    value = float(value)
    if not math.isfinite(value):
        return "not defined" if math.isnan(value) else ("∞" if value > 0 else MINUS + "∞")
    if value == 0:
        return NumberText("0", 0.0)
    power = math.floor(math.log10(abs(value)))
    if -5 < power < 7:
        text = f"{value:.{max(0, digits - 1 - power)}f}"
    else:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        text = f"{mantissa}·10{_superscript(int(exponent))}"
    return NumberText(text.replace("-", MINUS), value)


def digits_for(value: SupportsFloat, width: SupportsFloat, least: int = 4) -> int:
    """Significant digits of a number that show a tenth of a width, such as a scatter, or less.

    **Arguments:**

    - `value`: the number.
    - `width`: range in which such numbers differ, in the same unit.
    - `least`: digits that are shown at least, also where nothing differs.

    **Returns:** at most 12, beyond which differences are rounding.
    """
    value, width = abs(float(value)), abs(float(width))
    if not (0 < value < math.inf and 0 < width < math.inf):
        return least
    return min(max(least, math.floor(math.log10(value)) - math.floor(math.log10(width)) + 2), 12)


def _superscript(exponent: int) -> str:
    digits = "⁰¹²³⁴⁵⁶⁷⁸⁹"
    return ("⁻" if exponent < 0 else "") + "".join(digits[int(d)] for d in str(abs(exponent)))


def in_unit(value: SupportsFloat, unit: DisplayUnit, digits: int = 4) -> str:
    """An SI number in a display unit, with its label."""
    shown = unit(float(value))
    return with_label(number(shown, digits), unit.label)


def with_label(text: str, label: str, gap: str = _THIN) -> str:
    """A shown number with the label of its unit; the number is in this unit already."""
    if not label:
        return text
    words = f"{text}{gap}{label}"
    return NumberText(words, text.value, label) if isinstance(text, NumberText) else words


def show(value: SupportsFloat, unit: str, quantity: str = "", digits: int = 4) -> str:
    """An SI number in a suitable display unit, with the unit's label.

    For a thread that locks or jams, the state is shown instead of an efficiency.
    """
    state = state_without_efficiency(quantity, value) if unit == "1" else ""
    return state or in_unit(value, display_unit(unit, float(value), quantity), digits)


def fixed(value: SupportsFloat, decimals: int, sign: str = "-") -> str:
    """A number with as many decimals as given; with the sign "+" also in front of positive ones."""
    text = f"{float(value):{sign}.{decimals}f}".replace("-", MINUS)
    return NumberText(text, float(value)) if math.isfinite(value) else text


def trimmed(value: SupportsFloat, decimals: int = 3) -> str:
    """A dimension as on a drawing: without trailing zeros."""
    text = f"{float(value):.{decimals}f}".rstrip("0").rstrip(".")
    return NumberText(("0" if text in ("", "-0") else text).replace("-", MINUS), float(value))
