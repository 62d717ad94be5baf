"""How numbers enter the mechanism: as scalar arrays that can be differentiated."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from ..numerics import Scalar as Scalar
from ._arguments import refuse_complex
from ._limits import ANY, Limit

if TYPE_CHECKING:
    _Held = TypeVar("_Held", covariant=True)
    _Given = TypeVar("_Given", contravariant=True)

    class Converted(Generic[_Held, _Given]):
        """Type of a field that takes one type and holds another: `Converted[held, taken]`."""

        def __get__(self, instance: object, owner: type | None = None) -> _Held: ...
        def __set__(self, instance: object, value: _Given) -> None: ...

else:

    class Converted:
        """Type of a field that takes one type and holds another: `Converted[held, taken]`.

        A type checker reads it as a descriptor, so that `Thread(lead=2e-3)` is right and
        `thread.lead` is an array; at run time it is the type that the field holds.
        """

        def __class_getitem__(cls, types: tuple[Any, Any]) -> Any:
            return types[0]


#: Field with one number: takes a Python number or an array, holds a scalar array.
Number: TypeAlias = Converted[Scalar, ArrayLike]
#: The same, or `None`.
OptionalNumber: TypeAlias = Converted[Scalar | None, ArrayLike | None]
#: Field with a list of numbers: holds an array of the shape (points,).
Numbers: TypeAlias = Converted[Float[Array, " points"], ArrayLike | Sequence[ArrayLike]]
#: Field with a number for each thread, or `None`.
OptionalNumbers: TypeAlias = Converted[
    Float[Array, " threads"] | None, ArrayLike | Sequence[ArrayLike] | None
]


def as_scalar(value: ArrayLike) -> Array:
    """`value` as a floating-point array; an array that is floating-point keeps its dtype.

    **Raises:** `ValueError` for a complex number.
    """
    if isinstance(value, int | float):
        # An explicit dtype: a weakly typed leaf would compile everything a second time.
        # By NumPy, because JAX compiles a program to change the type of a number.
        return jnp.asarray(np.asarray(value, dtype=jnp.result_type(float)))
    array = jnp.asarray(value)
    if jnp.issubdtype(array.dtype, jnp.floating):
        return array
    refuse_complex("a number", array)
    return array.astype(float)


def _as_numbers(value: Any) -> Array:
    # `ArrayLike | Sequence[ArrayLike]`: the annotation of the field says so. Here, a checker of
    # run-time types would look at an entry at random.
    return as_scalar(value if isinstance(value, int | float) else jnp.asarray(value))


def as_optional_scalar(value: ArrayLike | None) -> Array | None:
    """As `as_scalar`; `None` stays."""
    return None if value is None else as_scalar(value)


def _metadata(
    unit: str, description: str, limit: Limit | None, **more: object
) -> dict[str, object]:
    return {"unit": unit, "description": description, "limit": limit, **more}


def number(unit: str, description: str, *, limit: Limit | None = None, **kwargs: Any) -> Any:
    """A required number (a differentiable leaf), with its SI unit, meaning and limit as metadata.

    Without a limit, the limit of the unit applies: a length is positive, a force is finite.
    """
    return eqx.field(converter=as_scalar, metadata=_metadata(unit, description, limit), **kwargs)


def optional_number(
    unit: str, description: str, *, limit: Limit | None = None, law_decides: bool = False
) -> Any:
    """A number that may be absent; `None` leaves the physics that needs it untraced.

    With `law_decides`, the law beside it determines whether the number is required.
    """
    return eqx.field(
        converter=as_optional_scalar,
        default=None,
        metadata=_metadata(unit, description, limit, law_decides=law_decides),
    )


def part(without: str, **kwargs: Any) -> Any:
    """A part of the physics that may be absent; `None` leaves it untraced.

    `without` says what results lack then (`prsm_jax.explain`).
    """
    return eqx.field(default=None, metadata={"without": without}, **kwargs)


def _number_or_function(value: ArrayLike | Callable[..., Any]) -> Array | Callable[..., Any]:
    return value if callable(value) else as_scalar(value)


def driven(unit: str, description: str) -> Any:
    """A number, or a function of time (of more variables for a load) in its place."""
    return eqx.field(converter=_number_or_function, metadata=_metadata(unit, description, ANY))


def _list(
    unit: str, description: str, limit: Limit | None, least: int, length: str, increasing: bool
) -> dict[str, object]:
    rules = {"least": least, "length": length, "increasing": increasing}
    return _metadata(unit, description, limit, **rules)


def numbers(
    unit: str,
    description: str,
    *,
    limit: Limit | None = None,
    least: int = 1,
    length: str = "",
    increasing: bool = False,
) -> Any:
    """A required list of numbers (one differentiable leaf).

    **Arguments:**

    - `unit`, `description`, `limit`: of each number, as in `number`.
    - `least`: smallest number of entries.
    - `length`: another field: a whole number, the number of entries, or a list of the same length.
    - `increasing`: whether each number must be above the one before it.
    """
    metadata = _list(unit, description, limit, least, length, increasing)
    return eqx.field(converter=_as_numbers, metadata=metadata)


def _as_optional_numbers(value: Any) -> Array | None:
    if value is None:
        return None
    array = _as_numbers(value)
    return array[None] if array.ndim == 0 else array


def optional_numbers(
    unit: str, description: str, *, limit: Limit | None = None, length: str = ""
) -> Any:
    """A list of numbers (one differentiable leaf) that may be absent; `length` as in `numbers`."""
    metadata = _list(unit, description, limit, 1, length, False)
    return eqx.field(converter=_as_optional_numbers, default=None, metadata=metadata)


def choice(
    description: str,
    *,
    implied: bool = False,
    without: str | None = None,
    limit: Limit | None = None,
    converter: Callable[[Any], Any] | None = None,
    **kwargs: Any,
) -> Any:
    """A static choice: part of the pytree's structure, never traced.

    The annotation declares what it may be: the words of a `Literal`, or a whole number with a
    limit. An `implied` choice is written to a file only if it is not the default. `without` says
    what results lack if the choice is absent. Where the converter is `Count`, a sweep may put a
    traced number in place of the choice.
    """
    metadata = {"description": description, "implied": implied, "limit": limit}
    if without is not None:
        metadata["without"] = without
    if converter is not None:
        metadata["choice"] = True
        return eqx.field(converter=converter, metadata=metadata, **kwargs)
    return eqx.field(static=True, metadata=metadata, **kwargs)


def registered_choice(
    description: str, registered: Callable[[], Mapping[str, Any]], *, default: str
) -> Any:
    """A static choice by a word to which users may add; it is written if it is not the default.

    The field holds what the word stands for. It also takes a function without a word, which must be
    hashable; a file cannot hold that.

    **Arguments:**

    - `description`: what is chosen.
    - `registered`: returns what each word stands for now.
    - `default`: the word if none is given.
    """

    def converter(value: Any) -> Any:
        return registered().get(value, value) if isinstance(value, str) else value

    metadata = {"description": description, "implied": True, "registered": registered}
    return eqx.field(static=True, converter=converter, default=default, metadata=metadata)
