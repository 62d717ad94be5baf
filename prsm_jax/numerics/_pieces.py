"""Pieces of a program that XLA compiles separately, cut where few numbers pass between them."""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jax.extend.core import ClosedJaxpr, Jaxpr, Literal, Var, jaxpr_as_fun

#: Operations of a piece at most, without derivatives.
MOST_OPERATIONS = 40
#: Smallest piece as a share of the largest: in between, a cut is where it is narrowest.
_LEAST_SHARE = 0.5
#: These move or repeat numbers, without arithmetic.
_WITHOUT_ARITHMETIC = frozenset((
    "broadcast_in_dim", "convert_element_type", "copy", "reshape", "slice", "squeeze", "transpose",
))  # fmt: skip
#: Calls of which JAX writes the equations into the caller.
_CALLS = frozenset(("jit", "pjit", "closed_call", "core_call"))


def hidden(traced: ClosedJaxpr, arguments: Sequence[Any]) -> list[jax.Array]:
    """Results of a program as one branch of a condition whose outcome XLA does not know.

    XLA neither fuses nor recomputes across a condition. The other branch is NaN and never taken.
    """
    return jax.lax.cond(
        jax.lax.optimization_barrier(jnp.asarray(True)),
        jaxpr_as_fun(traced),
        lambda *_: [_none(value) for value in traced.out_avals],
        *arguments,
    )


def in_pieces(
    traced: ClosedJaxpr, operations: int = MOST_OPERATIONS
) -> Callable[..., list[jax.Array]]:
    """A program as a sequence of conditions, each with a piece of it.

    XLA on a CPU may write the operations that compute a number once for each operation that uses
    it, and those on which they depend again for each of these: a Hessian had ten times as many
    operations as it needs. A number that passes from one piece to the next is computed once. It is
    stored, which takes less time than computing it twice if the cuts are where few numbers pass.
    Derivatives have their cuts in the same places.

    **Arguments:**

    - `traced`: the program.
    - `operations`: of a piece at most, without its derivatives.

    **Returns:** a function of the arguments of the program; its values and derivatives are those of
    the program.
    """
    flat = _without_calls(traced)
    jaxpr = flat.jaxpr
    cuts = _narrowest_cuts(jaxpr, operations)
    constants = dict(zip(jaxpr.constvars, flat.consts, strict=True))
    last = _last_uses(jaxpr)
    pieces = [
        _piece(jaxpr, begin, end, constants, last)
        for begin, end in zip(cuts, cuts[1:], strict=False)
    ]

    def run(*arguments: jax.Array) -> list[jax.Array]:
        known: dict[Var, Any] = {**constants, **dict(zip(jaxpr.invars, arguments, strict=True))}
        for piece in pieces:
            inputs, outputs = piece.jaxpr.invars, piece.jaxpr.outvars
            if outputs:
                values = [known[name] for name in inputs]
                found = jaxpr_as_fun(piece)(*values) if _is_cut(piece) else hidden(piece, values)
                known.update(zip(outputs, found, strict=True))
        found = [v.val if isinstance(v, Literal) else known[v] for v in jaxpr.outvars]
        # Constants among the results are NumPy numbers.
        return [jnp.asarray(x, v.aval.dtype) for x, v in zip(found, jaxpr.outvars, strict=True)]

    return run


def _without_calls(traced: ClosedJaxpr) -> ClosedJaxpr:
    """The same program with the operations of the functions that it calls in their place."""
    if not any(equation.primitive.name in _CALLS for equation in traced.jaxpr.eqns):
        return traced
    shapes = [jax.ShapeDtypeStruct(value.shape, value.dtype) for value in traced.in_avals]
    return jax.make_jaxpr(lambda *leaves: _called(traced, leaves))(*shapes)


