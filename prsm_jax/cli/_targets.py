"""Checks, before anything is computed, that the outputs can be written."""

import os
import tempfile
from pathlib import Path

from .._errors import PrsmError
from ._streams import stdout_is_closed


def check_json(path: str | None) -> None:
    """Check that `--json PATH` can be written; its folder must exist.

    **Raises:** `PrsmError` in one line.
    """
    if path == "-" and stdout_is_closed():
        raise PrsmError("--json -: stdout is closed; give the path of a file")
    if path is None or path == "-":
        return
    target = Path(path)
    if not path.strip() or target.is_dir():
        raise PrsmError(f"--json {path}: is a folder; give the path of a file, or - for stdout")
    folder = target.absolute().parent
    if not folder.is_dir():
        raise PrsmError(f"--json {path}: there is no folder {folder}; create it first")
    if target.exists() and not target.is_file():
        # A pipe or a device is written to, not replaced.
        if not os.access(target, os.W_OK):
            raise PrsmError(f"--json {path}: cannot be written: permission denied")
        return
    _try(Path(os.path.realpath(target)).parent, f"--json {path}")


def check_folder(folder: Path | None, option: str = "--out") -> None:
    """Check that a folder for results exists and can be written to, or can be made.

    **Raises:** `PrsmError` in one line.
    """
    if folder is None:
        return
    words = f"{option} {folder}"
    place = folder.absolute()
    if place.exists() and not place.is_dir():
        raise PrsmError(f"{words}: is a file; give a folder")
    if place.suffix == ".toml" and not place.exists():
        # The name of a file that the user expects here would become that of a folder.
        raise PrsmError(f"{words}: is the name of a file; give a folder, which is made if needed")
    while not place.exists():
        place = place.parent
    if not place.is_dir():
        raise PrsmError(f"{words}: {place} is a file; give a folder")
    _try(place, words)


def _try(folder: Path, words: str) -> None:
    """Create and remove something in the folder: permissions alone are not sufficient."""
    try:
        os.rmdir(tempfile.mkdtemp(prefix=".prsm-", dir=folder))
    except OSError as error:
        reason = error.strerror or str(error)
        raise PrsmError(
            f"{words}: nothing can be written in {folder} ({reason.lower()}); choose another place"
        ) from error
