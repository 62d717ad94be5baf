"""Functions of a mechanism in place of names of quantities."""

import dataclasses
import functools
import types
import weakref
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
from jax.core import Tracer
from jaxtyping import Array

from .._errors import MissingDataError, UnknownNameError
from ..mechanism import Mechanism, OperatingPoint
from ._analysis import Analysis

#: Name of a function that has none.
_NAMELESS = "function"


class FunctionName(str):
    """The name of a function that stands for a quantity, with the function.

    It equals the same text. Names of two functions differ even if their texts do not, so that a
    program that is kept by name is not that of another function. Pickled, it is a text.
    """

    function: Callable[..., Any]

    def __new__(cls, text: str, function: Callable[..., Any]) -> "FunctionName":
        name = super().__new__(cls, text)
        name.function = function
        return name

    @property
    def holds_traced(self) -> bool:
        """Whether the function holds a traced number, so that no program of it can be kept."""
        return holds_traced(self.function)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, FunctionName) and not _same(other.function, self.function):
            return False
        return str.__eq__(self, other) is True

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return str.__hash__(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return str, (str(self),)

    def __deepcopy__(self, memo: object) -> "FunctionName":
        return self


@dataclass(frozen=True)
class OfMechanism:
    """A function of a mechanism as a function of an `Analysis`.

    `reference` returns the function, or `None` when nothing else holds it any more: a compiled
    program must not keep what a function of a user holds.
    """

    name: str
    reference: Callable[[], Callable[[Mechanism], Any] | None]

    @property
    def function(self) -> Callable[[Mechanism], Any]:
        """The function itself.

        **Raises:** `UnknownNameError` if it does not exist any more.
        """
        function = self.reference()
        if function is None:
            raise UnknownNameError(
                f"the function {self.name} does not exist any more; give the function itself, not "
                "its name"
            )
        return function

    @property
    def holds_traced(self) -> bool:
        """As that of `FunctionName`."""
        return holds_traced(self.function)

    def __call__(self, analysis: Analysis) -> Array:
        value = jnp.asarray(self.function(_at_point(analysis)))
        if value.ndim:
            raise ValueError(
                f"the function {self.name} returns an array of shape {value.shape}; a quantity is "
                "one number of each design"
            )
        return value


def holds_traced(function: Any) -> bool:
    """Whether a function, or one that it holds, holds a traced number."""
    seen: set[int] = set()
    waiting = [function]
    while waiting:
        one = waiting.pop()
        if id(one) in seen:
            continue
        seen.add(id(one))
        for held in _held(one):
            if any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(held)):
                return True
            if callable(held):
                waiting.append(held)
    return False


def _held(function: Any) -> list[Any]:
    """What a function holds beside its arguments."""
    if isinstance(function, functools.partial):
        return [function.func, *function.args, *function.keywords.values()]
    if isinstance(function, types.MethodType):
        return [function.__func__, *getattr(function.__self__, "__dict__", {}).values()]
    if isinstance(function, types.FunctionType):
        # A cell is empty before the name around the function has a value.
        cells = [cell for cell in function.__closure__ or () if cell != types.CellType()]
        return [*(cell.cell_contents for cell in cells), *(function.__defaults__ or ())]
    return []


@dataclass(frozen=True)
class _Always:
    """A reference to what cannot be referred to weakly, such as a method of an object."""

    function: Callable[..., Any]

    def __call__(self) -> Callable[..., Any]:
        return self.function


def of_mechanism(name: str, function: Callable[..., Any]) -> OfMechanism:
    """The function of an `Analysis`; it does not keep a plain function or a `lambda` alive."""
    plain = isinstance(function, types.FunctionType)
    return OfMechanism(name, weakref.ref(function) if plain else _Always(function))


def _at_point(analysis: Analysis) -> Mechanism:
    """The mechanism, with the operating point of the analysis as its own, if there is one."""
    mechanism, before = analysis.mechanism, analysis.mechanism.operating_point
    try:
        speed, load = analysis.speed, analysis.signed_load
    except MissingDataError:
        return mechanism
    point = OperatingPoint(speed, load, None if before is None else before.duration)
    return dataclasses.replace(mechanism, operating_point=point)


def name_of_function(function: Callable[..., Any], taken: Mapping[str, Any]) -> FunctionName:
    """The name under which a function is a quantity: its own.

    **Arguments:**

    - `function`: of a mechanism, to one number.
    - `taken`: names that no function can have.

    **Raises:** `ValueError` for a name that is taken.
    """
    own = getattr(function, "__name__", _NAMELESS)
    own = own if own.isidentifier() else _NAMELESS
    if own in taken:
        raise ValueError(
            f"the function {own} has the name of a quantity; rename it, or name the quantity "
            f"{own!r} itself"
        )
    return FunctionName(own, function)


def numbered(names: Iterable[str], taken: Mapping[str, Any]) -> list[str]:
    """Names of one call, of which those of different functions with the same text are numbered.

    **Arguments:**

    - `names`: the names, in the order in which they were given.
    - `taken`: names that no function can have.

    **Returns:** the names: `cost`, `cost_2`, `cost_3`, …
    """
    found: list[str] = []
    used: dict[str, Callable[..., Any]] = {}
    for name in names:
        if isinstance(name, FunctionName):
            text, number = str(name), 1
            while text in taken or not _same(used.get(text, name.function), name.function):
                number += 1
                text = f"{name}_{number}"
            used[text] = name.function
            name = FunctionName(text, name.function)
        found.append(name)
    return found


def _same(one: Callable[..., Any], other: Callable[..., Any]) -> bool:
    # A method is a new object whenever it is read; other objects may compare by their numbers.
    methods = isinstance(one, types.MethodType) and isinstance(other, types.MethodType)
    return one is other or (methods and one == other)
