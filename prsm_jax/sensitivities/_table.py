"""The result of a sensitivity analysis: a table that prints itself."""

import itertools
import math
import textwrap
from collections.abc import Sequence
from typing import Any

import equinox as eqx
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Bool, Float

from ..mechanism import dependents_in_words
from ..results import Shown
from ..text import NOT_DEFINED, TextTable, display_unit, state_without_efficiency
from ._kinks import differ


class Sensitivity(Shown, eqx.Module):
    """Derivatives of quantities (rows) with respect to parameters (columns).

    A pytree: the arrays may be traced or batched, the names are static.
    """

    #: Value of each quantity [SI].
    values: Float[Array, "*batch quantities"]
    #: ∂q/∂p in SI units.
    gradient: Float[Array, "*batch quantities parameters"]
    #: (p/q) ∂q/∂p: per cent of the quantity per per cent of the parameter. 0 where
    #: `elasticity_defined` is false, so that a sum over rows stays finite.
    elasticity: Float[Array, "*batch quantities parameters"]
    #: False for a quantity that is 0 or not finite: a relative change is not defined.
    elasticity_defined: Bool[Array, "*batch quantities"]
    #: Present value of each parameter in each stage that has it [SI].
    parameter_values: tuple[Float[Array, "*batch _"], ...]
    #: False where the values cannot be used (no meshing, a pulling contact).
    valid: Bool[Array, "*batch"]
    quantities: tuple[str, ...] = eqx.field(static=True)
    parameters: tuple[str, ...] = eqx.field(static=True)
    quantity_units: tuple[str, ...] = eqx.field(static=True)
    parameter_units: tuple[str, ...] = eqx.field(static=True)
    #: For each parameter the dimensions that follow when it changes, and those that stay.
    dependents: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = eqx.field(
        static=True, default=()
    )
    #: ∂q/∂p just below and just above each parameter; `None` without a search for kinks.
    left: Float[Array, "*batch quantities parameters"] | None = None
    right: Float[Array, "*batch quantities parameters"] | None = None
    #: ∂²q/∂p∂p' in SI units, symmetric; `None` unless asked for.
    hessian: Float[Array, "*batch quantities parameters parameters"] | None = None

    @property
    def kinks(self) -> tuple[tuple[str, str, float, float], ...]:
        """Quantity, parameter, and the derivatives below and above [SI], wherever they differ.

        There `gradient` is neither of the two: the design lies at the change from one branch to
        another.
        """
        if self.left is None or self.right is None:
            return ()
        self._single("kinks")
        left, right = np.asarray(self.left), np.asarray(self.right)
        unequal = differ(
            left, right, np.asarray(self.values), list(map(_array, self.parameter_values))
        )
        return tuple(
            (self.quantities[i], self.parameters[j], float(left[i, j]), float(right[i, j]))
            for i, j in zip(*np.nonzero(unequal), strict=True)
        )

    def __getitem__(self, names: tuple[str, str]) -> Float[Array, "*batch"]:
        """∂quantity/∂parameter [SI] by the two names.

        **Raises:** `KeyError` for a name that is not in the table.
        """
        quantity, parameter = names
        if quantity not in self.quantities or parameter not in self.parameters:
            raise KeyError(
                f"{names}; rows: {', '.join(self.quantities)}; "
                f"columns: {', '.join(self.parameters)}"
            )
        row, column = self.quantities.index(quantity), self.parameters.index(parameter)
        return self.gradient[..., row, column]

    def to_dict(self) -> dict[str, Any]:
        """Plain lists for JSON; `None` where a number is not finite or not defined.

        **Raises:** `ValueError` for a batched table.
        """
        self._single("to_dict")
        defined = np.asarray(self.elasticity_defined)
        elasticity = np.where(defined[:, None], np.asarray(self.elasticity), np.nan)
        return {
            "quantities": list(self.quantities),
            "quantity_units": list(self.quantity_units),
            "values": _plain(self.values),
            "parameters": list(self.parameters),
            "parameter_units": list(self.parameter_units),
            "parameter_values": [_plain(values) for values in self.parameter_values],
            "gradient": _plain(self.gradient),
            "elasticity": _plain(elasticity),
            "valid": bool(self.valid),
            "kinks": [
                {"quantity": q, "parameter": p, "below": _plain(below), "above": _plain(above)}
                for q, p, below, above in self.kinks
            ],
            "follows": {p: list(d[0]) for p, d in self._dependents()},
            "stays": {p: list(d[1]) for p, d in self._dependents()},
            **({} if self.hessian is None else {"hessian": _plain(self.hessian)}),
        }

    def _dependents(self):
        return zip(self.parameters, self.dependents, strict=False)

    def _single(self, purpose: str) -> None:
        if self.gradient.ndim != 2:
            raise ValueError(
                f"{purpose} needs one table; this one is a batch of shape "
                f"{self.gradient.shape[:-2]}: take one with jax.tree.map(lambda a: a[i], table)"
            )

    def __str__(self) -> str:
        if isinstance(self.gradient, Tracer) or self.gradient.ndim != 2:
            shape = self.gradient.shape
            return f"Sensitivity of shape {shape}: {self.quantities} × {self.parameters}"
        return self.text()

    def text(self, width: int | None = None) -> str:
        """The derivatives per millimetre, degree and so on, and the elasticities, as tables.

        **Arguments:**

        - `width`: number of characters in a line; default as many as the tables need.

        **Raises:** `ValueError` for a batched table.
        """
        self._single("text")
        words = "\n".join(table.text(width) for table in _tables(self))
        lines = [*_kink_lines(self), *_dependent_lines(self)]
        if width is not None:
            lines = [
                part
                for line in lines
                for part in textwrap.wrap(line, width, subsequent_indent="  ")
            ]
        words += "".join(f"\n{line}" for line in lines) + "\n"
        if not bool(self.valid):
            words += "not valid: the threads do not mesh, or a contact would have to pull\n"
        return words.rstrip()


