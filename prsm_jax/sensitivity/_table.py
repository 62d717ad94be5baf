"""The result of a sensitivity analysis: a table that prints itself."""

import math

import equinox as eqx
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Bool, Float


class Sensitivity(eqx.Module):
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
    #: False for a quantity that is 0 (or not finite), of which there are no per cents.
    elasticity_defined: Bool[Array, "*batch quantities"]
    #: Present value of each parameter in each stage that has it [SI].
    parameter_values: tuple[Float[Array, "*batch _"], ...]
    #: False where the values cannot be used (no meshing, a pulling contact).
    valid: Bool[Array, "*batch"]
    quantities: tuple[str, ...] = eqx.field(static=True)
    parameters: tuple[str, ...] = eqx.field(static=True)
    quantity_units: tuple[str, ...] = eqx.field(static=True)
    parameter_units: tuple[str, ...] = eqx.field(static=True)

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

    def to_dict(self) -> dict:
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
        }

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
        return "\n".join(_lines(self))


def _plain(array) -> list | float | None:
    """Nested lists of floats, `None` for what JSON has no number for."""
    array = np.asarray(array, dtype=float)
    if array.ndim == 0:
        value = float(array)
        return value if math.isfinite(value) else None
    return [_plain(row) for row in array]


def _lines(table: Sensitivity) -> list[str]:
    names = [f"{q} [{u}]" for q, u in zip(table.quantities, table.quantity_units, strict=True)]
    heads = [f"{p} [{u}]" for p, u in zip(table.parameters, table.parameter_units, strict=True)]
    values, gradient = np.asarray(table.values), np.asarray(table.gradient)
    elasticity, defined = np.asarray(table.elasticity), np.asarray(table.elasticity_defined)
    rows = [["quantity", "value", *(f"d/d {head}" for head in heads)]]
    relative = [["per cent per per cent", "", *table.parameters]]
    for i, name in enumerate(names):
        rows.append([name, f"{values[i]:.6g}", *(f"{g:.5g}" for g in gradient[i])])
        cells = [f"{e:+.4f}" if defined[i] else "–" for e in elasticity[i]]
        relative.append([table.quantities[i], "", *cells])
    widths = [max(len(row[c]) for row in rows + relative) for c in range(len(rows[0]))]
    lines = []
    for block in (rows, relative):
        if lines:
            lines.append("")
        for row in block:
            first, rest = row[0].ljust(widths[0]), zip(row[1:], widths[1:], strict=True)
            lines.append("  ".join([first, *(cell.rjust(width) for cell, width in rest)]).rstrip())
    if not bool(table.valid):
        lines.append("not valid: the threads do not mesh, or a contact would have to pull")
    return lines
