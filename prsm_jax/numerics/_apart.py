"""Parts of a program that XLA compiles by themselves."""

import functools
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.core import Tracer
from jax.extend.core import jaxpr_as_fun

_Given = ParamSpec("_Given")
_Found = TypeVar("_Found")


def apart(function: Callable[_Given, _Found]) -> Callable[_Given, _Found]:
    """Have a function compiled as a part of its own inside a larger program.

    XLA on a CPU fuses what consumes a value into what makes it, and computes the maker anew for
    each consumer; its search for what to fuse grows faster than the program. It does neither across
    a condition, so the function becomes the branch of one whose outcome is hidden from the
    compiler. The other branch is NaN and never taken. Values and derivatives are those of the
    function itself; outside a trace it is called as it is.

    **Arguments:**

    - `function`: a pure function; what it takes and gives are pytrees of arrays and anything else.
      It must not use traced values other than its arguments.
    """

    plain: Callable[..., Any] = function

    @functools.wraps(function)
    def run(*args: _Given.args, **kwargs: _Given.kwargs) -> _Found:
        numbers, others = eqx.partition((args, kwargs), eqx.is_array)
        leaves, structure = jax.tree.flatten(numbers)
        if not any(isinstance(leaf, Tracer) for leaf in leaves):
            return function(*args, **kwargs)
        found: list[Any] = []

        def of_numbers(*leaves):
            args, kwargs = eqx.combine(jax.tree.unflatten(structure, leaves), others)
            numbers, rest = eqx.partition(plain(*args, **kwargs), eqx.is_array)
            leaves, found[:] = jax.tree.leaves(numbers), (jax.tree.structure(numbers), rest)
            return leaves

        traced = jax.make_jaxpr(of_numbers)(*leaves)
        outcome = jax.lax.optimization_barrier(jnp.asarray(True))
        results = jax.lax.cond(
            outcome,
            jaxpr_as_fun(traced),
            lambda *_: [_none(value) for value in traced.out_avals],
            *leaves,
        )
        return eqx.combine(jax.tree.unflatten(found[0], results), found[1])

    return run


def _none(value) -> jax.Array:
    inexact = jnp.issubdtype(value.dtype, jnp.inexact)
    return jnp.full(value.shape, jnp.nan if inexact else 0, value.dtype)
