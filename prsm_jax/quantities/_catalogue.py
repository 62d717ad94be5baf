"""The catalogue of quantities: the vocabulary of sensitivities, optimisation, sweeps, reports."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Int

from .._errors import MissingDataError, UnknownNameError, closest
from ..fields import Scalar, listed_names
from ..mechanism import Mechanism, of_one_design
from ..programs import one_program, origin_of, stored_facts
from ._analysis import Analysis, SharedLoad
from ._assumptions import known_assumption, sentences
from ._functions import OfMechanism, name_of_function
from ._reasons import REASONS, code_of


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


#: A name from the catalogue, or a function of a mechanism that returns one number [SI]; or one of
#: an `Analysis` that is in the catalogue.
QuantityLike: TypeAlias = str | Callable[..., Any]

_CATALOGUE: dict[str, Quantity] = {}
#: Functions of a mechanism that were given in place of a name; `catalogue` does not list them.
_FUNCTIONS: dict[str, OfMechanism] = {}


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
      own name from then on; or a function that `quantity` has added to the catalogue.

    **Raises:** `ValueError` for a function with the name of another quantity.
    """
    if isinstance(quantity, str) or not callable(quantity):
        return quantity
    for entry in _CATALOGUE.values():
        if entry.function is quantity:
            return entry.name
    name = name_of_function(quantity, _FUNCTIONS, _CATALOGUE)
    if name in _FUNCTIONS and _FUNCTIONS[name].function is not quantity:
        _forget_programs()
    _FUNCTIONS[name] = OfMechanism(name, quantity)
    return name


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
    if is_function(name):
        function = _FUNCTIONS[name]
        words = (function.function.__doc__ or "").strip().partition("\n")[0]
        return Quantity(name, name, "1", words or "function of the mechanism", function)
    if name not in _CATALOGUE:
        raise UnknownNameError(f"unknown quantity {name!r}; {closest(name, _CATALOGUE)}")
    return _CATALOGUE[name]


def quantity_of(label: str) -> Quantity:
    """The quantity of a name or of a component's label, such as `rating_life[1]`.

    **Raises:** `UnknownNameError` with the nearest names.
    """
    return find_quantity(label.partition("[")[0])


def named_quantities(
    names: Iterable[QuantityLike], argument: str = "quantities"
) -> tuple[Quantity, ...]:
    """The quantities of a list of names, each once.

    **Raises:** `ValueError` for a text in place of a list, and for an empty list;
    `UnknownNameError` for an unknown name.
    """
    selected = tuple(dict.fromkeys(map(find_quantity, listed_names(names, argument))))
    if not selected:
        raise ValueError(f"{argument} is empty; name at least one")
    return selected


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


@of_one_design
def compute(
    mechanism: Mechanism,
    quantities: Iterable[QuantityLike],
    *,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
) -> dict[str, Array]:
    """Evaluate quantities by name, and only what they need.

    Jittable, differentiable and vmappable over a batched mechanism.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `quantities`: names from the catalogue; a function of a mechanism that returns one number may
      stand for a name, and its value has its own name.
    - `speed`, `load`: operating point [rad/s, N]; default that of the mechanism.

    **Raises:** `UnknownNameError` for an unknown name; `MissingDataError`, naming the quantity,
    where the mechanism lacks data for it.
    """
    return _computed(mechanism, quantities, speed, load)[0]


@of_one_design
def compute_checked(
    mechanism: Mechanism,
    quantities: Iterable[str],
    *,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
) -> tuple[dict[str, Array], Bool[Array, ""]]:
    """As `compute`, and whether the values can be used.

    The flag is false where the threads do not mesh, a contact force would be tensile, or a solver
    found no solution, even if the values look plausible; and where a value is NaN or infinite. It
    covers only what the quantities needed.
    """
    return _computed(mechanism, quantities, speed, load, _valid)


@of_one_design
def compute_coded(
    mechanism: Mechanism,
    quantities: Iterable[str],
    *,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
) -> tuple[dict[str, Array], Int[Array, ""]]:
    """As `compute`, and why the values cannot be used: a code, whose reason is in `REASONS`.

    The code is 0 where they can; a value that is not finite has its own code.
    """
    return _computed(mechanism, quantities, speed, load, _code)


def _find_all(quantities: Iterable[QuantityLike]) -> tuple[Quantity, ...]:
    # Programs are cached by quantity, not by name: a name may be redefined.
    return tuple(dict.fromkeys(find_quantity(name) for name in quantities))


