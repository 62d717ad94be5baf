"""Functions of a mechanism in place of names of quantities."""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array

from .._errors import MissingDataError
from ..mechanism import Mechanism, OperatingPoint
from ..programs import origin_of
from ._analysis import Analysis

#: Name of a function that has none.
_NAMELESS = "function"


@dataclass(frozen=True)
class OfMechanism:
    """A function of a mechanism as a function of an `Analysis`."""

    name: str
    function: Callable[[Mechanism], Any]

    def __call__(self, analysis: Analysis) -> Array:
        value = jnp.asarray(self.function(_at_point(analysis)))
        if value.ndim:
            raise ValueError(
                f"the function {self.name} returns an array of shape {value.shape}; a quantity is "
                "one number of each design"
            )
        return value


def _at_point(analysis: Analysis) -> Mechanism:
    """The mechanism, with the operating point of the analysis as its own, if there is one."""
    mechanism, before = analysis.mechanism, analysis.mechanism.operating_point
    try:
        speed, load = analysis.speed, analysis.signed_load
    except MissingDataError:
        return mechanism
    point = OperatingPoint(speed, load, None if before is None else before.duration)
    return dataclasses.replace(mechanism, operating_point=point)


def name_of_function(
    function: Callable[..., Any], known: Mapping[str, OfMechanism], taken: Mapping[str, Any]
) -> str:
    """The name under which a function is a quantity: its own, made unique.

    A function of the same module and name may be defined again, as when a cell of a notebook is run
    twice. Functions inside functions, and those without a name, are numbered.

    **Arguments:**

    - `function`: of a mechanism, to one number.
    - `known`: functions that have names already.
    - `taken`: names that no function can have.

    **Raises:** `ValueError` for a name that is taken.
    """
    for name, one in known.items():
        if one.function is function:
            return name
    own = getattr(function, "__name__", _NAMELESS)
    own = own if own.isidentifier() else _NAMELESS
    if own in taken:
        raise ValueError(
            f"the function {own} has the name of a quantity; rename it, or name the quantity "
            f"{own!r} itself"
        )
    name, number = own, 1
    while name in taken or (name in known and not _again(known[name].function, function)):
        number += 1
        name = f"{own}_{number}"
    return name


def _again(before: Callable[..., Any], function: Callable[..., Any]) -> bool:
    """Whether a function is the same definition, run once more."""
    if not (hasattr(before, "__qualname__") and hasattr(function, "__qualname__")):
        return False
    return "<" not in function.__qualname__ and origin_of(before) == origin_of(function)
