"""Arguments that many functions share."""

from collections.abc import Iterable
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float

_Name = TypeVar("_Name")


def listed_names(names: Iterable[_Name], argument: str) -> list[_Name]:
    """Names as a list.

    **Arguments:**

    - `names`: the names; a text alone, whose letters would be taken for names, is refused.
    - `argument`: what they are called in the message.

    **Raises:** `ValueError` for a text.
    """
    if isinstance(names, str):
        raise ValueError(f"{argument} is the text {names!r}; give a list of names")
    return list(names)


def refuse_options(of: str, options: Iterable[str], takes: Iterable[str], where: str = "") -> None:
    """Refuse an option that a method does not take.

    **Arguments:**

    - `of`: what the method is called in the message.
    - `options`: names of the options that were given.
    - `takes`: names of those that it takes.
    - `where`: under which condition, such as `" at a prescribed speed"`.

    **Raises:** `ValueError` for an option that is not in `takes`.
    """
    known = tuple(takes)
    for name in options:
        if name not in known:
            raise ValueError(
                f"{of} takes {', '.join(known) or 'no options'}{where}, but not {name}; "
                "leave it out"
            )


def refuse_complex(name: str, value: Any) -> None:
    """Refuse complex numbers, whose imaginary parts would be lost.

    **Arguments:**

    - `name`: what the argument is called in the message.
    - `value`: a number, an array, which may be traced, or a list of numbers.

    **Raises:** `ValueError` for a complex number.
    """
    if isinstance(value, list | tuple):
        for one in value:
            refuse_complex(name, one)
        return
    dtype = getattr(value, "dtype", None)
    if isinstance(value, complex) or getattr(dtype, "kind", "") == "c":
        known = not isinstance(value, Tracer)
        first = f": {np.ravel(value)[0]}" if known and np.size(value) else ""
        raise ValueError(f"{name} is complex{first}; give real numbers")


def listed_numbers(name: str, value: Any, plural: str, unit: str) -> Float[Array, " numbers"]:
    """One list of numbers, or one number, as an array; a traced one may hold any number.

    The array has the default type; numbers of another one are converted.

    **Arguments:**

    - `name`: of the argument.
    - `value`: what was given.
    - `plural`, `unit`: what the list holds, for the message.

    **Raises:** `ValueError` for anything else, complex numbers, and known numbers that are not
    finite.
    """
    dtype = jnp.result_type(float)
    remedy = f"give one list of {plural} [{unit}]"
    refuse_complex(name, value)
    known = not any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(value))
    try:
        if not known:
            array = jnp.atleast_1d(jnp.asarray(value, dtype))
        elif isinstance(value, str | bytes):
            raise TypeError
        else:
            array = np.atleast_1d(np.asarray(value, dtype))
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}; {remedy}") from None
    if array.ndim != 1:
        raise ValueError(
            f"{name} has the shape {array.shape}; {remedy}, or map the call by jax.vmap"
        )
    if isinstance(array, np.ndarray) and not np.isfinite(array).all():
        place = int(np.argmin(np.isfinite(array)))
        raise ValueError(f"{name} is {array[place]} at place {place + 1}; give finite numbers")
    return jnp.asarray(array)
