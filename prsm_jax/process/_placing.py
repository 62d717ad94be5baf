"""Puts finished files and folders in place, over older ones and beside other processes."""

import contextlib
import ctypes
import errno
import os
import shutil
from collections.abc import Generator
from pathlib import Path

from ._files import is_written_through, real_path, taking_place, whole_file

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

_HERE, _EXCHANGE = -100, 2  # AT_FDCWD and RENAME_EXCHANGE of Linux


@contextlib.contextmanager
def placing_in(folder: Path) -> Generator[None, None, None]:
    """Held while results are put into a folder: no signal stops it, another process waits."""
    with taking_place():
        lock = None
        # A file system without locks is accepted.
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
    """Move a finished file to its place; of a link, the file that it points to is replaced."""
    if not (target.is_symlink() or is_written_through(target)):
        try:
            with contextlib.suppress(OSError):
                # The permissions of the file stay.
                shutil.copymode(target, finished)
            os.replace(finished, target)
            return
        except OSError as error:
            if error.errno != errno.EXDEV:
                raise
    with whole_file(target) as beside:
        shutil.copyfile(finished, beside)


def put_folder(finished: Path, target: Path, aside: Path) -> None:
    """Move a finished folder to its place in one step if the system can.

    **Arguments:**

    - `finished`: the folder; the former target may be here afterwards.
    - `target`: its place; of a link, the folder that it points to is replaced.
    - `aside`: where the former target may be afterwards, if not at `finished`.
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
