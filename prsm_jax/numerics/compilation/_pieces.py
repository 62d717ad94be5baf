"""Pieces of a program that XLA compiles separately, cut where few numbers pass between them."""

import itertools
from collections.abc import Callable, Sequence
from typing import Any
from weakref import WeakKeyDictionary

import jax
import jax.numpy as jnp
from jax.experimental.xla_metadata import set_xla_metadata
from jax.extend.core import ClosedJaxpr, Jaxpr, JaxprEqn, Literal, Var, jaxpr_as_fun

#: Operations of a piece at most, without derivatives.
_MOST_OPERATIONS = 40
#: A piece has between this share of the limit and the limit; the cut is where the fewest numbers
#: pass.
_LEAST_SHARE = 0.5
#: These move or repeat numbers, without arithmetic.
_WITHOUT_ARITHMETIC = frozenset((
    "broadcast_in_dim", "convert_element_type", "copy", "reshape", "slice", "squeeze", "transpose",
))  # fmt: skip
#: Calls; XLA writes the operations of the function in their place.
CALLS = frozenset(("jit", "pjit"))
#: Functions that are called, in pieces: for each program, by the most operations of a piece.
_OF_CALLS: WeakKeyDictionary[ClosedJaxpr, dict[int, Callable[..., list[jax.Array]]]] = (
    WeakKeyDictionary()
)


def _separate(traced: ClosedJaxpr, arguments: Sequence[Any]) -> list[jax.Array]:
    """Results of a program as a call that XLA does not replace by the operations of the program.

    XLA neither fuses nor recomputes across such a call. Calls within the program are replaced.
    """

    def piece(*arguments):
        with set_xla_metadata(inlineable="true"):
            return jaxpr_as_fun(traced)(*arguments)

    with set_xla_metadata(inlineable="false"):
        return jax.jit(piece)(*arguments)


def in_pieces(
    traced: ClosedJaxpr, operations: int = _MOST_OPERATIONS
) -> Callable[..., list[jax.Array]]:
    """A program as a sequence of calls, each of a piece of it.

    XLA on a CPU may repeat the operations behind a number for each operation that uses it.
    Repetitions multiply along a chain: the Hessian of an efficiency had ten times as many
    operations as it needs. A number that passes from one piece to the next is computed once. It is
    stored, which takes less time than computing it twice if the cuts are where few numbers pass.
    Derivatives have their cuts in the same places.

    **Arguments:**

    - `traced`: the program.
    - `operations`: of a piece at most, without its derivatives.

    **Returns:** a function of the arguments of the program; its values and derivatives are those of
    the program.
    """
    jaxpr = traced.jaxpr
    last = _last_uses(jaxpr)
    cuts = _narrowest_cuts(jaxpr, operations, last)
    constants = dict(zip(jaxpr.constvars, traced.consts, strict=True))
    pieces = [_piece(jaxpr, begin, end, constants, last) for begin, end in itertools.pairwise(cuts)]

    def run(*arguments: jax.Array) -> list[jax.Array]:
        known: dict[Var, Any] = {**constants, **dict(zip(jaxpr.invars, arguments, strict=True))}
        for piece in pieces:
            inputs, outputs = piece.jaxpr.invars, piece.jaxpr.outvars
            if outputs or any(e.effects for e in piece.jaxpr.eqns):
                values = [known[name] for name in inputs]
                known.update(zip(outputs, _evaluated(piece, values, operations), strict=True))
        found = [v.val if isinstance(v, Literal) else known[v] for v in jaxpr.outvars]
        # Constants among the results are numbers of Python or NumPy.
        return [
            x if isinstance(x, jax.Array) else jnp.asarray(x, v.aval.dtype)
            for x, v in zip(found, jaxpr.outvars, strict=True)
        ]

    return run