def _computed(
    mechanism: Mechanism,
    quantities: Iterable[QuantityLike],
    speed,
    load,
    verdict: Callable[..., Any] | None = None,
) -> tuple[dict[str, Array], Any]:
    """Values by name, in the requested order, and a verdict on the analysis and its values."""
    selected = _find_all(quantities)
    values, judged = _program(mechanism, selected, speed, load, verdict)
    return {entry.name: value for entry, value in zip(selected, values, strict=True)}, judged


@one_program
def _program(
    mechanism: Mechanism,
    selected: tuple[Quantity, ...],
    speed,
    load,
    verdict: Callable[..., Any] | None,
):
    analysis = Analysis(mechanism, speed, load)
    values = _evaluated(analysis, selected)
    # A tuple: a compiled program does not preserve the order of a dictionary.
    return tuple(values.values()), None if verdict is None else verdict(analysis, values)


def evaluate_checked(
    analysis: Analysis, quantities: Iterable[str]
) -> tuple[dict[str, Array], Bool[Array, ""]]:
    """As `compute_checked`, for an analysis that computes more in the same program."""
    values = evaluate(analysis, quantities)
    return values, _valid(analysis, values)


def _valid(analysis: Analysis, values: dict[str, Array]) -> Bool[Array, ""]:
    return analysis.valid & _finite(values)


def evaluate_coded(
    analysis: Analysis, quantities: Iterable[str]
) -> tuple[dict[str, Array], Int[Array, ""]]:
    """As `compute_coded`, for an analysis that computes more in the same program."""
    values = evaluate(analysis, quantities)
    return values, _code(analysis, values)


def _code(analysis: Analysis, values: dict[str, Array]) -> Int[Array, ""]:
    code = code_of(analysis)
    return jnp.where((code == 0) & ~_finite(values), REASONS.index("not_finite"), code)


def _finite(values: dict[str, Array]) -> Bool[Array, ""]:
    return jnp.stack([jnp.isfinite(value).all() for value in values.values()]).all()


def evaluate(analysis: Analysis, quantities: Iterable[str]) -> dict[str, Array]:
    """Evaluate quantities of an analysis that may compute more in the same program.

    **Arguments:**

    - `analysis`: analysis of the mechanism.
    - `quantities`: names from the catalogue.

    **Raises:** as `compute`.
    """
    return _evaluated(analysis, _find_all(quantities))


def _evaluated(analysis: Analysis, selected: Iterable[Quantity]) -> dict[str, Array]:
    values = {}
    analysis.expect(load for entry in selected for load in entry.shares)
    for entry in selected:
        name = entry.name
        try:
            values[name] = entry.function(analysis)
        except MissingDataError as error:
            raise MissingDataError(f"quantity {name!r}: {error}") from error
    return values


@of_one_design
def available_quantities(
    mechanism: Mechanism,
    among: Iterable[str] | None = None,
    *,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
) -> tuple[str, ...]:
    """Names of the quantities that a mechanism has the data for (nothing is evaluated).

    **Arguments:**

    - `mechanism`: the mechanism.
    - `among`: names to choose from; default the whole catalogue.
    - `speed`, `load`: operating point that will be given [rad/s, N].

    **Raises:** `UnknownNameError` for an unknown name in `among`.
    """
    candidates = tuple(find_quantity(name) for name in (_CATALOGUE if among is None else among))
    names = tuple(candidate.name for candidate in candidates)
    # Which data exist depends only on the structure; a trace takes seconds.
    return stored_facts("available", _available, mechanism, speed, load, names, by=candidates)


def _available(
    mechanism: Mechanism, speed: Scalar | None, load: Scalar | None, among: tuple[str, ...]
) -> tuple[str, ...]:
    names: list[str] = []
    candidates = [find_quantity(name) for name in among]

    def try_all(mechanism: Mechanism, speed, load):
        # One trace for all: quantities share their intermediate results.
        analysis = Analysis(mechanism, speed, load)
        for candidate in candidates:
            try:
                candidate.function(analysis)
            except MissingDataError:
                continue
            names.append(candidate.name)

    eqx.filter_eval_shape(try_all, mechanism, speed, load)
    return tuple(names)


def component_names(name: str, shape: tuple[int, ...]) -> list[str]:
    """Names of the numbers in a value: the quantity itself, or `name[1]`, `name[2]`, …"""
    if not shape:
        return [name]
    return [f"{name}[{','.join(str(i + 1) for i in index)}]" for index in np.ndindex(*shape)]


__all__ = [
    "Quantity",
    "assumptions",
    "available_quantities",
    "catalogue",
    "component_names",
    "compute",
    "compute_checked",
    "compute_coded",
    "evaluate",
    "evaluate_checked",
    "evaluate_coded",
    "find_quantity",
    "quantity",
]
