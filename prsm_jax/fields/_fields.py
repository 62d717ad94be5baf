"""How numbers enter the mechanism: as scalar arrays that can be differentiated."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array

from ..numerics import Scalar as Scalar
from ._limits import ANY, Limit


def as_scalar(value) -> Array:
    """`value` as a floating-point array; an array that is floating-point keeps its dtype."""
    if isinstance(value, int | float):
        # An explicit dtype: a weakly typed leaf would compile everything a second time.
        return jnp.asarray(value, dtype=jnp.result_type(float))
    array = jnp.asarray(value)
    return array if jnp.issubdtype(array.dtype, jnp.floating) else array.astype(float)


def _as_optional_scalar(value):
    return None if value is None else as_scalar(value)


def _metadata(unit: str, description: str, limit: Limit | None, **more) -> dict:
    return {"unit": unit, "description": description, "limit": limit, **more}


def number(unit: str, description: str, *, limit: Limit | None = None, **kwargs):
    """A required number (a differentiable leaf), with its SI unit, meaning and limit as metadata.

    Without a limit, the limit of the unit applies: a length is positive, a force is finite.
    """
    return eqx.field(converter=as_scalar, metadata=_metadata(unit, description, limit), **kwargs)


def optional_number(
    unit: str, description: str, *, limit: Limit | None = None, law_decides: bool = False
):
    """A number that may be absent; `None` leaves the physics that needs it untraced.

    With `law_decides`, the law beside it determines whether the number is required.
    """
    return eqx.field(
        converter=_as_optional_scalar,
        default=None,
        metadata=_metadata(unit, description, limit, law_decides=law_decides),
    )


def part(without: str, **kwargs):
    """A part of the physics that may be absent; `None` leaves it untraced.

    `without` says what results lack then (`prsm_jax.explain`).
    """
    return eqx.field(default=None, metadata={"without": without}, **kwargs)


def _number_or_function(value):
    return value if callable(value) else as_scalar(value)


def driven(unit: str, description: str):
    """A number, or a function of time (of more variables for a load) in its place."""
    return eqx.field(converter=_number_or_function, metadata=_metadata(unit, description, ANY))


def _list(
    unit: str, description: str, limit: Limit | None, least: int, length: str, increasing: bool
) -> dict:
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
):
    """A required list of numbers (one differentiable leaf).

    **Arguments:**

    - `unit`, `description`, `limit`: of each number, as in `number`.
    - `least`: smallest number of entries.
    - `length`: another field: a whole number, the number of entries, or a list of the same length.
    - `increasing`: whether each number must be above the one before it.
    """
    metadata = _list(unit, description, limit, least, length, increasing)
    return eqx.field(converter=as_scalar, metadata=metadata)


def _as_optional_numbers(value):
    if value is None:
        return None
    array = as_scalar(value)
    return array[None] if array.ndim == 0 else array


def optional_numbers(unit: str, description: str, *, limit: Limit | None = None, length: str = ""):
    """A list of numbers (one differentiable leaf) that may be absent; `length` as in `numbers`."""
    metadata = _list(unit, description, limit, 1, length, False)
    return eqx.field(converter=_as_optional_numbers, default=None, metadata=metadata)


def choice(
    description: str,
    *,
    implied: bool = False,
    without: str | None = None,
    limit: Limit | None = None,
    **kwargs,
):
    """A static choice: part of the pytree's structure, never traced.

    The annotation declares what it may be: the words of a `Literal`, or a whole number with a
    limit. An `implied` choice is written to a file only if it is not the default. `without` says
    what results lack if the choice is absent.
    """
    metadata = {"description": description, "implied": implied, "limit": limit}
    if without is not None:
        metadata["without"] = without
    return eqx.field(static=True, metadata=metadata, **kwargs)
