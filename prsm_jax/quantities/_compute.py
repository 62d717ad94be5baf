"""Values of quantities of a mechanism, and which of them it has the data for."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from .._errors import MissingDataError
from ..fields import Scalar, listed_names
from ..mechanism import Mechanism, of_one_design
from ..programs import one_program, stored_facts
from ._analysis import Analysis
from ._catalogue import Quantity, QuantityLike, catalogue, find_quantity, quantity_names
from ._functions import OfMechanism
from ._reasons import REASONS, code_of


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
    quantities: Iterable[QuantityLike],
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
    quantities: Iterable[QuantityLike],
    *,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
) -> tuple[dict[str, Array], Int[Array, ""]]:
    """As `compute`, and why the values cannot be used: a code, whose reason is in `REASONS`.

    The code is 0 where they can; a value that is not finite has its own code.
    """
    return _computed(mechanism, quantities, speed, load, _code)


def _find_all(quantities: Iterable[QuantityLike]) -> tuple[Quantity, ...]:
    """**Raises:** `UnknownNameError` for an unknown name, or a function that no longer exists."""
    listed = quantity_names(listed_names(quantities, "quantities"))
    selected = tuple(dict.fromkeys(map(find_quantity, listed)))
    for entry in selected:
        if isinstance(entry.function, OfMechanism):
            _ = entry.function.function
    return selected


def _computed(
    mechanism: Mechanism,
    quantities: Iterable[QuantityLike],
    speed,
    load,
    verdict: Callable[..., Any] | None = None,
) -> tuple[dict[str, Array], Any]:
    """Values by name, in the requested order, and a verdict on the analysis and its values."""
    # Programs are cached by quantity, not by name: a name may be redefined.
    selected = _find_all(quantities)
    # A compiled program is kept, and must not keep the functions: its entries have plain names.
    entries = tuple(replace(entry, name=str(entry.name)) for entry in selected)
    values, judged = _program(mechanism, entries, speed, load, verdict)
    return {entry.name: value for entry, value in zip(entries, values, strict=True)}, judged


@one_program
def _program(
    mechanism: Mechanism,
    selected: tuple[Quantity, ...],
    speed: float | Scalar | None,
    load: float | Scalar | None,
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
        name = str(entry.name)
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
    listed = catalogue() if among is None else map(find_quantity, listed_names(among, "among"))
    candidates = tuple(listed)
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
