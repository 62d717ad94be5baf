"""Labels: arrays over a grid become a data set with names, units and descriptions."""

from typing import TYPE_CHECKING, Any

import numpy as np

from .._version import __version__
from ..findings import error_names
from ..mechanism import Mechanism, set_parameters
from ..quantities import REASONS, Quantity, find_quantity
from ._axes import Grid

if TYPE_CHECKING:
    import xarray


def labelled(
    mechanism: Mechanism,
    grid: Grid,
    values: dict[str, np.ndarray],
    codes: dict[str, np.ndarray],
    point: dict[str, Any],
) -> "xarray.Dataset":
    """The data set of a sweep.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `grid`: the axes.
    - `values`: quantities, with the axes of the grid first.
    - `codes`: `code`, 0 or why a design failed (`prsm_jax.quantities.REASONS`), and `error`, 0 or
      the first error of `check` (its place in `error_names`, from 1).
    - `point`: `speed` and `load` that were given for all designs, or `None`.
    """
    import xarray

    over = tuple(axis.name for axis in grid.axes)
    coordinates: dict[str, Any] = {
        axis.name: (axis.name, axis.values, {"units": axis.unit, "long_name": axis.description})
        for axis in grid.axes
    }
    variables: dict[str, Any] = {}
    for name, array in values.items():
        quantity = find_quantity(name)
        attributes = {
            "units": quantity.unit,
            "long_name": quantity.description,
            "symbol": quantity.symbol,
        }
        own = _dimensions(quantity, array.shape[len(over) :], len(mechanism.stages))
        if "stage" in own:
            numbers = np.arange(1, len(mechanism.stages) + 1)
            coordinates["stage"] = ("stage", numbers, {"long_name": "number of the stage"})
        variables[name] = ((*over, *own), array, attributes)
    failed = codes["code"] != 0
    # A derived number that an axis makes explicit has margins too.
    first = {axis.name: axis.values[0] for axis in grid.axes}
    written = set_parameters(mechanism, first, checked=False)
    variables["failed"] = (over, failed, {"long_name": "whether a design failed; see code"})
    meanings = {
        "code": ("why a design failed", REASONS),
        "error": ("first error that check finds in a design", ("none", *error_names(written))),
    }
    # Codes in the form of the conventions for climate and forecast metadata.
    for name, (words, flags) in meanings.items():
        variables[name] = (
            over,
            codes[name],
            {
                "long_name": words,
                "flag_values": list(range(len(flags))),
                "flag_meanings": " ".join(flags),
            },
        )
    attributes = {
        "title": mechanism.title,
        "points": grid.points,
        "failed": int(failed.sum()),
        "errors": int((codes["error"] != 0).sum()),
        "prsm_jax_version": __version__,
    }
    attributes |= {name: float(value) for name, value in point.items() if value is not None}
    return xarray.Dataset(variables, coordinates, attributes)


def _dimensions(quantity: Quantity, shape: tuple[int, ...], stages: int) -> tuple[str, ...]:
    """Names of a quantity's own dimensions; only stages are shared between quantities."""
    names = []
    for index, length in enumerate(shape):
        known = quantity.dimensions[index] if index < len(quantity.dimensions) else f"{index + 1}"
        shared = known == "stage" and length == stages
        names.append(known if shared else f"{quantity.name}_{known}")
    return tuple(names)
