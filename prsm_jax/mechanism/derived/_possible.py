"""Whether the numbers of a part are in range, inside a trace, where no error can be raised."""

from collections.abc import Iterator

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from ...fields import ANY, Limit, declared


def _limited(module: eqx.Module) -> Iterator[tuple[Array, Limit]]:
    """The numbers of a part and of the parts in it that have a range, with their limits."""
    for one in declared(type(module)):
        value = getattr(module, one.name)
        for part in value if isinstance(value, tuple) else (value,):
            if isinstance(part, eqx.Module):
                yield from _limited(part)
        if one.unit is not None and eqx.is_inexact_array(value) and one.traced_limit != ANY:
            number: Array = jnp.asarray(value)
            yield number, one.traced_limit


def numbers_possible(module: eqx.Module) -> Bool[Array, ""]:
    """Whether every number of a part is in the range that applies to files.

    The check of `Limited` at construction, for traced numbers: a density above 0, Poisson's ratio
    below ½. Stiffnesses may have any sign, unless their fields declare a limit. NaN passes: results
    that depend on it are NaN.

    **Arguments:**

    - `module`: a stage, or any part of one.
    """
    # One comparison of all numbers; separate comparisons are a program of a hundred operations.
    values, lower, upper, at_lower, at_upper = [], [], [], [], []
    for value, limit in _limited(module):
        values.append(jnp.ravel(value))
        for ends, end in (
            (lower, limit.lower),
            (upper, limit.upper),
            (at_lower, limit.lower_allowed),
            (at_upper, limit.upper_allowed),
        ):
            ends += [end] * value.size
    if not values:
        return jnp.asarray(True)
    # A verdict has no derivative.
    every = jax.lax.stop_gradient(jnp.concatenate(values))
    low, high = jnp.asarray(lower, every.dtype), jnp.asarray(upper, every.dtype)
    below = jnp.where(jnp.asarray(at_lower), every < low, every <= low)
    above = jnp.where(jnp.asarray(at_upper), every > high, every >= high)
    return ~jnp.any(below | above)
