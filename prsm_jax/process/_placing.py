"""Finished files and folders take their place, whatever is there and whoever else is at it."""

import contextlib
import ctypes
import errno
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from ._files import is_written_through, real_path, taking_place, whole_file

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

_HERE, _EXCHANGE = -100, 2  # AT_FDCWD and RENAME_EXCHANGE of Linux


@contextlib.contextmanager
def placing_in(folder: Path) -> Iterator[None]:
    """While results take their place in a folder: no signal stops it, another process waits."""
    with taking_place():
        lock = None
        # A file system without locks is no reason to fail.
        with contextlib.suppress(OSError):
            lock = os.open(folder, os.O_RDONLY)
            if fcntl is not None:
                fcntl.flock(lock, fcntl.LOCK_EX)
        try:
            yield
        finally:
            if lock is not None:
                os.close(lock)


def put_file(finished: Path, target: Path) -> None:
    """Move a finished file to its place; a link stays, and what it leads to is replaced."""
    if not (target.is_symlink() or is_written_through(target)):
        try:
            os.replace(finished, target)
            return
        except OSError as error:
            if error.errno != errno.EXDEV:
                raise
    with whole_file(target) as beside:
        shutil.copyfile(finished, beside)


def put_folder(finished: Path, target: Path, aside: Path) -> None:
    """Move a finished folder to its place in one step where the system can.

    **Arguments:**

    - `finished`: the folder; what was at the target may be here afterwards.
    - `target`: its place; a link stays, and what it leads to is replaced.
    - `aside`: where what was at the target may be afterwards, if not at `finished`.
    """
    target = real_path(target)
    if _exchanged(finished, target):
        return
    if target.exists():
        os.replace(target, aside)
    try:
        os.replace(finished, target)
    except OSError:
        if aside.exists():
            os.replace(aside, target)
        raise


def _exchanged(one: Path, other: Path) -> bool:
    """Whether two paths changed places, which Linux does in one step."""
    if not other.exists():
        return False
    rename = getattr(ctypes.CDLL(None), "renameat2", None) if os.name == "posix" else None
    if rename is None:
        return False
    return rename(_HERE, bytes(one), _HERE, bytes(other), _EXCHANGE) == 0
