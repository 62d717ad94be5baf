"""What the studio shows of a design, from the public functions of the package."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..findings import Status, StrengthCheck, check, status_of, strength_checks
from ..geometry import Finding
from ..mechanism import Constraint, Mechanism
from ..quantities import available_quantities, quantity_of
from ..sensitivities import sensitivity

#: Quantities that the page shows, in its order, as far as the file has their data.
SHOWN = (
    "efficiency",
    "drive_torque",
    "max_pressure_shared",
    "max_pressure",
    "rating_life_time",
    "lowest_torsional_frequency",
    "lowest_mesh_torsional_frequency",
    "lowest_transverse_frequency",
    "lowest_mesh_transverse_frequency",
)


@dataclass(frozen=True)
class Numbers:
    """Values of quantities and what the variables do to them.

    - `quantities`: names, with a number in brackets for a component; `units`: SI.
    - `variables`: names of the columns; `design`: their values [SI].
    - `values`: (quantities) [SI].
    - `changes`: (quantities × variables) change of the quantity per 1 % of the variable [SI].
    - `relative`: the same as a share of the quantity; NaN where that is not defined.
    - `valid`: whether the values can be used.
    """

    quantities: tuple[str, ...]
    units: tuple[str, ...]
    variables: tuple[str, ...]
    design: Mapping[str, float]
    values: np.ndarray
    changes: np.ndarray
    relative: np.ndarray
    valid: bool

    def value(self, quantity: str) -> float:
        """The value of a quantity [SI]."""
        return float(self.values[self.quantities.index(quantity)])


@dataclass(frozen=True)
class LimitReading:
    """A limit of the `[optimise]` table beside its value [SI].

    `margin` is the distance from the limit as a share of it, negative where it is broken.
    """

    quantity: str
    unit: str
    value: float
    limit: float
    at_most: bool
    margin: float
    verdict: Literal["pass", "fail"]


@dataclass(frozen=True)
class Verdicts:
    """Checks and findings of a design, and the worst of them."""

    checks: tuple[StrengthCheck, ...]
    findings: tuple[Finding, ...]
    status: Status


def shown_quantities(mechanism: Mechanism) -> tuple[str, ...]:
    """Quantities that the page shows: the usual ones, and those of the `[optimise]` table."""
    problem, names = mechanism.design_problem, list(SHOWN)
    if problem is not None:
        names += [one.quantity for one in (*problem.objectives, *problem.constraints)]
    found = available_quantities(mechanism, dict.fromkeys(names))
    if "max_pressure_shared" in found and (problem is None or "max_pressure" not in names[9:]):
        found = tuple(name for name in found if name != "max_pressure")
    return found


def numbers_of(
    mechanism: Mechanism, design: Mapping[str, float], quantities: tuple[str, ...]
) -> Numbers:
    """Values and derivatives of a design, by `prsm_jax.sensitivity`: one compiled program.

    **Arguments:**

    - `mechanism`: the mechanism with the values of the design.
    - `design`: values of the variables [SI] by name.
    - `quantities`: names from the catalogue.
    """
    table = sensitivity(mechanism, quantities, tuple(design), kinks=False)
    values, gradient = np.asarray(table.values), np.asarray(table.gradient)
    changes = gradient * np.array([0.01 * value for value in design.values()])
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(values[:, None] != 0, changes / np.abs(values[:, None]), np.nan)
    return Numbers(
        table.quantities,
        table.quantity_units,
        table.parameters,
        design,
        values,
        changes,
        relative,
        bool(table.valid),
    )


def verdicts_of(mechanism: Mechanism) -> Verdicts:
    """Checks and findings of a design, by `prsm_jax.strength_checks` and `prsm_jax.check`."""
    checks, findings = strength_checks(mechanism), check(mechanism)
    return Verdicts(checks, findings, status_of(checks, findings))


def limits_of(constraints: tuple[Constraint, ...], numbers: Numbers) -> tuple[LimitReading, ...]:
    """The limits of the `[optimise]` table beside the values of a design."""
    found: list[LimitReading] = []
    for one in constraints:
        lower, upper = (one.lower, one.upper) if one.equal is None else (one.equal, one.equal)
        for name, value in zip(numbers.quantities, numbers.values, strict=True):
            if name.partition("[")[0] != one.quantity:
                continue
            for limit, at_most in ((lower, False), (upper, True)):
                if limit is not None:
                    distance = (limit - value) if at_most else (value - limit)
                    margin = float(distance / abs(limit)) if limit else float(distance)
                    verdict = "pass" if margin >= 0 else "fail"
                    unit = quantity_of(name).unit
                    found.append(
                        LimitReading(name, unit, float(value), limit, at_most, margin, verdict)
                    )
    return tuple(found)
