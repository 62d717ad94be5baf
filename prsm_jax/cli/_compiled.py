"""The folder where compiled programs are kept between runs, and warnings if it fails."""

import sys
import tempfile
import warnings
from pathlib import Path

from ..process import others_can_write, whole_file
from ..programs import CACHE_VARIABLE, usual_folder
from ..text import printable
from ._progress import clear

_TROUBLE = r"Error (reading|writing) persistent compilation cache entry"


def keep_compiled_programs() -> None:
    """Let JAX store every compiled program, even small ones: a second run then starts at once.

    If the folder cannot be written, or if other users can write to it, one line says so, and every
    run compiles anew: a compiled program of another user would run with the rights of this one.
    """
    import jax

    folder = usual_folder()
    if folder is None:
        return
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        if reason := others_can_write(folder):
            _tell(
                f"{folder}: compiled programs of earlier runs are not used ({reason}, and such a "
                "program runs with your rights); remove the folder, and the next run makes one "
                "that is yours alone"
            )
            return
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        why = error.strerror or str(error)
        _tell(f"{folder}: compiled programs cannot be kept here for the next run ({why.lower()})")
        return
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    write_whole_entries()


def tell_of_trouble_once() -> None:
    """Print one line, once, if JAX cannot read or write compiled programs (a full disk)."""
    warned = warnings.showwarning
    reported: list[str] = []

    def show(message, category, filename, lineno, file=None, line=None):
        words = str(message)
        if not words.startswith(("Error reading persistent", "Error writing persistent")):
            warned(message, category, filename, lineno, file, line)
        elif not reported:
            reported.append(words)
            what = "read" if words.startswith("Error reading") else "kept for the next run"
            _tell(f"a compiled program could not be {what} ({words.rpartition(': ')[2].lower()})")

    warnings.filterwarnings("always", _TROUBLE)
    warnings.showwarning = show


def _tell(what: str) -> None:
    clear()
    print(f"prsm: {printable(what)}; {CACHE_VARIABLE} names the folder", file=sys.stderr)


def write_whole_entries() -> None:
    """Make JAX write each program completely or not at all, also beside another process.

    JAX writes a program in place and never replaces it: an incomplete one, from a killed process
    or a full disk, would stay for ever.
    """
    try:
        from jax._src.lru_cache import LRUCache
    except ImportError:
        return
    put = LRUCache.put

    def put_whole(self, key: str, value: bytes) -> None:
        if self.eviction_enabled or not key:
            put(self, key, value)
            return
        with whole_file(Path(self.path) / f"{key}-cache") as partial:
            partial.touch(mode=0o600)
            partial.write_bytes(value)

    if not getattr(put, "whole", False):
        put_whole.whole = True  # type: ignore[attr-defined]
        LRUCache.put = put_whole
