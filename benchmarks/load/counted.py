"""Work and memory of a program, counted in what JAX traces: no clock, the same on every machine."""

import math
from typing import Any, NamedTuple

import equinox as eqx
import jax
from jax.extend.core import ClosedJaxpr, Jaxpr


class Counted(NamedTuple):
    """What a program consists of.

    - `equations`: written in it; what compiling costs.
    - `operations`: numbers that it computes. Loops count by their trips; those that end by a
      condition, such as Newton's, count one trip.
    - `bytes`: of all numbers that it makes in one trip of each loop. No program takes more than
      this beside its arguments, and XLA's takes less: most of them are never stored.
    """

    equations: int
    operations: float
    bytes: float


def _inner(parameters: dict[str, Any]) -> list[Any]:
    """Programs in the parameters of an equation."""
    leaves = jax.tree.leaves(parameters, is_leaf=lambda leaf: isinstance(leaf, ClosedJaxpr))
    found = [getattr(leaf, "jaxpr", leaf) for leaf in leaves]
    return [leaf for leaf in found if isinstance(leaf, Jaxpr)]


def _of(jaxpr: Any) -> Counted:
    equations, operations, size = 0, 0.0, 0.0
    for equation in jaxpr.eqns:
        programs = [_of(inner) for inner in _inner(equation.params)]
        trips = equation.params["length"] if equation.primitive.name == "scan" else 1
        equations += 1 + sum(one.equations for one in programs)
        operations += trips * sum(one.operations for one in programs)
        size += sum(one.bytes for one in programs)
        shapes = [variable.aval for variable in equation.outvars]
        numbers = sum(math.prod(aval.shape) for aval in shapes)
        if equation.primitive.name == "dot_general":
            (contracted, _), _ = equation.params["dimension_numbers"]
            shape = equation.invars[0].aval.shape
            numbers *= 2 * math.prod(shape[axis] for axis in contracted)
        # The outputs of an equation with a program in it are those of the program, but for a loop
        # that collects them.
        if not programs:
            operations += numbers
        if not programs or equation.primitive.name == "scan":
            size += sum(math.prod(aval.shape) * aval.dtype.itemsize for aval in shapes)
    return Counted(equations, operations, size)


def counted(function: Any, *arguments: Any) -> Counted:
    """Count a function at its arguments; nothing is compiled or computed.

    **Arguments:**

    - `function`: of pytrees; may be compiled by `eqx.filter_jit`.
    - `arguments`: its arguments; what is no array is static.
    """
    closed, _, _ = eqx.filter_make_jaxpr(function)(*arguments)
    return _of(closed.jaxpr)
