"""Functions of pytrees, evaluated by the program of their numbers."""

from collections.abc import Callable, Sequence
from typing import Any

import equinox as eqx
import jax
from jax.extend.core import ClosedJaxpr


def by_program(
    function: Callable[..., Any],
    evaluate: Callable[[ClosedJaxpr, Sequence[Any]], Sequence[Any]],
    args: tuple[Any, ...],
    kwargs: dict[str, Any],
) -> Any:
    """The result of a function, whose program is evaluated in another way.

    **Arguments:**

    - `function`: a pure function; its arguments and results are pytrees of arrays and other
      objects. It must not use traced values other than its arguments.
    - `evaluate`: function of the program and its arguments to the results of the program.
    - `args`, `kwargs`: arguments of the function.
    """
    numbers, others = eqx.partition((args, kwargs), eqx.is_array)
    leaves, structure = jax.tree.flatten(numbers)
    output: list[Any] = []

    def of_numbers(*leaves):
        args, kwargs = eqx.combine(jax.tree.unflatten(structure, leaves), others)
        numbers, rest = eqx.partition(function(*args, **kwargs), eqx.is_array)
        leaves, output[:] = jax.tree.leaves(numbers), (jax.tree.structure(numbers), rest)
        return leaves

    results = evaluate(jax.make_jaxpr(of_numbers)(*leaves), leaves)
    return eqx.combine(jax.tree.unflatten(output[0], results), output[1])


__all__ = ["by_program"]