def _plain(array) -> list[Any] | float | None:
    """Nested lists of floats, `None` for numbers that JSON cannot represent."""
    array = np.asarray(array, dtype=float)
    if array.ndim == 0:
        value = float(array)
        return value if math.isfinite(value) else None
    return [_plain(row) for row in array]


def _array(value) -> np.ndarray:
    return np.asarray(value, dtype=float)


def _kink_lines(table: Sensitivity) -> list[str]:
    """Each kink with both derivatives, in the units of the table."""
    lines = []
    for quantity, parameter, below, above in table.kinks:
        row, column = table.quantities.index(quantity), table.parameters.index(parameter)
        value = float(np.asarray(table.values)[row])
        shown = display_unit(table.quantity_units[row], value, quantity)
        size = np.abs(_array(table.parameter_values[column])).ravel().tolist()
        step = display_unit(table.parameter_units[column], size)
        texts = [f"{float(shown(slope) / step.per_si):.6g}" for slope in (below, above)]
        unit = f" {shown.label}".rstrip() + f" per {step.label or '1'}"
        lines.append(
            f"kink: derivative of {quantity} by {parameter} is {texts[0]}{unit} below and "
            f"{texts[1]}{unit} above this design; the number in the table is neither"
        )
    return lines


def _dependent_lines(table: Sensitivity) -> list[str]:
    """A line for each parameter: numbers that change with it, and numbers that stay constant."""
    pairs = zip(table.parameters, table.dependents, strict=False)
    lines = (dependents_in_words(name, *both) for name, both in pairs)
    return [line for line in lines if line]


def _tables(table: Sensitivity) -> tuple[TextTable, ...]:
    """Values with their changes per millimetre or degree, elasticities, and second derivatives."""
    steps = [
        display_unit(unit, np.abs(np.asarray(value, dtype=float)).ravel().tolist())
        for unit, value in zip(table.parameter_units, table.parameter_values, strict=True)
    ]
    heads = [
        f"per {step.label or '1'} of {name}"
        for name, step in zip(table.parameters, steps, strict=True)
    ]
    values, gradient = np.asarray(table.values), np.asarray(table.gradient)
    elasticity, defined = np.asarray(table.elasticity), np.asarray(table.elasticity_defined)
    rows, relative = [], []
    for i, (name, unit) in enumerate(zip(table.quantities, table.quantity_units, strict=True)):
        shown = display_unit(unit, float(values[i]), name)
        label = shown.heading(name)
        state = state_without_efficiency(name, float(values[i]))
        if state:
            # Without an efficiency there is no derivative of it.
            undefined = [NOT_DEFINED] * len(steps)
            rows.append((label, state, *undefined))
            relative.append((name, *undefined))
            continue
        cells = [float(shown(g) / s.per_si) for g, s in zip(gradient[i], steps, strict=True)]
        rows.append((label, float(shown(values[i])), *cells))
        signs = [f"{e:+z.4f}" if defined[i] else NOT_DEFINED for e in elasticity[i]]
        relative.append((name, *signs))
    tables = (
        TextTable("", ("quantity", "value", *heads), rows),
        TextTable("", ("elasticity (% per %)", *table.parameters), relative),
    )
    return tables if table.hessian is None else (*tables, _second_table(table, steps))


def _second_table(table: Sensitivity, steps: Sequence[Any]) -> TextTable:
    """Second derivatives per millimetre, degree and so on, a row for each pair."""
    values, curved = np.asarray(table.values), np.asarray(table.hessian)
    rows = []
    for i, (name, unit) in enumerate(zip(table.quantities, table.quantity_units, strict=True)):
        shown = display_unit(unit, float(values[i]), name)
        if state_without_efficiency(name, float(values[i])):
            continue
        for a, b in itertools.combinations_with_replacement(range(len(steps)), 2):
            per = " ".join(steps[k].label or "1" for k in (a, b))
            label = f"{shown.heading(name)} per {per}"
            cell = float(shown(curved[i, a, b]) / steps[a].per_si / steps[b].per_si)
            rows.append((label, table.parameters[a], table.parameters[b], cell))
    return TextTable("", ("second derivative", "by", "and by", "value"), rows)
