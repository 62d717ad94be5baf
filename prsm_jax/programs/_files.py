"""Files of compiled programs and facts, kept between runs.

Their names are known without tracing and change with everything that a program depends on: the
structure of its arguments, this package's files, JAX, its flags, and the processor.

A stored program is code that runs as this user. Only files and folders that no other user can write
to are read, and what is written can be read by this user alone.
"""

import contextlib
import functools
import hashlib
import os
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax

from ..process import others_can_write, whole_file

_PACKAGE = Path(__file__).parent.parent
#: Packages whose code is in the programs; diffrax and optimistix bring lineax with them.
MADE_BY = ("jax", "jaxlib", "equinox", "diffrax", "optimistix", "lineax")
#: In the written form of an object that is another one in every process.
_ADDRESS = " at 0x"


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
    made_by = (*map(version, MADE_BY), jax.default_backend())
    flags = os.environ.get("XLA_FLAGS", ""), os.environ.get("EQX_ON_ERROR", "")
    parts = (question, made_by, flags, _processor(), _fingerprint())
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def path_of(name: str, structure: Any, static: tuple[Any, ...]) -> Path | None:
    """Where a program is kept; `None` if its arguments are not the same in every process."""
    question = (name, static, str(structure))
    if _ADDRESS in repr(question):
        return None
    return Path(jax.config.jax_compilation_cache_dir) / "programs" / _key(question)  # type: ignore


def write(path: Path, data: bytes) -> None:
    """Store a program; a folder that cannot be written, or that others can write to, is ignored."""
    with contextlib.suppress(OSError):
        path.parent.parent.mkdir(parents=True, exist_ok=True)
        path.parent.mkdir(mode=0o700, exist_ok=True)
        if others_can_write(path.parent):
            return
        with whole_file(path) as partial:
            partial.touch(mode=0o600)
            partial.write_bytes(hashlib.sha256(data).digest() + data)


def read(path: Path) -> bytes:
    """Read what `write` stored.

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
