"""Files that are written whole or not at all, and the JSON documents in them."""

import contextlib
import json
import os
import tempfile
from collections.abc import Generator, Mapping
from pathlib import Path
from typing import Any


@contextlib.contextmanager
def written_whole(path: Path) -> Generator[Path, None, None]:
    """A temporary file beside `path` that takes its place when the block ends without an error."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        # A temporary file is private.
        temporary.chmod(0o644)
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def write_text(path: Path, text: str) -> Path:
    """Write a text; returns its path."""
    with written_whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def write_json(path: Path, document: Mapping[str, Any], *, allow_nan: bool = True) -> Path:
    """Write a document; returns its path.

    **Raises:** `ValueError` for NaN or infinity, which are not JSON, unless they are allowed.
    """
    text = json.dumps(document, indent=1, allow_nan=allow_nan, ensure_ascii=False)
    return write_text(path, text + "\n")


def read_json(path: Path) -> dict[str, Any]:
    """Read a document."""
    return json.loads(path.read_text(encoding="utf-8"))


def save_picture(figure: Any, path: Path, **options: Any) -> Path:
    """Write a figure of matplotlib; returns its path."""
    with written_whole(path) as temporary:
        figure.savefig(temporary, **options)
    return path
