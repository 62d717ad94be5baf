"""What the studio shows of a design, from the public functions of the package."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..findings import Status, StrengthCheck, check, status_of, strength_checks
from ..geometry import Finding
from ..mechanism import Mechanism
from ..optimisation import LimitReading, limit_readings
from ..quantities import available_quantities
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


def limits_of(mechanism: Mechanism, numbers: Numbers) -> tuple[LimitReading, ...]:
    """The limits of the `[optimise]` table beside the values of a design.

    **Arguments:**

    - `mechanism`: the mechanism with the values of the design.
    - `numbers`: its numbers, with the quantities of `shown_quantities`.
    """
    known = zip(numbers.quantities, map(float, numbers.values), strict=True)
    return limit_readings(mechanism, dict(known))
