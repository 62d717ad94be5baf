"""Numbers that the studio moves: those of `[optimise]` or the usual ones, speed, and load."""

import dataclasses
import math
from collections.abc import Mapping

from .._errors import PrsmError, UnknownNameError
from ..mechanism import Mechanism, find_parameters, set_parameters
from ..text import DisplayUnit, display_unit, trimmed

#: Names for a file without an `[optimise]` table; those that a mechanism lacks are left out.
USUAL = ("lead", "contact_angle", "roller_radius", "roller_profile_radius")
#: Limits of these, in present values.
_LEAST, _MOST = 0.6, 1.6
#: Numbers of the operating point, which can be moved beside those of the design, and their limits.
OPERATING_POINT = ("operating_point.speed", "operating_point.load")
_LEAST_OPERATING, _MOST_OPERATING = 0.25, 2.0
#: A slider has at least this many steps.
_STEPS = 100


@dataclasses.dataclass(frozen=True)
class StudioVariable:
    """A number of the design with its limits.

    - `name`: as `prsm_jax.set_parameter` takes it; `label`: in words.
    - `lower`, `upper`: limits [SI]; `unit`: as the page shows values; `step`: of the slider, in it.
    """

    name: str
    label: str
    lower: float
    upper: float
    unit: DisplayUnit
    step: float

    def shown(self, value: float) -> float:
        """An SI value in the unit of the page."""
        return float(self.unit(value))

    def read(self, shown: float | int | None) -> float:
        """A value in the unit of the page in SI.

        **Raises:** `PrsmError` for one that is not a number or beyond the limits.
        """
        try:
            value = math.nan if shown is None else float(shown) / self.unit.per_si
        except (TypeError, ValueError):
            value = math.nan
        if math.isnan(value):
            raise PrsmError(f"{self.label} is not a number; give {self.limits}")
        # A limit that is typed may differ from the limit by rounding.
        for limit in (self.lower, self.upper):
            if math.isclose(value, limit, rel_tol=1e-12):
                value = limit
        if not self.lower <= value <= self.upper:
            raise PrsmError(f"{self.label} is {shown}; give {self.limits}")
        return value

    @property
    def limits(self) -> str:
        """The limits in words, with their unit."""
        lower, upper = trimmed(self.shown(self.lower)), trimmed(self.shown(self.upper))
        return f"{lower} to {upper} {self.unit.label}".rstrip()


def _variable(name: str, lower: float, upper: float, si: str) -> StudioVariable:
    unit = display_unit(si, [lower, upper])
    step = 10.0 ** math.floor(math.log10(float(unit(upper - lower)) / _STEPS))
    return StudioVariable(name, name.replace("_", " ").replace(".", " "), lower, upper, unit, step)


def studio_variables(mechanism: Mechanism) -> tuple[StudioVariable, ...]:
    """The numbers to move, with their limits.

    Those of the `[optimise]` table with its bounds, which are widened to the present design where
    that lies outside. Without a table: lead, contact angle, roller radius and profile radius, from
    0.6 to 1.6 of the present values. A name whose stages differ is moved in each stage alone.
    Speed and load of the operating point follow, from 0.25 to 2 of their values, unless they are 0.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    """
    problem = mechanism.design_problem
    found: list[StudioVariable] = []
    for name in USUAL if problem is None else [one.name for one in problem.variables]:
        try:
            parameters = find_parameters(mechanism, name)
        except UnknownNameError:
            continue
        values = [float(one.get(mechanism)) for one in parameters]
        same = all(math.isclose(value, values[0], rel_tol=1e-12) for value in values)
        names = [name] if same else [one.path for one in parameters]
        for own, parameter, value in zip(names, parameters, values, strict=False):
            limits = _LEAST * value, _MOST * value
            if problem is not None:
                given = problem.variables[[one.name for one in problem.variables].index(name)]
                limits = min(given.lower, value), max(given.upper, value)
            elif parameter.unit == "rad":
                limits = limits[0], min(limits[1], 0.95 * parameter.limit.upper)
            found.append(_variable(own, *limits, parameter.unit))
    return (*found, *_of_operating_point(mechanism, {one.name for one in found}))


def _of_operating_point(mechanism: Mechanism, taken: set[str]) -> list[StudioVariable]:
    """Speed and load, unless they are moved already, not given, or 0, which has no range."""
    found: list[StudioVariable] = []
    if mechanism.operating_point is None:
        return found
    for name in OPERATING_POINT:
        (parameter,) = find_parameters(mechanism, name)
        value = float(parameter.get(mechanism))
        short = name.rpartition(".")[2]
        if value and not taken & {name, short}:
            lower, upper = sorted((_LEAST_OPERATING * value, _MOST_OPERATING * value))
            one = _variable(name, lower, upper, parameter.unit)
            found.append(dataclasses.replace(one, label=short))
    return found


def present_values(
    mechanism: Mechanism, variables: tuple[StudioVariable, ...]
) -> Mapping[str, float]:
    """Present values of the variables [SI]."""
    return {
        one.name: float(find_parameters(mechanism, one.name)[0].get(mechanism)) for one in variables
    }


def with_values(mechanism: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """The mechanism with the values, each of them a number of its own.

    A number that follows from others while a file does not give it (the profile radius of the
    roller) stays where it is when the others move, as in an optimisation.

    **Raises:** `ValueError` where they exclude each other.
    """
    return set_parameters(mechanism, values)
