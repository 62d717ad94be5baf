"""Traced programs kept between runs, so that a warm start only has to import JAX.

JAX's own cache saves compiling but not tracing and lowering, which for a steady state take as long
as importing JAX. Here the lowered program is kept as well, under a key that changes with anything
it depends on: the mechanism's structure, this package's files, JAX and the platform.
"""

import contextlib
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import equinox as eqx
import jax

from .._files import whole_file
from ..mechanism import Mechanism
from ._progress import expect_programs

_PACKAGE = Path(__file__).parent.parent


def _fingerprint() -> str:
    """Names, sizes and times of this package's source files."""
    files = sorted(_PACKAGE.rglob("*.py"))
    stats = [(str(f.relative_to(_PACKAGE)), f.stat().st_size, f.stat().st_mtime_ns) for f in files]
    return repr(stats)


def _key(name: str, leaves: list, structure: Any) -> str:
    shapes = [(leaf.shape, str(leaf.dtype)) for leaf in leaves]
    parts = (name, jax.__version__, jax.default_backend(), shapes, str(structure), _fingerprint())
    return hashlib.sha256(repr(parts).encode()).hexdigest()


_one_verb = False


def run_one_verb() -> None:
    """Say that this process runs one verb and ends: no program is called a second time."""
    global _one_verb
    _one_verb = True


def runs_one_verb() -> bool:
    """Whether this process runs one verb and ends, so that stored programs serve it better.

    A process that goes on keeps the programs that it has traced itself.
    """
    return _one_verb


def run_stored(
    name: str,
    function: Callable[[Mechanism], Any],
    mechanism: Mechanism,
    *,
    announced: bool = False,
) -> Any:
    """Evaluate `function(mechanism)` compiled, keeping the lowered program for the next run.

    **Arguments:**

    - `name`: names the function in the key.
    - `function`: a pure function of the mechanism to a dictionary of arrays (dictionaries and
      lists inside are fine).
    - `mechanism`: the mechanism.
    - `announced`: whether the line of progress counts on it already.
    """
    if not announced:
        expect_programs("call")
    folder = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    try:
        import flatbuffers  # noqa: F401
        from jax import export
    except ModuleNotFoundError:
        folder = None
    if not folder:
        return eqx.filter_jit(function)(mechanism)

    leaves, structure = jax.tree.flatten(mechanism)
    path = Path(folder) / "programs" / _key(name, leaves, structure)
    exported = None
    # A program that was changed, or from a JAX that cannot read it, is simply made again.
    try:
        exported = export.deserialize(bytearray(_read(path)))
    except Exception:
        exported = None
    if exported is None:
        program = jax.jit(lambda *numbers: function(jax.tree.unflatten(structure, numbers)))
        exported = export.export(program)(*leaves)
        _write(path, bytes(exported.serialize()))
    return jax.jit(exported.call)(*leaves)


def _write(path: Path, data: bytes) -> None:
    """Keep a program; a folder that cannot be written is no reason to fail."""
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as partial:
            partial.write_bytes(hashlib.sha256(data).digest() + data)


def _read(path: Path) -> bytes:
    """What `_write` kept. **Raises:** `OSError` or `ValueError` if it is not there, or not that."""
    stored = path.read_bytes()
    size = hashlib.sha256().digest_size
    if hashlib.sha256(stored[size:]).digest() != stored[:size]:
        raise ValueError(f"{path} is not what was written")
    return stored[size:]
