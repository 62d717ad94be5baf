"""Programs that the last run of the same command used, read before this run asks for them.

Reading a large program takes a second, nearly all of it outside Python. Meanwhile the main thread
imports the rest of the package and reads the file of the mechanism.
"""

import contextlib
import hashlib
import pickle
import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

# Not in the thread: two threads that import the same modules may see one of them half made.
from jax.experimental import serialize_executable

from ..process import others_can_write, own_command
from . import _files
from ._folder import usual_folder
from ._one_verb import begun

#: Runs on arrays; and the pickled form of the results with places for arrays.
Executable = tuple[Callable[..., Any], bytes]
#: The verb and its file: most options, such as a folder, need no other programs.
_WORDS = 2

_lock = threading.Lock()
#: Files that no thread has begun to read.
_waiting: deque[Path] = deque()
_reading: dict[Path, Future[Executable]] = {}
#: Files that this process has asked for, in that order; the values have no meaning.
_used: dict[Path, None] = {}


def read_ahead(command: Sequence[str]) -> None:
    """Begin to read the programs that the last run of a command used, in another thread.

    In the order in which that run asked for them. A program that is not used again costs only the
    time of that thread. Nothing is read from a folder that other users can write to.

    **Arguments:**

    - `command`: words after `prsm`.
    """
    folder = usual_folder()
    if folder is not None and command:
        begun(lambda: _read_all(folder, command))


def _read_all(folder: Path, command: Sequence[str]) -> None:
    with contextlib.suppress(OSError, ValueError):
        if others_can_write(folder):
            return
        path = _list_of(folder, command)
        names = _files.read(path).decode().split()
        with _lock:
            _waiting.extend(path.parent / name for name in names)
    while True:
        with _lock:
            if not _waiting:
                return
            path = _waiting.popleft()
            found = _reading[path] = Future()
        try:
            found.set_result(_read(path))
        except BaseException as error:
            # Raised again where the program is needed, which compiles it then.
            found.set_exception(error)


def _list_of(folder: Path, command: Sequence[str]) -> Path:
    """Where the names of the programs of a command are kept.

    The list may name programs of another version of the package, which this one does not need.
    """
    question = ("programs of the last run", *command[:_WORDS])
    return folder / "programs" / hashlib.sha256(repr(question).encode()).hexdigest()


def executable(path: Path) -> Executable:
    """The program in a file: the one that has been read ahead, or is read now.

    **Raises:** anything, if the file is absent, changed, or not a program of this JAX.
    """
    with _lock:
        _used[path] = None
        found = _reading.pop(path, None)
        if found is None and path in _waiting:
            _waiting.remove(path)
    return _read(path) if found is None else found.result()


def _read(path: Path) -> Executable:
    *run, results = pickle.loads(_files.read(path))
    return serialize_executable.deserialize_and_load(*run), results


def keep_list(command: Sequence[str]) -> None:
    """Write which programs this run has used, for `read_ahead` in the next run of the command."""
    if not _used:
        return
    names = "\n".join(path.name for path in _used).encode()
    path = _list_of(next(iter(_used)).parent.parent, command)
    with contextlib.suppress(OSError, ValueError):
        if _files.read(path) == names:
            return
    _files.write(path, names)


# In a process that is `prsm`: while the rest of the package is imported.
read_ahead(own_command())
