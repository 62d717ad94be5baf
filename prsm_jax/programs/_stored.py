"""Compiled programs kept between runs, so that a warm start only has to import JAX.

JAX's own cache saves compiling but not tracing and lowering, which for a steady state take as long
as importing JAX. Here the compiled program is kept under a key that is known without tracing and
changes with everything that the program depends on: the structure of its arguments, this package's
files, JAX, its flags, and the processor.

A stored program is code that runs as this user. Only files and folders that no other user can write
to are read, and what is written can be read by this user alone.
"""

import contextlib
import functools
import hashlib
import os
import pickle
import platform
import threading
from collections.abc import Callable, Generator, Hashable
from concurrent.futures import Future
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import equinox as eqx
import jax
import numpy as np
from jax.core import Tracer

from ..process import others_can_write, whole_file
from ._origin import origin_of

_PACKAGE = Path(__file__).parent.parent
#: Packages whose code is in the programs; diffrax and optimistix bring lineax with them.
_MADE_BY = ("jax", "jaxlib", "equinox", "diffrax", "optimistix", "lineax")
#: Packages whose classes and functions mean the same in every process with the same key.
_KNOWN = {"prsm_jax", "builtins", *_MADE_BY}
_Facts = TypeVar("_Facts")
#: In the written form of an object that is another one in every process.
_ADDRESS = " at 0x"


@dataclass(frozen=True)
class _Place:
    """Where an array of the results stands in the list that a program returns."""

    index: int


class _Program(NamedTuple):
    """A compiled program and its results with a `_Place` for every array."""

    run: Callable[..., list[jax.Array]]
    results: Any

    def __call__(self, arrays: list[jax.Array]) -> Any:
        values = self.run(*arrays)
        return jax.tree.map(
            lambda leaf: values[leaf.index] if isinstance(leaf, _Place) else leaf, self.results
        )


@functools.cache
def _fingerprint() -> str:
    """Names, sizes and times of this package's source files."""
    stats = []
    for folder, _, names in os.walk(_PACKAGE):
        for path in (os.path.join(folder, name) for name in names if name.endswith(".py")):
            stat = os.stat(path)
            stats.append((path.removeprefix(str(_PACKAGE)), stat.st_size, stat.st_mtime_ns))
    return repr(sorted(stats))


def _processor() -> str:
    """Properties that machine code depends on: kind of processor, and its instructions if known."""
    instructions = []
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as file:
        instructions = [next(line for line in file if line.startswith(("flags", "Features")))]
    return repr((platform.machine(), platform.processor(), instructions))


def _key(question: tuple[Any, ...]) -> str:
    made_by = (*map(version, _MADE_BY), jax.default_backend())
    flags = os.environ.get("XLA_FLAGS", ""), os.environ.get("EQX_ON_ERROR", "")
    parts = (question, made_by, flags, _processor(), _fingerprint())
    return hashlib.sha256(repr(parts).encode()).hexdigest()


_one_verb = False
#: Programs that this process has used, by name, structure and static leaves of the arguments.
_used: dict[tuple[Any, ...], _Program] = {}
#: Programs that another thread is reading, by the same.
_being_read: dict[tuple[Any, ...], Future[_Program]] = {}


def run_one_verb() -> None:
    """Declare that this process runs one verb and ends, on code of this package alone.

    It then reads programs that an earlier process has compiled instead of tracing its own.
    """
    global _one_verb
    _one_verb = True


def runs_one_verb() -> bool:
    """Whether this process runs one verb and ends; stored programs are then faster.

    A process that runs longer reuses the programs that it has traced itself.
    """
    return _one_verb


def has_stored(name: str, *args: Any) -> bool:
    """Whether this process has already used this stored program."""
    leaves, structure = jax.tree.flatten(args)
    return (name, structure, *map(_described, leaves)) in _used


def read_soon(name: str, *args: Any) -> None:
    """Begin to read a stored program that `run_stored` will need, beside other work.

    A large one takes up to a second, nearly all of it outside Python. Without such a program, or
    where `run_stored` would not look for one, nothing is done.

    **Arguments:** those of `run_stored`.
    """
    folder = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    if not folder or not _is_known(args):
        return
    leaves, structure = jax.tree.flatten(args)
    question = (name, structure, *map(_described, leaves))
    path = _path(name, structure, question[2:])
    if question in _used or question in _being_read or path is None or not path.exists():
        return
    found: Future[_Program] = Future()
    _being_read[question] = found

    def read() -> None:
        try:
            found.set_result(_loaded(path))
        except BaseException as error:
            # It is raised where the program is needed, which then compiles its own.
            found.set_exception(error)

    threading.Thread(target=read, name="read a program", daemon=True).start()


