"""Parts of a program that XLA compiles separately."""

import functools
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import equinox as eqx
import jax
from jax.core import Tracer

from ._pieces import in_pieces

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")


def apart(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """Compile a function as a separate part of a larger program.

    XLA on a CPU fuses operations that use a value with the operations that compute it, and
    recomputes the value for each use; its search for fusions grows faster than the program. It does
    neither across a call that it does not replace by the operations of the function, so pieces of
    the function become such calls (`in_pieces`). Values and derivatives are those of the function
    itself; outside a trace it is called directly.

    **Arguments:**

    - `function`: a pure function; its arguments and results are pytrees of arrays and other
      objects. It must not use traced values other than its arguments.
    """

    plain: Callable[..., Any] = function

    @functools.wraps(function)
    def run(*args: _Parameters.args, **kwargs: _Parameters.kwargs) -> _Result:
        numbers, others = eqx.partition((args, kwargs), eqx.is_array)
        leaves, structure = jax.tree.flatten(numbers)
        if not any(isinstance(leaf, Tracer) for leaf in leaves):
            return function(*args, **kwargs)
        output: list[Any] = []

        def of_numbers(*leaves):
            args, kwargs = eqx.combine(jax.tree.unflatten(structure, leaves), others)
            numbers, rest = eqx.partition(plain(*args, **kwargs), eqx.is_array)
            leaves, output[:] = jax.tree.leaves(numbers), (jax.tree.structure(numbers), rest)
            return leaves

        traced = jax.make_jaxpr(of_numbers)(*leaves)
        results = in_pieces(traced)(*leaves)
        return eqx.combine(jax.tree.unflatten(output[0], results), output[1])

    return run
