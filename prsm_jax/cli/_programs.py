"""Compiled programs kept between runs, so that a warm start only has to import JAX.

JAX's own cache saves compiling but not tracing and lowering, which for a steady state take as long
as importing JAX. Here the compiled program is kept under a key that is known without tracing and
changes with everything that the program depends on: the mechanism's structure, this package's
files, JAX, its flags, and the processor.
"""

import contextlib
import functools
import hashlib
import os
import pickle
import platform
from collections.abc import Callable, Generator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
from jax.experimental import serialize_executable

from ..mechanism import Mechanism
from ..process import whole_file
from ._plugins import has_plugins
from ._progress import expect_programs

_PACKAGE = Path(__file__).parent.parent
#: Packages whose code is in the programs; diffrax and optimistix bring lineax with them.
_MADE_BY = ("jax", "jaxlib", "equinox", "diffrax", "optimistix", "lineax")


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


def _key(name: str, leaves: list[Any], structure: Any) -> str:
    shapes = [(leaf.shape, str(leaf.dtype)) for leaf in leaves]
    made_by = (*map(version, _MADE_BY), jax.default_backend())
    flags = os.environ.get("XLA_FLAGS", ""), os.environ.get("EQX_ON_ERROR", "")
    parts = (name, made_by, flags, _processor(), shapes, str(structure), _fingerprint())
    return hashlib.sha256(repr(parts).encode()).hexdigest()


_one_verb = False
#: Programs that this process has used, by their places.
_used: dict[Path, Callable[..., Any]] = {}


def run_one_verb() -> None:
    """Declare that this process runs one verb and ends: no program is called a second time."""
    global _one_verb
    _one_verb = True


def runs_one_verb() -> bool:
    """Whether this process runs one verb and ends; stored programs are then faster.

    A process that runs longer reuses the programs that it has traced itself.
    """
    return _one_verb


def run_stored(
    name: str,
    function: Callable[..., Any],
    mechanism: Mechanism,
    *more: jax.Array,
    announced: bool = False,
) -> Any:
    """Evaluate `function(mechanism, *more)` compiled, keeping the program for the next run.

    **Arguments:**

    - `name`: names the function in the key.
    - `function`: a pure function of the mechanism and arrays to arrays in dictionaries, lists and
      named tuples.
    - `mechanism`: the mechanism.
    - `more`: arrays.
    - `announced`: whether the progress line counts the program already.
    """
    folder = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    # Results of a plugin depend on its own files, which are not part of the key.
    if not folder or has_plugins() or not _is_known(mechanism):
        return eqx.filter_jit(function)(mechanism, *more)
    leaves, structure = jax.tree.flatten((mechanism, *more))
    path = Path(folder) / "programs" / _key(name, leaves, structure)
    if path in _used:
        return _used[path](*leaves)
    if not announced:
        expect_programs("call")
    # A stored program that was changed, or that this JAX cannot run, is compiled again.
    with contextlib.suppress(Exception):
        stored = serialize_executable.deserialize_and_load(*pickle.loads(_read(path)))
        results = jax.block_until_ready(stored(*leaves))
        _used[path] = stored
        return results

    def call(*numbers):
        return function(*jax.tree.unflatten(structure, numbers))

    with _not_in_the_cache_of_jax():
        program = jax.jit(call).lower(*leaves).compile()
    with contextlib.suppress(Exception):
        _write(path, pickle.dumps(serialize_executable.serialize(program)))
    _used[path] = program
    return program(*leaves)


def _is_known(mechanism: Mechanism) -> bool:
    """Whether all parts of a mechanism belong to this package, whose files are in the key."""
    parts = [mechanism]
    while parts:
        part = parts.pop()
        if isinstance(part, tuple):
            parts += part
        elif isinstance(part, eqx.Module):
            if not type(part).__module__.startswith("prsm_jax."):
                return False
            parts += vars(part).values()
        elif callable(part):
            return False  # a function of a user, such as an approximation of the contact ellipse
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
    """Store a program; a folder that cannot be written is ignored."""
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as partial:
            partial.write_bytes(hashlib.sha256(data).digest() + data)


def _read(path: Path) -> bytes:
    """Read what `_write` stored. **Raises:** `OSError` or `ValueError` if absent or changed."""
    stored = path.read_bytes()
    size = hashlib.sha256().digest_size
    if hashlib.sha256(stored[size:]).digest() != stored[:size]:
        raise ValueError(f"{path} is not what was written")
    return stored[size:]
