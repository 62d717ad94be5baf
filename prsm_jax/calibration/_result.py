"""The result of a calibration: values with limits, residuals, undetermined combinations."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..mechanism import Mechanism
from ..results import Shown
from ..text import NOT_DEFINED, TextTable, display_unit, trimmed

#: Correlation from which a pair is named in the text.
_STRONG = 0.9


@dataclass(frozen=True)
class FittedParameter:
    """A fitted parameter [SI], with its 95 % limits.

    `standard_deviation`, `lower` and `upper` are NaN on an active bound. Where the data have no
    influence on the parameter, the standard deviation is infinite, and the limits are the bounds
    (infinite where there is none). `active_bound` is `"lower"`, `"upper"` or empty.
    """

    name: str
    unit: str
    start: float
    value: float
    standard_deviation: float
    lower: float
    upper: float
    active_bound: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON."""
        numbers = ("value", "standard_deviation", "lower", "upper", "start")
        return {
            "name": self.name,
            "unit": self.unit,
            **{name: _plain(getattr(self, name)) for name in numbers},
            "active_bound": self.active_bound or None,
        }


@dataclass(frozen=True)
class Residuals:
    """Measured and computed values of one quantity [SI], a number per measured value.

    `labels` names the component that each value is paired with.
    """

    quantity: str
    unit: str
    labels: tuple[str, ...]
    measured: np.ndarray
    computed: np.ndarray
    #: Conditions of each value, by name [SI].
    conditions: dict[str, np.ndarray]

    @property
    def residuals(self) -> np.ndarray:
        """Measured minus computed."""
        return self.measured - self.computed

    @property
    def rms(self) -> float:
        """Root mean square of the residuals."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON."""
        return {
            "quantity": self.quantity,
            "unit": self.unit,
            "rms": _plain(self.rms),
            "components": list(self.labels),
            "measured": [_plain(value) for value in self.measured],
            "computed": [_plain(value) for value in self.computed],
        }


@dataclass(frozen=True)
class Undetermined:
    """A combination of parameters that the data do not determine.

    `changes` are relative changes of the parameters, a vector of length 1. `standard_deviation` is
    the relative standard deviation along this vector.
    """

    parameters: tuple[str, ...]
    changes: tuple[float, ...]
    standard_deviation: float
    sentence: str

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON."""
        return {
            "parameters": list(self.parameters),
            "changes": list(self.changes),
            "standard_deviation": _plain(self.standard_deviation),
            "sentence": self.sentence,
        }


@dataclass(frozen=True, repr=False)
class Calibration(Shown):
    """Parameters that fit the measurements best; prints itself.

    `code` is `"converged"`, `"not_converged"` (the search stopped before the optimum),
    `"start_fails"` (the mechanism cannot be computed at the start) or `"not_finite"`; `message`
    explains the code in a sentence.
    """

    #: The mechanism with the fitted values, a pytree like the given one. After a failure, the given
    #: mechanism.
    mechanism: Mechanism
    parameters: tuple[FittedParameter, ...]
    #: Correlation of each pair, in the order of the parameters; NaN where there is none.
    correlation: np.ndarray
    #: Root mean square of residuals over the scale of each row (standard deviation, or the root
    #: mean square of the measured values of the quantity).
    residual_rms: float
    undetermined: tuple[Undetermined, ...]
    residuals: tuple[Residuals, ...]
    #: Scale of each measured column [SI].
    scales: dict[str, float]
    loss: str
    #: Measured values less the combinations of free parameters that have an influence on them.
    degrees_of_freedom: int
    code: str
    message: str
    steps: int

    @property
    def converged(self) -> bool:
        """Whether the fit can be used."""
        return self.code == "converged"

    @property
    def values(self) -> dict[str, float]:
        """Fitted values by name [SI]."""
        return {one.name: one.value for one in self.parameters}

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON; `None` where one is not finite."""
        return {
            "parameters": {one.name: one.to_dict() for one in self.parameters},
            "correlation": [[_plain(value) for value in row] for row in self.correlation],
            "residual_rms": _plain(self.residual_rms),
            "undetermined": [one.to_dict() for one in self.undetermined],
            "residuals": [one.to_dict() for one in self.residuals],
            "scales": {name: _plain(value) for name, value in self.scales.items()},
            "loss": self.loss,
            "degrees_of_freedom": self.degrees_of_freedom,
            "converged": self.converged,
            "code": self.code,
            "message": self.message,
            "steps": self.steps,
        }

    def text(self, width: int | None = None) -> str:
        """Parameters as a table in an engineer's units, residuals, undetermined combinations.

        **Arguments:**

        - `width`: number of characters in a line; default as many as the tables need.
        """
        parts = [_parameters(self).text(width), _residuals(self).text(width)]
        return "\n".join([*parts, *_sentences(self)])

    def __str__(self) -> str:
        return self.text()


def _plain(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _parameters(result: Calibration) -> TextTable:
    rows = []
    for one in result.parameters:
        shown = display_unit(one.unit, [one.value, one.start])
        numbers = [one.start, one.value, one.standard_deviation, one.lower, one.upper]
        state = one.active_bound or NOT_DEFINED
        rows.append((shown.heading(one.name), *(float(shown(value)) for value in numbers), state))
    columns = ("", "start", "fitted", "standard deviation", "95 % from", "to", "at bound")
    return TextTable("Fitted parameters", columns, rows)


def _residuals(result: Calibration) -> TextTable:
    rows = []
    for one in result.residuals:
        shown = display_unit(one.unit, one.residuals, one.quantity)
        worst = float(np.max(np.abs(one.residuals)))
        counts = len(one.measured), float(shown(one.rms)), float(shown(worst))
        rows.append((shown.heading(one.quantity), *counts))
    columns = ("", "values", "root mean square", "largest")
    return TextTable("Residuals, measured minus computed", columns, rows)


def _sentences(result: Calibration) -> list[str]:
    lines = [f"{'converged' if result.converged else 'NOT CONVERGED'}: {result.message}"]
    lines += [one.sentence for one in result.undetermined]
    names = [one.name for one in result.parameters]
    for i, first in enumerate(names):
        for j in range(i):
            value = result.correlation[i, j]
            if abs(value) >= _STRONG:
                lines.append(f"{names[j]} and {first} have a correlation of {trimmed(value)}")
    return lines
