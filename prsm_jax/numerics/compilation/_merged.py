"""Programs in which equal operations are merged.

XLA first moves operations whose operands do not change out of a loop. Two equal products then enter
the loop as different inputs, and operations that use them cannot be merged any more: a step of an
integration evaluated slip velocities and roots up to six times. So equal operations are merged when
the step is traced.
"""

import functools
from collections.abc import Callable, Hashable, Sequence
from typing import Any, ParamSpec, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, JaxprEqn, Literal, jaxpr_as_fun

from ._by_program import by_program
from ._pieces import CALLS

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")


def merged(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """A function in whose program equal operations are merged, also across calls by `jit`.

    Separate parts (`apart`), loops, and functions with derivatives of their own are merged as a
    whole, not inside. Values and derivatives are those of the function.

    **Arguments:**

    - `function`: a pure function; its arguments and results are pytrees of arrays and other
      objects. It must not use traced values other than its arguments.
    """

    @functools.wraps(function)
    def run(*args: _Parameters.args, **kwargs: _Parameters.kwargs) -> _Result:
        return by_program(function, _Evaluation(), args, kwargs)

    return run


class _Evaluation:
    """Evaluates programs, and looks up operations that it has evaluated before."""

    def __init__(self):
        self.results: dict[Hashable, list[Any]] = {}
        #: Keeps values alive, because they are known by their addresses.
        self.values: list[Any] = []

    def __call__(self, traced: ClosedJaxpr, arguments: Sequence[Any]) -> list[Any]:
        jaxpr = traced.jaxpr
        known: dict[Any, Any] = dict(zip(jaxpr.constvars, traced.consts, strict=True))
        known.update(zip(jaxpr.invars, arguments, strict=True))

        def value(atom):
            return atom.val if isinstance(atom, Literal) else known[atom]

        for equation in jaxpr.eqns:
            found = self._of(jaxpr, equation, [value(atom) for atom in equation.invars])
            known.update(zip(equation.outvars, found, strict=True))
        return [_as_array(value(atom), atom) for atom in jaxpr.outvars]

    def _of(self, jaxpr: Jaxpr, equation: JaxprEqn, values: list[Any]) -> list[Any]:
        primitive, parameters = equation.primitive, equation.params
        if primitive.name in CALLS and not _is_separate(equation):
            with jax.named_scope(str(equation.source_info.name_stack)):
                return self(parameters["jaxpr"], values)
        operands = tuple(
            (str(atom.aval), _name(value))
            for atom, value in zip(equation.invars, values, strict=True)
        )
        key: Hashable = primitive, tuple(sorted(parameters.items(), key=_first)), operands
        try:
            hash(key)
        except TypeError:
            # Parameters that cannot be compared: only the same equation of the same function.
            key = id(equation), operands
        if key in self.results and not equation.effects:
            return self.results[key]
        inputs = [atom for atom in equation.invars if not isinstance(atom, Literal)]
        unique = list(dict.fromkeys(inputs))
        alone = jaxpr.replace(
            constvars=[], invars=unique, outvars=equation.outvars, eqns=[equation]
        )
        given = {
            atom: value
            for atom, value in zip(equation.invars, values, strict=True)
            if not isinstance(atom, Literal)
        }
        results = jaxpr_as_fun(ClosedJaxpr(alone, []))(*(given[v] for v in unique))
        self.values += [*values, *results]
        self.results[key] = results
        return results


def _first(item: tuple[str, Any]) -> str:
    return item[0]


def _name(value: Any) -> Hashable:
    """The same for two values only if they are the same array, or equal numbers of one type."""
    if isinstance(value, jax.Array) or np.ndim(value):
        return id(value)
    number = np.asarray(value)
    return type(value), number.dtype, number.tobytes()


def _as_array(value: Any, atom: Any) -> jax.Array:
    """A result; constants among the results are numbers of Python or NumPy."""
    return value if isinstance(value, jax.Array) else jnp.asarray(value, atom.aval.dtype)


def _is_separate(equation: JaxprEqn) -> bool:
    metadata = equation.ctx.xla_metadata or {}
    return metadata.get("inlineable") == "false"


__all__ = ["merged"]