def _called(traced: ClosedJaxpr, arguments: Sequence[Any]) -> list[Any]:
    jaxpr = traced.jaxpr
    known: dict[Var, Any] = dict(zip(jaxpr.constvars, traced.consts, strict=True))
    known.update(zip(jaxpr.invars, arguments, strict=True))
    for equation in jaxpr.eqns:
        values = [v.val if isinstance(v, Literal) else known[v] for v in equation.invars]
        if equation.primitive.name in _CALLS:
            # Laws are known by the names of their scopes.
            with jax.named_scope(str(equation.source_info.name_stack)):
                found = _called(equation.params["jaxpr"], values)
        else:
            inputs = [v for v in equation.invars if not isinstance(v, Literal)]
            inputs = list(dict.fromkeys(inputs))
            one = jaxpr.replace(
                constvars=[], invars=inputs, outvars=equation.outvars, eqns=[equation]
            )
            found = jaxpr_as_fun(ClosedJaxpr(one, ()))(*(known[name] for name in inputs))
        known.update(zip(equation.outvars, found, strict=True))
    return [v.val if isinstance(v, Literal) else known[v] for v in jaxpr.outvars]


def _last_uses(jaxpr: Jaxpr) -> dict[Var, int]:
    """Index of the last equation that uses each variable; their number for results."""
    last: dict[Var, int] = {}
    for index, equation in enumerate(jaxpr.eqns):
        last.update((v, index) for v in equation.invars if isinstance(v, Var))
    last.update((v, len(jaxpr.eqns)) for v in jaxpr.outvars if isinstance(v, Var))
    return last


def _narrowest_cuts(jaxpr: Jaxpr, operations: int) -> list[int]:
    """Indices of the equations at which pieces begin, and the number of equations."""
    count, last = len(jaxpr.eqns), _last_uses(jaxpr)
    # Numbers that are computed before an equation, and used there or later.
    width = [0] * (count + 1)
    total = [0]
    for index, equation in enumerate(jaxpr.eqns):
        total.append(total[-1] + _operations(equation))
        for v in equation.outvars:
            for later in range(index + 1, last.get(v, index) + 1):
                width[later] += 1
    cuts = [0]
    for end in _ends_of_stretches(jaxpr, operations):
        while total[end] - total[cuts[-1]] > operations:
            done = total[cuts[-1]]
            least, most = done + _LEAST_SHARE * operations, done + operations
            places = [i for i in range(cuts[-1] + 1, end) if least <= total[i] <= most]
            if not places:
                break
            cuts.append(min(places, key=lambda i: (width[i], -i)))
        if end > cuts[-1]:
            cuts.append(end)
    return cuts


def _ends_of_stretches(jaxpr: Jaxpr, operations: int) -> list[int]:
    """Where equations that are pieces of their own begin and end, and the end of the program."""
    ends: list[int] = []
    for index, equation in enumerate(jaxpr.eqns):
        if _operations(equation) > operations:
            ends += [index, index + 1]
    return [*ends, len(jaxpr.eqns)]


def _operations(equation) -> int:
    """Operations of an equation, those of a function with its own derivative included."""
    if equation.primitive.name in _WITHOUT_ARITHMETIC:
        return 0
    inner = equation.params.get("call_jaxpr")
    return 1 if inner is None else sum(_operations(part) for part in inner.jaxpr.eqns)


def _is_cut(piece: ClosedJaxpr) -> bool:
    """Whether a piece is a large function with its own derivative, which makes its own cuts."""
    equations = piece.jaxpr.eqns
    return len(equations) == 1 and _operations(equations[0]) > 1


def _piece(
    jaxpr: Jaxpr, begin: int, end: int, constants: dict[Var, Any], last: dict[Var, int]
) -> ClosedJaxpr:
    """Some equations as a program from what they need to what is needed of them later."""
    equations = jaxpr.eqns[begin:end]
    made = [v for equation in equations for v in equation.outvars]
    used = dict.fromkeys(v for e in equations for v in e.invars if isinstance(v, Var))
    own = [v for v in used if v in constants]
    inputs = [v for v in used if v not in constants and v not in set(made)]
    outputs = [v for v in made if last.get(v, -1) >= end]
    piece = jaxpr.replace(constvars=own, invars=inputs, outvars=outputs, eqns=equations)
    return ClosedJaxpr(piece, [constants[v] for v in own])


def _none(value) -> jax.Array:
    inexact = jnp.issubdtype(value.dtype, jnp.inexact)
    return jnp.full(value.shape, jnp.nan if inexact else 0, value.dtype)
