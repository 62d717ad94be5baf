"""The catalogue of quantities: the vocabulary of sensitivities, optimisation, sweeps, reports."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import jax
import numpy as np
from jaxtyping import Array

from .._errors import UnknownNameError, closest
from ..fields import listed_names
from ..mechanism import Mechanism, of_designs
from ..programs import origin_of
from ._analysis import Analysis, SharedLoad
from ._assumptions import known_assumption, sentences
from ._functions import FunctionName, OfMechanism, name_of_function, numbered, of_mechanism


@dataclass(frozen=True)
class Quantity:
    """A quantity with its name, symbol, SI unit, description and function of an `Analysis`.

    `dimensions` names the axes of its value: none for a number, `stage` or `mode` for an array;
    `assumes` the assumptions that its value may depend on (see `assumptions`), `shares` the loads
    whose distribution among the threads it needs, in stages that model load sharing.
    """

    name: str
    symbol: str
    unit: str
    description: str
    function: Callable[[Analysis], Array]
    dimensions: tuple[str, ...] = ()
    assumes: tuple[str, ...] = ()
    shares: tuple[SharedLoad, ...] = ()

    @property
    def holds_traced(self) -> bool:
        """Whether its function holds a traced number, so that no program of it can be kept."""
        return isinstance(self.function, OfMechanism) and self.function.holds_traced


#: A name from the catalogue, or a function of a mechanism that returns one number [SI]; or one of
#: an `Analysis` that is in the catalogue.
QuantityLike: TypeAlias = str | Callable[..., Any]

_CATALOGUE: dict[str, Quantity] = {}
#: Functions of a mechanism that were given in place of a name, the last one of each name;
#: `catalogue` does not list them.
_FUNCTIONS: dict[str, Quantity] = {}


def quantity(
    name: str,
    symbol: str,
    unit: str,
    description: str,
    dimensions: tuple[str, ...] = (),
    *,
    assumes: tuple[str, ...] = (),
    shares: tuple[SharedLoad, ...] = (),
) -> Callable[[Callable[[Analysis], Array]], Callable[[Analysis], Array]]:
    """Add a function of an `Analysis` to the catalogue; use it to add your own quantity.

    **Arguments:**

    - `name`, `symbol`, `unit`, `description`, `dimensions`: as in `Quantity`.
    - `assumes`: names of assumptions that its value may depend on.
    - `shares`: loads for which it calls `Analysis.distribution`; if they are declared here, one
      program solves those of all quantities.

    A function of the same module and name may be defined again, as when a cell of a notebook is run
    twice; the last one counts.

    **Raises:** `ValueError` if the name is taken, or an assumption is not known.
    """
    known = tuple(known_assumption(one) for one in assumes)

    def register(function: Callable[[Analysis], Array]) -> Callable[[Analysis], Array]:
        before = _CATALOGUE.get(name)
        if before is not None and origin_of(before.function) != origin_of(function):
            raise ValueError(f"the quantity {name!r} exists already; choose another name")
        if before is not None:
            _forget_programs()
        _CATALOGUE[name] = Quantity(
            name, symbol, unit, description, function, dimensions, known, shares
        )
        return function

    return register


def catalogue() -> tuple[Quantity, ...]:
    """All known quantities, in the order in which they were added."""
    return tuple(_CATALOGUE.values())


def quantity_name(quantity: QuantityLike) -> str:
    """The name of a quantity that is given by its name or as a function.

    **Arguments:**

    - `quantity`: a name; a function of a mechanism that returns one number, which is known by its
      own name as long as it exists, and no other one of this name is given; or a function that
      `quantity` has added to the catalogue.

    **Raises:** `ValueError` for a function with the name of another quantity.
    """
    if isinstance(quantity, FunctionName) or not (isinstance(quantity, str) or callable(quantity)):
        return quantity
    if isinstance(quantity, str):
        function = _function_named(quantity)
        return quantity if function is None else FunctionName(quantity, function)
    for entry in _CATALOGUE.values():
        if entry.function is quantity:
            return entry.name
    name = name_of_function(quantity, _CATALOGUE)
    _of_function(name)
    return name


def quantity_names(quantities: Iterable[QuantityLike]) -> tuple[str, ...]:
    """The names of several quantities in one call.

    Those of different functions that have one name are numbered: `cost`, `cost_2`.

    **Raises:** as `quantity_name`.
    """
    names = numbered(map(quantity_name, quantities), _CATALOGUE)
    for name in names:
        if isinstance(name, FunctionName):
            _of_function(name)
    return tuple(names)


def _function_named(name: str) -> Callable[..., Any] | None:
    """The function that was given last under a name, if it still exists."""
    entry = _FUNCTIONS.get(name)
    if entry is None or name in _CATALOGUE:
        return None
    return entry.function.reference() if isinstance(entry.function, OfMechanism) else None


def _of_function(name: FunctionName) -> Quantity:
    """The quantity that a function stands for, and from now on its name."""
    words = (name.function.__doc__ or "").strip().partition("\n")[0]
    text = str(name)
    entry = Quantity(
        text, text, "1", words or "function of the mechanism", of_mechanism(text, name.function)
    )
    _FUNCTIONS[text] = entry
    return replace(entry, name=name)


def _forget_programs() -> None:
    """Compile all programs again: sensitivities, sweeps and searches keep theirs by name."""
    jax.clear_caches()


def is_function(name: str) -> bool:
    """Whether a quantity is a function that was given in place of a name."""
    return name in _FUNCTIONS and name not in _CATALOGUE


def find_quantity(name: QuantityLike) -> Quantity:
    """The quantity of a name, or of a function (`quantity_name`).

    **Raises:** `UnknownNameError` with the nearest names.
    """
    name = quantity_name(name)
    if isinstance(name, FunctionName):
        return _of_function(name)
    if is_function(name):
        return _FUNCTIONS[name]
    if name not in _CATALOGUE:
        raise UnknownNameError(f"unknown quantity {name!r}; {closest(name, _CATALOGUE)}")
    return _CATALOGUE[name]


def quantity_of(label: str) -> Quantity:
    """The quantity of a name or of a component's label, such as `rating_life[1]`.

    **Raises:** `UnknownNameError` with the nearest names.
    """
    if isinstance(label, FunctionName):
        return find_quantity(label)
    return find_quantity(label.partition("[")[0])


def named_quantities(
    names: Iterable[QuantityLike], argument: str = "quantities"
) -> tuple[Quantity, ...]:
    """The quantities of a list of names, each once.

    **Raises:** `ValueError` for a text in place of a list, and for an empty list;
    `UnknownNameError` for an unknown name.
    """
    listed = quantity_names(listed_names(names, argument))
    selected = tuple(dict.fromkeys(map(find_quantity, listed)))
    if not selected:
        raise ValueError(f"{argument} is empty; name at least one")
    return selected


@of_designs
def assumptions(mechanism: Mechanism, quantities: Iterable[str] | None = None) -> tuple[str, ...]:
    """Assumptions behind the numbers of a mechanism, such as equal load sharing, as sentences.

    Nothing is evaluated; the sentences depend only on the parts of the mechanism.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `quantities`: names from the catalogue, also of components (`rating_life[1]`); default all.

    **Returns:** the sentences, each once; none for results whose data the mechanism lacks.

    **Raises:** `UnknownNameError` for an unknown name.
    """
    names = _CATALOGUE if quantities is None else quantities
    declared = [one for name in names for one in quantity_of(name).assumes]
    return sentences(mechanism, dict.fromkeys(declared))


def component_names(name: str, shape: tuple[int, ...]) -> list[str]:
    """Names of the numbers in a value: the quantity itself, or `name[1]`, `name[2]`, …"""
    if not shape:
        return [name]
    return [f"{name}[{','.join(str(i + 1) for i in index)}]" for index in np.ndindex(*shape)]