def _evaluated(piece: ClosedJaxpr, values: Sequence[Any], operations: int) -> list[jax.Array]:
    """Results of a piece, as a call that stays one.

    A long function is a piece by itself, without such a call: its own pieces are calls. One with
    its own derivative has its cuts from its author, as `find_roots_and` has.
    """
    equation = piece.jaxpr.eqns[0]
    if len(piece.jaxpr.eqns) > 1 or _operations(equation) <= operations:
        return _separate(piece, values)
    if equation.primitive.name not in CALLS:
        return jaxpr_as_fun(piece)(*values)
    known = dict(zip(piece.jaxpr.invars, values, strict=True))
    known.update(zip(piece.jaxpr.constvars, piece.consts, strict=True))
    inputs = [v.val if isinstance(v, Literal) else known[v] for v in equation.invars]
    # Laws are known by the names of their scopes.
    with jax.named_scope(str(equation.source_info.name_stack)):
        found = _called_in_pieces(equation.params["jaxpr"], operations)(*inputs)
    results = dict(zip(equation.outvars, found, strict=True))
    return [results[v] for v in piece.jaxpr.outvars]


def _called_in_pieces(traced: ClosedJaxpr, operations: int) -> Callable[..., list[jax.Array]]:
    """A function that is called, in pieces; JAX differentiates it once for all of its calls."""
    known = _OF_CALLS.setdefault(traced, {})
    if operations not in known:
        known[operations] = jax.jit(in_pieces(traced, operations))
    return known[operations]


def _last_uses(jaxpr: Jaxpr) -> dict[Var, int]:
    """Index of the last equation that uses each variable; the number of equations for results."""
    last: dict[Var, int] = {}
    for index, equation in enumerate(jaxpr.eqns):
        last.update((v, index) for v in equation.invars if isinstance(v, Var))
    last.update((v, len(jaxpr.eqns)) for v in jaxpr.outvars if isinstance(v, Var))
    return last


def _narrowest_cuts(jaxpr: Jaxpr, operations: int, last: dict[Var, int]) -> list[int]:
    """Indices of the equations at which pieces begin, and the number of equations."""
    lengths = [_operations(equation) for equation in jaxpr.eqns]
    total = [0, *itertools.accumulate(lengths)]
    change = [0] * (len(lengths) + 2)
    for index, equation in enumerate(jaxpr.eqns):
        for v in equation.outvars:
            change[index + 1] += 1
            change[last.get(v, index) + 1] -= 1
    # Numbers that are computed before an equation, and used there or later.
    width = list(itertools.accumulate(change))
    cuts = [0]
    for end in _ends_of_stretches(lengths, operations):
        while total[end] - total[cuts[-1]] > operations and end - cuts[-1] > 1:
            done = total[cuts[-1]]
            least, most = done + _LEAST_SHARE * operations, done + operations
            shorter = [i for i in range(cuts[-1] + 1, end) if total[i] <= most]
            # Before an equation of more than half a piece, the piece may have to be shorter.
            places = [i for i in shorter if total[i] >= least] or shorter[-1:]
            cuts.append(min(places, key=lambda i: (width[i], -i)))
        if end > cuts[-1]:
            cuts.append(end)
    return cuts


def _ends_of_stretches(lengths: Sequence[int], operations: int) -> list[int]:
    """Where equations that are pieces of their own begin and end, and the end of the program."""
    long = [index for index, length in enumerate(lengths) if length > operations]
    return [*(end for index in long for end in (index, index + 1)), len(lengths)]


def _operations(equation: JaxprEqn) -> int:
    """Operations of an equation, those of functions that it calls included."""
    if equation.primitive.name in _WITHOUT_ARITHMETIC:
        return 0
    name = "jaxpr" if equation.primitive.name in CALLS else "call_jaxpr"
    inner = equation.params.get(name)
    return 1 if inner is None else sum(_operations(part) for part in inner.jaxpr.eqns)


def _piece(
    jaxpr: Jaxpr, begin: int, end: int, constants: dict[Var, Any], last: dict[Var, int]
) -> ClosedJaxpr:
    """Some equations as a program from what they need to what is needed of them later."""
    equations = jaxpr.eqns[begin:end]
    made = dict.fromkeys(v for equation in equations for v in equation.outvars)
    used = dict.fromkeys(v for e in equations for v in e.invars if isinstance(v, Var))
    own = [v for v in used if v in constants]
    inputs = [v for v in used if v not in constants and v not in made]
    outputs = [v for v in made if last.get(v, -1) >= end]
    piece = jaxpr.replace(constvars=own, invars=inputs, outvars=outputs, eqns=equations)
    return ClosedJaxpr(piece, [constants[v] for v in own])
