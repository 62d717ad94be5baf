"""Cost of an analysis of a mechanism: counted in the traced program, measured in the compiled one.

Only operations that the numbers of a result need are counted; range checks for its code are not.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.interpreters import partial_eval

from .._errors import MissingDataError, PrsmError
from ..dynamics import simulate, steady_state
from ..mechanism import Mechanism
from ..quantities import available_quantities, compute
from ..vibration import modal

#: Analyses whose programs are counted.
PROGRAMS = ("steady_state", "modes", "transient", "quantities")
#: Time spent on samples of a compiled program [s], and the least number of them.
_SAMPLING_S, _SAMPLES = 0.05, 20


@dataclass(frozen=True)
class Account:
    """Cost of one program.

    - `equations`: number in the traced program; those of loops count once.
    - `flops`, `bytes`: of the compiled program, as XLA counts them (loops once).
    - `memory_bytes`: what XLA reserves for results and intermediate numbers.
    - `compile_s`: processor time of compiling; `run_s`: shortest run, by the clock.

    All but the first are `None` if nothing was compiled.
    """

    equations: int
    flops: float | None = None
    bytes: float | None = None
    memory_bytes: int | None = None
    compile_s: float | None = None
    run_s: float | None = None


#: Fields of an account; a cost has the same.
MEASURES = ("equations", "flops", "bytes", "memory_bytes", "compile_s", "run_s")
_Analysis = Callable[[Mechanism], Any]


def analysis_of(name: str, mechanism: Mechanism) -> _Analysis:
    """The analysis with a name, as a function of a mechanism, complete or without a part.

    **Arguments:**

    - `name`: of `PROGRAMS`.
    - `mechanism`: the complete mechanism; it determines the stages that vibrate.

    **Raises:** `MissingDataError` if it has no data for any stage.
    """
    if name == "steady_state":
        return steady_state
    if name == "transient":
        return lambda one: simulate(one, throw=False)
    if name == "quantities":
        # Without a part: the quantities that remain.
        return lambda one: compute(one, available_quantities(one))
    stages, missing = [], None
    for number in range(1, len(mechanism.stages) + 1):
        try:
            eqx.filter_eval_shape(lambda one, number=number: modal(one, stage=number), mechanism)
            stages.append(number)
        except MissingDataError as error:
            missing = error
    if missing is not None and not stages:
        raise missing
    return lambda one: [modal(one, stage=number) for number in stages]


def _numbers(results: Any) -> list[jax.Array]:
    leaves = jax.tree.leaves(results)
    return [x for x in leaves if eqx.is_array(x) and jnp.issubdtype(x.dtype, jnp.inexact)]


def traced(analysis: _Analysis, mechanism: Mechanism) -> tuple[Account, frozenset[tuple[Any, ...]]]:
    """Count a program without compiling it.

    **Returns:** the account, and the paths of the numbers of the mechanism that it reads.
    """
    function, leaves = _flat(analysis, mechanism)
    closed, paths = jax.make_jaxpr(function)(*leaves), number_paths(mechanism)
    needed, used = partial_eval.dce_jaxpr(closed.jaxpr, [True] * len(closed.jaxpr.outvars))
    read = frozenset(path for path, one in zip(paths, used, strict=True) if one)
    return Account(equation_count(needed)), read


def compiled(analysis: _Analysis, mechanism: Mechanism, equations: int) -> Account:
    """Compile a program and run it.

    **Arguments:**

    - `analysis`: a function of a mechanism.
    - `mechanism`: the mechanism.
    - `equations`: their number, as counted by `traced`.
    """
    function, leaves = _flat(analysis, mechanism)
    lowered = jax.jit(function).lower(*leaves)
    begin = time.process_time()
    program = lowered.compile()
    compiling = time.process_time() - begin
    cost, memory = program.cost_analysis() or {}, program.memory_analysis()
    jax.block_until_ready(program(*leaves))
    runs, begin = [], time.perf_counter()
    while len(runs) < _SAMPLES or time.perf_counter() - begin < _SAMPLING_S:
        start = time.perf_counter()
        jax.block_until_ready(program(*leaves))
        runs.append(time.perf_counter() - start)
    return Account(
        equations,
        cost.get("flops"),
        cost.get("bytes accessed"),
        None if memory is None else memory.temp_size_in_bytes + memory.output_size_in_bytes,
        compiling,
        min(runs),
    )


def number_paths(mechanism: Mechanism) -> list[tuple[str | int, ...]]:
    """Fields and indices that lead to each number of a mechanism, in the order of its leaves."""
    with_paths, _ = jax.tree_util.tree_flatten_with_path(eqx.filter(mechanism, eqx.is_array))
    return [tuple(getattr(k, "name", getattr(k, "idx", 0)) for k in p) for p, _ in with_paths]


def _flat(analysis: _Analysis, mechanism: Mechanism):
    """An analysis as a function of the numbers of a mechanism, and these numbers."""
    numbers, rest = eqx.partition(mechanism, eqx.is_array)
    leaves, structure = jax.tree.flatten(numbers)

    def function(*leaves):
        return _numbers(analysis(eqx.combine(jax.tree.unflatten(structure, leaves), rest)))

    return function, leaves


def equation_count(jaxpr: Any) -> int:
    """Equations of a jaxpr, those of programs inside it included."""
    count = 0
    for equation in jaxpr.eqns:
        count += 1
        leaves = jax.tree.leaves(
            list(equation.params.values()),
            is_leaf=lambda x: hasattr(x, "eqns") or hasattr(x, "jaxpr"),
        )
        for inner in leaves:
            inner = getattr(inner, "jaxpr", inner)
            if hasattr(inner, "eqns"):
                count += equation_count(inner)
    return count


#: Errors that a mechanism without a part may raise.
REFUSALS = (PrsmError, ValueError)
