"""Problem of a study: drivers with their ranges, quantities with their senses, and limits."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from ..fields import check_number, listed_names
from ..mechanism import (
    Constraint,
    Mechanism,
    Objective,
    check_independent,
    find_parameters,
    follows_in_words,
)
from ..quantities import available_quantities, find_quantity
from ..sensitivities import DEFAULT_PARAMETERS
from ..text import display_unit

Sense: TypeAlias = Literal["maximise", "minimise"]
#: Quantities of a study where none are given, with their senses.
DEFAULT_QUANTITIES: dict[str, Sense] = {
    "efficiency": "maximise",
    "lowest_mesh_torsional_frequency": "maximise",
    "lowest_mesh_transverse_frequency": "maximise",
}
#: Range on either side of the present value, relative to it, where the mechanism gives none.
_SHARE = 0.25


@dataclass(frozen=True)
class Driver:
    """A number of the mechanism that a study varies [SI].

    - `present`: its value in the present design, which may lie outside of the range.
    - `follows`: numbers that change with it, in words.
    """

    name: str
    unit: str
    lower: float
    upper: float
    present: float
    follows: str = ""


@dataclass(frozen=True)
class StudyProblem:
    """Drivers, quantities and limits of a study.

    - `senses`: whether more or less of each quantity is better.
    - `objectives`: the quantities that are objectives of the front.
    - `limits`: constraints of the front.
    - `limited`: further quantities with a one-sided limit, with the sense that leads away from the
      limit. They are single numbers.
    - `units`: of quantities and limited quantities.
    """

    drivers: tuple[Driver, ...]
    senses: dict[str, Sense]
    objectives: tuple[str, ...]
    limits: tuple[Constraint, ...]
    limited: dict[str, Sense]
    units: dict[str, str]

    @property
    def names(self) -> tuple[str, ...]:
        """Quantities and limited quantities, in this order."""
        return (*self.senses, *self.limited)

    @property
    def computed(self) -> tuple[str, ...]:
        """All quantities that are computed for a design: those, and those of the other limits."""
        return tuple(dict.fromkeys((*self.names, *(one.quantity for one in self.limits))))

    @property
    def bounds(self) -> dict[str, tuple[float, float]]:
        """Ranges of the drivers."""
        return {one.name: (one.lower, one.upper) for one in self.drivers}

    @property
    def front_objectives(self) -> tuple[Objective, ...]:
        """The objectives of the front with their senses."""
        return tuple(Objective(name, self.senses[name]) for name in self.objectives)

    def sense(self, name: str) -> Sense:
        """The sense in which a quantity improves, or moves away from its limit."""
        return self.senses[name] if name in self.senses else self.limited[name]


def problem_of(
    mechanism: Mechanism,
    drivers: Mapping[str, tuple[float, float]] | Iterable[str] | None,
    quantities: Mapping[str, str] | None,
    objectives: Iterable[str] | None,
    limits: Iterable[Constraint] | None,
) -> StudyProblem:
    """Fill in arguments that are not given, and check the others.

    **Raises:** `ValueError` for an invalid range, sense or number of objectives;
    `UnknownNameError` for an unknown name.
    """
    senses = _senses(mechanism, quantities)
    given = (*senses,)[:2] if objectives is None else tuple(listed_names(objectives, "objectives"))
    missing = [name for name in given if name not in senses]
    if missing:
        raise ValueError(
            f"objectives name {', '.join(missing)}, which the study has no sense for; it has "
            f"{', '.join(senses)}"
        )
    if len(given) not in (2, 3):
        raise ValueError(
            f"objectives are {', '.join(given) or 'empty'}; a front has two or three of them"
        )
    kept = _limits(mechanism, limits)
    limited: dict[str, Sense] = {}
    for one in kept:
        two_sided = one.equal is not None or (one.lower is not None and one.upper is not None)
        single = not find_quantity(one.quantity).dimensions
        if single and not two_sided and one.quantity not in senses:
            limited[one.quantity] = "maximise" if one.lower is not None else "minimise"
    units = {name: find_quantity(name).unit for name in (*senses, *limited)}
    return StudyProblem(_drivers(mechanism, drivers), senses, given, kept, limited, units)


def _senses(mechanism: Mechanism, quantities: Mapping[str, str] | None) -> dict[str, Sense]:
    if quantities is None:
        known = available_quantities(mechanism, DEFAULT_QUANTITIES)
        if len(known) < 2:
            raise ValueError(
                f"the mechanism has data for {', '.join(known) or 'none'} of the default "
                f"quantities ({', '.join(DEFAULT_QUANTITIES)}); give two quantities or more with "
                "their senses"
            )
        return {name: DEFAULT_QUANTITIES[name] for name in known}
    senses: dict[str, Sense] = {}
    for name, sense in quantities.items():
        check_single(name, find_quantity(name).dimensions)
        if sense not in ("maximise", "minimise"):
            raise ValueError(
                f'quantity {name!r} has the sense {sense!r}; write "maximise" or "minimise"'
            )
        senses[name] = "maximise" if sense == "maximise" else "minimise"
    if len(senses) < 2:
        raise ValueError(
            f"quantities are {', '.join(senses) or 'empty'}; give two or more, such as "
            '{"efficiency": "maximise", "mass": "minimise"}'
        )
    return senses


def check_single(name: str, dimensions: tuple[object, ...]) -> None:
    """Refuse a quantity with components. **Raises:** `ValueError`."""
    if dimensions:
        listed = " × ".join(map(str, dimensions))
        raise ValueError(
            f"quantity {name!r} has components ({listed}); a study needs single numbers, such as "
            "lowest_torsional_frequency in place of torsional_frequencies"
        )


def _limits(mechanism: Mechanism, limits: Iterable[Constraint] | None) -> tuple[Constraint, ...]:
    if limits is not None:
        constraints = tuple(limits)
    else:
        own = mechanism.design_problem
        constraints = () if own is None else own.constraints
    for one in constraints:
        find_quantity(one.quantity)
    return constraints


def _drivers(mechanism: Mechanism, given: Any) -> tuple[Driver, ...]:
    own = {} if mechanism.design_problem is None else {
        one.name: (one.lower, one.upper) for one in mechanism.design_problem.variables
    }  # fmt: skip
    ranges: Mapping[str, Any]
    if isinstance(given, Mapping):
        ranges = given
    else:
        names = DEFAULT_PARAMETERS if given is None else listed_names(given, "drivers")
        ranges = {name: own.get(name) for name in names}
    if not ranges:
        raise ValueError("drivers are empty; name at least one number of the mechanism")
    names = list(ranges)
    complete = []
    for name, both in ranges.items():
        present, unit = _present(mechanism, name)
        lower, upper = _range(mechanism, name, both, present, unit)
        follows = follows_in_words(mechanism, name, names)
        complete.append(Driver(name, unit, lower, upper, present, follows))
    check_independent(mechanism, names)
    return tuple(complete)


def _present(mechanism: Mechanism, name: str) -> tuple[float, str]:
    """Present value and unit of a number that all stages share."""
    parameters = find_parameters(mechanism, name)
    if any(one.static for one in parameters):
        raise ValueError(
            f"driver {name!r} is a whole number and has no derivative; sweep over it instead"
        )
    values = [float(one.get(mechanism)) for one in parameters]
    if not np.allclose(values, values[0], rtol=1e-12, atol=0.0):
        paths = " or ".join(one.path for one in parameters)
        raise ValueError(f"driver {name!r} differs between the stages; name the stage: {paths}")
    return values[0], parameters[0].unit


def _ends(unit: str, *ends: float) -> str:
    """Ends of a range as they may be typed: "12 mm to 8 mm"."""
    shown = display_unit(unit, ends)
    return " to ".join(f"{shown(end):.6g} {shown.label}".rstrip() for end in ends)


def _range(
    mechanism: Mechanism, name: str, both: Any, present: float, unit: str
) -> tuple[float, float]:
    if both is None:
        if present == 0:
            raise ValueError(f"driver {name!r} is 0, so its value gives no range; give a range")
        ends = sorted(((1 - _SHARE) * present, (1 + _SHARE) * present))
        lower, upper = ends[0], ends[1]
    else:
        try:
            lower, upper = map(float, both)
        except (TypeError, ValueError):
            raise ValueError(
                f"driver {name!r} has the range {both!r}; give (lower, upper)"
            ) from None
    if not (math.isfinite(lower) and math.isfinite(upper)):
        raise ValueError(f"driver {name!r} has the range ({lower}, {upper}); give finite numbers")
    if not lower < upper:
        remedy = "reverse them" if lower > upper else "the second end must be the larger one"
        raise ValueError(f"driver {name!r} has the range {_ends(unit, lower, upper)}; {remedy}")
    for one in find_parameters(mechanism, name):
        for side, value in (("lower", lower), ("upper", upper)):
            check_number(f"driver {name!r}: ", f"{side} end", one.unit, value, one.limit)
    return lower, upper
