"""Compiled programs kept between runs, so that a warm start only has to import JAX.

JAX's own cache saves compiling but not tracing and lowering, which for a steady state take as long
as importing JAX. Here the compiled program is kept under a key that is known without tracing.
"""

import contextlib
import functools
import pickle
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from typing import Any, TypeVar

import equinox as eqx
import jax
import numpy as np
from jax.core import Tracer

from . import _files
from ._call import Call, Program
from ._one_verb import begun, runs_one_verb
from ._origin import origin_of

#: Packages whose classes and functions mean the same in every process with the same key.
_KNOWN = {"prsm_jax", "builtins", *_files.MADE_BY}
_Facts = TypeVar("_Facts")

#: Programs that this process has used, by name, structure and static leaves of the arguments.
_used: dict[tuple[Any, ...], Program] = {}
#: Programs that another thread reads or compiles, by the same.
_prepared: dict[tuple[Any, ...], Future[Program]] = {}
#: What this process has asked for so far: no thread prepares it again.
_asked: set[tuple[Any, ...]] = set()


def has_stored(name: str, *args: Any) -> bool:
    """Whether this process has already used this stored program."""
    return Call(name, nothing, args).question in _used


def prepare(
    name: str,
    function: Callable[..., Any],
    *args: Any,
    words: str = "call",
    repeated: bool = False,
) -> Callable[[], object]:
    """Begin to read or compile a program that `run_stored` will need, beside other work.

    A large one is read in a second and compiled in some ten, most of it outside Python. Where
    `run_stored` would not keep the program, nothing is done.

    **Arguments:** those of `run_stored`.

    **Returns:** a function that waits until the program has been traced or read.
    """
    if not _can_be_stored(args):
        return nothing
    call = Call(name, function, args, words, repeated)
    if call.question in _asked or call.path is None:
        return nothing
    _asked.add(call.question)
    _prepared[call.question] = begun(call.prepared)
    return call.traced.wait


def run_stored(
    name: str,
    function: Callable[..., Any],
    *args: Any,
    words: str = "call",
    repeated: bool = False,
) -> Any:
    """Evaluate `function(*args)` compiled, keeping the program for the next run.

    Without a folder for compiled programs, or with arguments whose classes or functions are not of
    this package, the function is compiled as usual.

    **Arguments:** those of `Call`.
    """
    if not _can_be_stored(args):
        return eqx.filter_jit(function)(*args)
    call = Call(name, function, args, words, repeated)
    program = _used.get(call.question)
    if program is None:
        if call.path is None:
            return eqx.filter_jit(function)(*args)
        _asked.add(call.question)
        prepared = _prepared.pop(call.question, None)
        # A stored program that was changed, or that this JAX cannot run, is compiled again.
        with contextlib.suppress(Exception):
            program = call.loaded() if prepared is None else prepared.result()
            results = jax.block_until_ready(program(call.arrays))
            _used[call.question] = program
            return results
        program = call.compiled()
        _used[call.question] = program
    return program(call.arrays)


def used_program(name: str, *args: Any) -> Callable[..., Any] | None:
    """A stored program that this process has used, as a function of its last argument alone.

    **Arguments:** those of `run_stored`; the last number among `args` is that last argument.

    **Returns:** the function, or `None` if there is no such program.
    """
    call = Call(name, nothing, args)
    program = _used.get(call.question)
    if program is None:
        return None
    known = call.arrays[:-1]
    return lambda last: program([*known, last])


def _can_be_stored(args: tuple[Any, ...]) -> bool:
    return bool(jax.config.jax_compilation_cache_dir) and _is_known(args)  # type: ignore[attr-defined]


def nothing() -> None:
    """In place of a function that is not called, or has nothing to do."""


def stored_facts(
    name: str,
    function: Callable[..., _Facts],
    *args: Any,
    by: Hashable = None,
    after: Callable[[], object] = nothing,
) -> _Facts:
    """Evaluate a function whose result depends on the structure of its arguments alone.

    The result of tracing, such as shapes, which takes seconds. A process that runs one verb keeps
    it for the next run, any other process for the next call.

    **Arguments:**

    - `name`: names the function in the key.
    - `function`: returns words, numbers and containers of them; must not depend on numbers.
    - `args`: pytrees; leaves that are not arrays are static.
    - `by`: what else the facts depend on that may change within a process.
    - `after`: waits for what must not be delayed, if the facts have to be found by tracing.
    """
    folder = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    if not (runs_one_verb() and folder and _is_known(args)):
        return _facts_of_this_process(function, args, by)
    path = Call(f"facts of {name}", function, args).path
    if path is None:
        return function(*args)
    with contextlib.suppress(Exception):
        return pickle.loads(_files.read(path))
    after()
    facts = function(*args)
    _files.write(path, pickle.dumps(facts))
    return facts


def _facts_of_this_process(
    function: Callable[..., _Facts], args: tuple[Any, ...], by: Hashable
) -> _Facts:
    leaves, structure = jax.tree.flatten(eqx.filter_eval_shape(lambda *given: given, *args))
    question = (function, structure, tuple(leaves), by)
    try:
        hash(question)
    except TypeError:
        return function(*args)
    return _kept_facts(*question)


@functools.lru_cache(maxsize=64)
def _kept_facts(
    function: Callable[..., Any], structure: Any, leaves: tuple[Any, ...], _by: Hashable
) -> Any:
    # With shapes in place of numbers: the facts do not depend on them, and nothing is kept alive.
    facts: list[Any] = []
    given = jax.tree.unflatten(structure, leaves)
    eqx.filter_eval_shape(lambda *traced: facts.append(function(*traced)), *given)
    return facts[0]


def is_foreign(definition: Any) -> bool:
    """Whether a class or function may change without a change of the key."""
    try:
        module, name = origin_of(definition)
    except AttributeError:
        return True
    return module.partition(".")[0] not in _KNOWN or "<" in name


def _is_known(tree: Any) -> bool:
    """Whether all parts belong to this package or to Python, and no number is traced."""
    parts = [tree]
    while parts:
        part = parts.pop()
        if isinstance(part, tuple | list):
            parts += part
        elif isinstance(part, dict):
            parts += part.values()
        elif isinstance(part, Tracer | np.ndarray):
            return False
        elif isinstance(part, eqx.Module):
            if is_foreign(type(part)):
                return False
            parts += vars(part).values()
        elif callable(part) and is_foreign(part):
            return False
    return True
