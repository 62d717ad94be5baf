"""Labels of the arrays of a sweep: names, dimensions, units and descriptions."""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .._version import __version__
from ..findings import error_names
from ..mechanism import Mechanism, find_parameters, set_parameters
from ..quantities import REASONS, Quantity, find_quantity
from ._plan import Plan, blocks_of
from ._program import BlockResults

if TYPE_CHECKING:
    import xarray

#: Code of a design that was not computed, for example because a run was stopped before.
NOT_COMPUTED = REASONS.index("not_computed")
#: Designs whose codes are in memory at once.
_PIECE = 1_000_000


@dataclass(frozen=True)
class Variable:
    """One array of the data set, over the designs and then its own dimensions."""

    name: str
    own_dimensions: tuple[str, ...]
    own_shape: tuple[int, ...]
    dtype: np.dtype
    #: Where no design was computed.
    fill: Any
    attributes: dict[str, Any] = field(default_factory=dict)


def derivative_name(quantity: str, parameter: str) -> str:
    """Name of the array of derivatives of a quantity by a parameter."""
    return f"{quantity}_by_{parameter}"


def variables_of(
    mechanism: Mechanism,
    plan: Plan,
    quantities: tuple[str, ...],
    gradients: tuple[str, ...],
    shapes: BlockResults,
) -> tuple[Variable, ...]:
    """All arrays of a sweep.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `plan`: the plan.
    - `quantities`: names from the catalogue.
    - `gradients`: parameters by which they are differentiated.
    - `shapes`: shapes and types of the results of a block.
    """
    stages = len(mechanism.stages)
    variables = []
    # JAX returns dictionaries sorted by their keys.
    for name in quantities:
        quantity, value = find_quantity(name), shapes.values[name]
        variables.append(
            _variable(
                name,
                quantity,
                value,
                stages,
                {
                    "units": quantity.unit,
                    "long_name": quantity.description,
                    "symbol": quantity.symbol,
                },
            )
        )
    for name, by in itertools.product(quantities, gradients):
        quantity, parameter = find_quantity(name), find_parameters(mechanism, by)[0]
        value = shapes.derivatives[name, by]
        variables.append(
            _variable(
                derivative_name(name, by),
                quantity,
                value,
                stages,
                {
                    "units": f"({quantity.unit})/({parameter.unit})",
                    "long_name": f"derivative of {quantity.description} by {by}",
                    "symbol": f"∂{quantity.symbol}/∂{by}",
                },
            )
        )
    # A derived number that an axis makes explicit has margins too.
    first = {axis.name: axis.values[0] for axis in plan.axes}
    names = error_names(set_parameters(mechanism, first, checked=False))
    flag = np.dtype(np.int8)
    variables += [
        Variable(
            "failed",
            (),
            (),
            np.dtype(bool),
            True,
            {"long_name": "whether a design failed; see code"},
        ),
        Variable("code", (), (), flag, NOT_COMPUTED, _flags("why a design failed", REASONS)),
        Variable(
            "error",
            (),
            (),
            flag,
            0,
            _flags("first error that check finds in a design", ("none", *names)),
        ),
    ]
    return tuple(variables)


def _variable(
    name: str, quantity: Quantity, value, stages: int, attributes: dict[str, Any]
) -> Variable:
    own = value.shape[1:]
    return Variable(
        name, _dimensions(quantity, own, stages), own, np.dtype(value.dtype), np.nan, attributes
    )


def _flags(description: str, words: Iterable[str]) -> dict[str, Any]:
    """Attributes of codes, as in the conventions for climate and forecast metadata."""
    words = tuple(words)
    return {
        "long_name": description,
        "flag_values": list(range(len(words))),
        "flag_meanings": " ".join(words),
    }


def _dimensions(quantity: Quantity, shape: tuple[int, ...], stages: int) -> tuple[str, ...]:
    """Names of a quantity's own dimensions; only stages are shared between quantities."""
    names = []
    for index, length in enumerate(shape):
        known = quantity.dimensions[index] if index < len(quantity.dimensions) else f"{index + 1}"
        shared = known == "stage" and length == stages
        names.append(known if shared else f"{quantity.name}_{known}")
    return tuple(names)


def arrays_of(plan_shape: tuple[int, ...], results: BlockResults) -> dict[str, np.ndarray]:
    """Arrays of a block by the names of `variables_of`, shaped as the block."""
    named = dict(results.values)
    named |= {derivative_name(*key): value for key, value in results.derivatives.items()}
    named |= {"code": results.code, "error": results.error}
    arrays = {
        name: np.asarray(value).reshape(*plan_shape, *value.shape[1:])
        for name, value in named.items()
    }
    for name in ("code", "error"):
        arrays[name] = arrays[name].astype(np.int8)
    arrays["failed"] = arrays["code"] != 0
    return arrays


def empty_dataset(
    mechanism: Mechanism,
    plan: Plan,
    variables: tuple[Variable, ...],
    point: dict[str, float | None],
) -> "xarray.Dataset":
    """The data set without its variables: coordinates and attributes.

    **Arguments:**

    - `mechanism`, `plan`: as above.
    - `variables`: its arrays.
    - `point`: `speed` and `load` [rad/s, N] that were given for all designs, or `None`.
    """
    import xarray

    coordinates: dict[str, Any] = {
        axis.name: (
            axis.name if plan.kind == "grid" else plan.dimensions,
            axis.values,
            {"units": axis.unit, "long_name": axis.description},
        )
        for axis in plan.axes
    }
    if any("stage" in variable.own_dimensions for variable in variables):
        numbers = np.arange(1, len(mechanism.stages) + 1)
        coordinates["stage"] = ("stage", numbers, {"long_name": "number of the stage"})
    attributes: dict[str, Any] = {
        "title": mechanism.title,
        "plan": plan.kind,
        "points": plan.points,
        "prsm_jax_version": __version__,
    }
    attributes |= {name: value for name, value in point.items() if value is not None}
    return xarray.Dataset({}, coordinates, attributes)


class CodeCounts(NamedTuple):
    """Number of designs of a sweep with each code, by the meaning of the code."""

    #: Designs that are not computed yet.
    missing: int
    #: Designs that failed, by the reason.
    reasons: dict[str, int]
    #: Designs that did not fail, by the first error that `check` finds in them.
    errors: dict[str, int]


def count_codes(data: "xarray.Dataset") -> CodeCounts:
    """Count the codes of a sweep, piece by piece, so that memory does not grow with the designs.

    **Arguments:**

    - `data`: a sweep, as `sweep` returns it or `open_store` opens it.

    **Returns:** a `CodeCounts`.
    """
    names = {key: str(data[key].attrs["flag_meanings"]).split() for key in ("code", "error")}
    counts = {key: np.zeros(len(words), int) for key, words in names.items()}
    dimensions = tuple(map(str, data["code"].dims))
    blocks = blocks_of(data["code"].shape, _PIECE)
    for number in range(len(blocks)):
        where = dict(zip(dimensions, blocks.slices(number), strict=True))
        code, error = (data[key].isel(where).values.ravel() for key in ("code", "error"))
        counts["code"] += np.bincount(code, minlength=len(names["code"]))
        counts["error"] += np.bincount(error[code == 0], minlength=len(names["error"]))
    reasons, errors = (
        {word: int(n) for word, n in list(zip(names[key], counts[key], strict=True))[1:] if n}
        for key in ("code", "error")
    )
    return CodeCounts(reasons.pop("not_computed", 0), reasons, errors)
