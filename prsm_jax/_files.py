"""Files that are complete or not there."""

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def whole_file(target: Path) -> Iterator[Path]:
    """A path to write to, which becomes `target` when all went well.

    It lies beside the target, because only within one file system is a rename atomic. If anything
    fails it goes away, and what was at the target is as it was.
    """
    partial = target.with_name(f".{target.name[:32]}.{secrets.token_hex(4)}.partial")
    try:
        yield partial
        os.replace(partial, target)
    finally:
        with contextlib.suppress(OSError):
            partial.unlink(missing_ok=True)
