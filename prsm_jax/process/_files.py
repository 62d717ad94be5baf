"""Files and folders that are complete or absent, even if the process is stopped."""

import contextlib
import ctypes  # here: a thread that ends the process cannot import while JAX is imported
import errno
import os
import secrets
import shutil
import stat
import sys
import tempfile
import threading
import time
from collections.abc import Generator
from pathlib import Path
from typing import NoReturn

#: Paths that are being made; a process that is stopped now would leave them behind.
_unfinished: set[Path] = set()
#: Folders that were made for results and are removed if there are none.
_empty: set[Path] = set()
#: Held while a finished result is moved to its place, so that the process does not stop meanwhile.
_placing = threading.RLock()
_PATIENCE_S = 1.0
#: How long a thread keeps the interpreter's lock when another requests it [s]: Python's default,
#: and during the last steps, which take half of that. Other threads that trace keep it as long,
#: one after the other, before the last steps begin.
_USUAL_LOCK_S, _LOCK_S = 0.005, 0.05
#: Time in which system calls that have begun can end [µs].
_PAUSE_US = 20_000
_MOVED, _TRIES = ".moved-", 1000
_OPEN_FILES = ("/dev/fd/", "/dev/stdin", "/dev/stdout", "/dev/stderr", "/proc/")


@contextlib.contextmanager
def _removed_afterwards(path: Path) -> Generator[Path, None, None]:
    """A path that is removed afterwards, unless it was moved."""
    _unfinished.add(path)
    try:
        yield path
    finally:
        _remove(path)
        _unfinished.discard(path)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)


def end_process(status: int) -> NoReturn:
    """End the process at once; unfinished files are removed, and no result is put in place.

    Other threads still write. Their files are moved aside, with an empty file in each place that
    stops them; no other Python thread runs during the last steps.
    """
    try:
        _placing.acquire(timeout=_PATIENCE_S)
        barred = [path for path in list(_unfinished) if _barred(path)]
        for path in barred:
            for moved in path.parent.glob(f"{path.name}{_MOVED}*"):
                _remove(moved)
        deepest_first = sorted(_empty, key=lambda path: -len(path.parts))
        _last_steps([bytes(path) for path in barred], [bytes(path) for path in deepest_first])
    finally:
        os._exit(status)


def _last_steps(files: list[bytes], folders: list[bytes]) -> None:
    """Remove files and empty folders; the lock of the interpreter is not released meanwhile.

    Another thread may be in a system call that makes a folder again. That call ends during the
    pause, which keeps the lock, and the second round removes the folder.
    """
    unlink, rmdir, pause = os.unlink, os.rmdir, None
    if os.name == "posix":
        sys.setswitchinterval(_LOCK_S)
        # Threads that already wait would request the lock after the former interval.
        time.sleep(2 * _USUAL_LOCK_S)
        library = ctypes.PyDLL(None)
        unlink, rmdir, pause = library.unlink, library.rmdir, library.usleep
    for last in (False, True):
        for path in files:
            for remove in (unlink, rmdir):
                with contextlib.suppress(OSError):
                    remove(path)
        for path in folders:
            with contextlib.suppress(OSError):
                rmdir(path)
        if pause and files and not last:
            pause(_PAUSE_US)


def _barred(path: Path) -> bool:
    """Move the file or folder at a path aside and put an empty file there.

    Other threads still write, and would make the removed folder again.
    """
    for _ in range(_TRIES):
        with contextlib.suppress(OSError):
            os.rename(path, path.with_name(f"{path.name}{_MOVED}{secrets.token_hex(4)}"))
        try:
            os.close(os.open(path, os.O_CREAT | os.O_EXCL))
        except OSError:
            continue
        return True
    return False


def taking_place() -> contextlib.AbstractContextManager[object]:
    """Held while a finished result is put in place in several steps: all are done or none."""
    return _placing


def is_written_through(path: Path) -> bool:
    """Whether a path is a terminal, pipe or device, which a rename onto it would destroy.

    Files that this process has open count too, since others write to them: `/dev/stdout` may be
    one.
    """
    if os.path.abspath(path).startswith(_OPEN_FILES):
        return True
    try:
        mode = os.stat(path).st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def real_path(path: Path) -> Path:
    """A path with its links followed; it need not exist.

    **Raises:** `OSError` for circular links.
    """
    real = Path(os.path.realpath(path))
    if real.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    return real


@contextlib.contextmanager
def whole_file(target: Path) -> Generator[Path, None, None]:
    """A path to write to, which becomes `target` if nothing fails.

    It lies beside the target, because a rename is atomic only within one file system. If anything
    fails, it is removed and the target is unchanged. Of a symbolic link, the file that it points to
    is replaced, not the link; a device or pipe is written to.
    """
    if is_written_through(target):
        with temporary_folder(Path(tempfile.gettempdir()), "prsm-jax-") as folder:
            partial = folder / target.name
            yield partial
            with partial.open("rb") as source, target.open("wb") as sink:
                shutil.copyfileobj(source, sink)
        return
    target = real_path(target)
    partial = target.with_name(f".{target.name[:32]}.{secrets.token_hex(4)}.partial")
    with _removed_afterwards(partial):
        yield partial
        with _placing:
            with contextlib.suppress(OSError):
                # The permissions of the file stay.
                shutil.copymode(target, partial)
            os.replace(partial, target)


@contextlib.contextmanager
def temporary_folder(parent: Path, prefix: str) -> Generator[Path, None, None]:
    """A private folder beside the future result, removed afterwards."""
    # Another process that stopped without a result may have removed the empty folder.
    parent.mkdir(parents=True, exist_ok=True)
    with _removed_afterwards(Path(tempfile.mkdtemp(prefix=prefix, dir=parent))) as folder:
        yield folder


@contextlib.contextmanager
def folder_for_results(folder: Path) -> Generator[Path, None, None]:
    """A folder to write into, made if it does not exist, and removed if it stays empty."""
    try:
        yield make_folder(folder)
    finally:
        remove_empty_folders()


def make_folder(folder: Path) -> Path:
    """A folder for results, made if it does not exist; see `remove_empty_folders`."""
    _empty.update(path for path in (folder, *folder.parents) if not path.exists())
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def remove_empty_folders() -> None:
    """Remove the folders that `make_folder` made and that are empty."""
    for path in sorted(_empty, key=lambda path: -len(path.parts)):
        with contextlib.suppress(OSError):
            path.rmdir()
    _empty.clear()