def run_stored(name: str, function: Callable[..., Any], *args: Any, words: str = "call") -> Any:
    """Evaluate `function(*args)` compiled, keeping the program for the next run.

    Without a folder for compiled programs, or with arguments whose classes or functions are not of
    this package, the function is compiled as usual.

    **Arguments:**

    - `name`: names the function in the key.
    - `function`: a pure function.
    - `args`: pytrees; leaves that are not arrays are static, as for `equinox.filter_jit`.
    - `words`: what JAX calls the program while compiling it.
    """
    folder = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    if not folder or not _is_known(args):
        return eqx.filter_jit(function)(*args)
    leaves, structure = jax.tree.flatten(args)
    static = tuple(map(_described, leaves))
    arrays = [leaf for leaf in leaves if eqx.is_array(leaf)]
    program = _used.get((name, structure, *static))
    if program is None:
        path = _path(name, structure, static)
        if path is None:
            return eqx.filter_jit(function)(*args)
        # A stored program that was changed, or that this JAX cannot run, is compiled again.
        being_read = _being_read.pop((name, structure, *static), None)
        with contextlib.suppress(Exception):
            program = _loaded(path) if being_read is None else being_read.result()
            results = jax.block_until_ready(program(arrays))
            _used[name, structure, *static] = program
            return results
        program = _compiled(function, leaves, structure, words)
        with contextlib.suppress(Exception):
            _write(path, pickle.dumps(_serialised(program)))
        _used[name, structure, *static] = program
    return program(arrays)


def stored_facts(
    name: str, function: Callable[..., _Facts], *args: Any, by: Hashable = None
) -> _Facts:
    """Evaluate a function whose result depends on the structure of its arguments alone.

    The result of tracing, such as shapes, which takes seconds. A process that runs one verb keeps
    it for the next run, any other process for the next call.

    **Arguments:**

    - `name`: names the function in the key.
    - `function`: returns words, numbers and containers of them; must not depend on numbers.
    - `args`: pytrees; leaves that are not arrays are static.
    - `by`: what else the facts depend on that may change within a process.
    """
    folder = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    if not (runs_one_verb() and folder and _is_known(args)):
        return _facts_of_this_process(function, args, by)
    leaves, structure = jax.tree.flatten(args)
    path = _path(f"facts of {name}", structure, tuple(map(_described, leaves)))
    if path is None:
        return function(*args)
    with contextlib.suppress(Exception):
        return pickle.loads(_read(path))
    facts = function(*args)
    _write(path, pickle.dumps(facts))
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


def _path(name: str, structure: Any, static: tuple[Any, ...]) -> Path | None:
    """Where a program is kept; `None` if its arguments are not the same in every process."""
    question = (name, static, str(structure))
    if _ADDRESS in repr(question):
        return None
    return Path(jax.config.jax_compilation_cache_dir) / "programs" / _key(question)  # type: ignore


def _described(leaf: Any) -> Any:
    """What a program depends on of a leaf: shape and type of an array, or the static value."""
    if eqx.is_array(leaf):
        return leaf.shape, str(leaf.dtype), bool(getattr(leaf, "weak_type", False))
    return origin_of(leaf) if callable(leaf) else leaf


def _compiled(function: Callable[..., Any], leaves: list[Any], structure: Any, words: str):
    results: list[Any] = []

    def call(*arrays):
        rest = iter(arrays)
        given = [next(rest) if eqx.is_array(leaf) else leaf for leaf in leaves]
        numbers, structure_of_results = jax.tree.flatten(
            function(*jax.tree.unflatten(structure, given))
        )
        traced = [number for number in numbers if eqx.is_array(number)]
        places = map(_Place, range(len(traced)))
        skeleton = [next(places) if eqx.is_array(number) else number for number in numbers]
        results[:] = [jax.tree.unflatten(structure_of_results, skeleton)]
        return traced

    call.__name__ = call.__qualname__ = words
    with _not_in_the_cache_of_jax():
        run = jax.jit(call).lower(*filter(eqx.is_array, leaves)).compile()
    return _Program(run, *results)


def _serialised(program: _Program) -> tuple[Any, ...]:
    from jax.experimental import serialize_executable

    return *serialize_executable.serialize(program.run), program.results  # type: ignore[arg-type]


def _loaded(path: Path) -> _Program:
    """**Raises:** anything, if the program is absent, changed, or not one of this JAX."""
    from jax.experimental import serialize_executable

    *run, results = pickle.loads(_read(path))
    return _Program(serialize_executable.deserialize_and_load(*run), results)


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


@contextlib.contextmanager
def _not_in_the_cache_of_jax() -> Generator[None, None, None]:
    """Compile without writing to JAX's own cache.

    A program that was read from that cache lacks some functions when it is serialised again.
    """
    name = "jax_persistent_cache_min_compile_time_secs"
    before = getattr(jax.config, name)
    jax.config.update(name, float("inf"))
    try:
        yield
    finally:
        jax.config.update(name, before)


def _write(path: Path, data: bytes) -> None:
    """Store a program; a folder that cannot be written, or that others can write to, is ignored."""
    with contextlib.suppress(OSError):
        path.parent.parent.mkdir(parents=True, exist_ok=True)
        path.parent.mkdir(mode=0o700, exist_ok=True)
        if others_can_write(path.parent):
            return
        with whole_file(path) as partial:
            partial.touch(mode=0o600)
            partial.write_bytes(hashlib.sha256(data).digest() + data)


def _read(path: Path) -> bytes:
    """Read what `_write` stored.

    **Raises:** `OSError` or `ValueError` if it is absent or changed, or if others can change it.
    """
    with path.open("rb") as file:
        # The open file is examined: its name may mean another file a moment later.
        if reason := others_can_write(path.parent) or others_can_write(file.fileno()):
            raise ValueError(f"{path} is not read: {reason}")
        stored = file.read()
    size = hashlib.sha256().digest_size
    if hashlib.sha256(stored[size:]).digest() != stored[:size]:
        raise ValueError(f"{path} is not what was written")
    return stored[size:]
