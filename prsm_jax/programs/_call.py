"""One call as a compiled program: making it, writing it to a file, reading it from there."""

import contextlib
import functools
import os
import pickle
import threading
from collections.abc import Callable, Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import jax

from . import _files
from ._one_verb import compiler_begins
from ._origin import origin_of
from ._read_ahead import executable

#: Only the compiler works outside Python: two threads would trace no faster than one, and the
#: program that was asked for first comes first.
_tracing = threading.RLock()
#: Options for a program that runs once: code that is not optimised, in one piece, takes half to
#: three quarters of the time to compile and run.
_FOR_ONE_RUN = {"xla_backend_optimization_level": 0, "xla_cpu_parallel_codegen_split_count": 1}


@dataclass(frozen=True)
class _Place:
    """Where an array of the results stands in the list that a program returns."""

    index: int


class Program(NamedTuple):
    """A compiled program and its results with a `_Place` for every array."""

    run: Callable[..., list[jax.Array]]
    results: Any

    def __call__(self, arrays: list[jax.Array]) -> Any:
        values = self.run(*arrays)
        return jax.tree.map(
            lambda leaf: values[leaf.index] if isinstance(leaf, _Place) else leaf, self.results
        )


class Call:
    """A function and the kind of its arguments: what a program is compiled for.

    **Arguments:**

    - `name`: names the function in the key.
    - `function`: a pure function.
    - `args`: pytrees; leaves that are not arrays are static, as for `equinox.filter_jit`.
    - `words`: what JAX calls the program while compiling it.
    - `repeated`: whether it runs often, so that it pays to optimise its code.
    """

    def __init__(
        self,
        name: str,
        function: Callable[..., Any],
        args: tuple[Any, ...],
        words: str = "call",
        repeated: bool = False,
    ):
        self._function, self._words, self._repeated = function, words, repeated
        self._leaves, self._structure = jax.tree.flatten(args)
        static = tuple(map(_described, self._leaves))
        #: Set when the program has been traced or read, or cannot be.
        self.traced = threading.Event()
        #: Equal for calls that need the same program.
        self.question: tuple[Any, ...] = (name, self._structure, *static)

    @functools.cached_property
    def path(self) -> Path | None:
        """Where the program is kept; `None` if its arguments are not the same in every process."""
        name, structure, *static = self.question
        return _files.path_of(name, structure, tuple(static))

    @property
    def arrays(self) -> list[jax.Array]:
        """Arguments of the program."""
        return [leaf for leaf in self._leaves if eqx.is_array(leaf)]

    def compiled(self) -> Program:
        """The program, traced and compiled, and written to its file if that can be written."""
        program = self._compiled()
        with contextlib.suppress(Exception):
            assert self.path is not None
            _files.write(self.path, pickle.dumps(_serialised(program)))
        return program

    def loaded(self) -> Program:
        """The program from its file.

        **Raises:** anything, if the program is absent, changed, or not one of this JAX.
        """
        assert self.path is not None
        run, results = executable(self.path)
        return Program(run, pickle.loads(results))

    def prepared(self) -> Program:
        """The program from its file, or else compiled."""
        try:
            with contextlib.suppress(Exception):
                return self.loaded()
            return self.compiled()
        finally:
            self.traced.set()

    def _compiled(self) -> Program:
        results: list[Any] = []

        def call(*arrays):
            rest = iter(arrays)
            given = [next(rest) if eqx.is_array(leaf) else leaf for leaf in self._leaves]
            numbers, structure_of_results = jax.tree.flatten(
                self._function(*jax.tree.unflatten(self._structure, given))
            )
            traced = [number for number in numbers if eqx.is_array(number)]
            places = map(_Place, range(len(traced)))
            skeleton = [next(places) if eqx.is_array(number) else number for number in numbers]
            results[:] = [jax.tree.unflatten(structure_of_results, skeleton)]
            return traced

        call.__name__ = call.__qualname__ = self._words
        with _tracing:
            lowered = jax.jit(call).lower(*self.arrays)
            _strip_names(lowered)
        self.traced.set()
        compiler_begins()
        with _not_in_the_cache_of_jax():
            return Program(lowered.compile(self._options()), *results)

    def _options(self) -> dict[str, Any]:
        if self._repeated:
            return {}
        flags = os.environ.get("XLA_FLAGS", "")
        # Those of the user count.
        return {name: value for name, value in _FOR_ONE_RUN.items() if name not in flags}


def _described(leaf: Any) -> Any:
    """What a program depends on of a leaf: shape and type of an array, or the static value."""
    if eqx.is_array(leaf):
        return leaf.shape, str(leaf.dtype), bool(getattr(leaf, "weak_type", False))
    return origin_of(leaf) if callable(leaf) else leaf


def _serialised(program: Program) -> tuple[Any, ...]:
    from jax.experimental import serialize_executable

    run: Any = program.run
    # The classes of the results are imported where the program is used, not where it is read ahead:
    # two threads that import the same modules may see one of them half made.
    return *serialize_executable.serialize(run), pickle.dumps(program.results)


def _strip_names(lowered: jax.stages.Lowered) -> None:
    """Remove the names of functions and lines from a program, in place.

    No user sees them, and they are a quarter of the stored program.
    """
    # Not public: in a version of JAX that differs, the names stay.
    with contextlib.suppress(Exception):
        from jax._src.lib.mlir import passmanager  # pyright: ignore[reportPrivateImportUsage]

        module: Any = lowered.compiler_ir("stablehlo")
        with module.context:
            passes: Any = passmanager.PassManager.parse("builtin.module(strip-debuginfo)")
            passes.run(module.operation)


@contextlib.contextmanager
def _not_in_the_cache_of_jax() -> Generator[None, None, None]:
    """Compile without writing to JAX's own cache.

    A program that was read from that cache lacks some functions when it is serialised again.
    """
    from jax._src.config import persistent_cache_min_compile_time_secs

    # Of this thread alone; another may compile meanwhile.
    with persistent_cache_min_compile_time_secs(float("inf")):
        yield
