"""Results in files: a zip archive of one JSON header and one NumPy array for each number."""

import io
import json
import math
import os
import zipfile
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.lib import format as npy

from .._errors import FileError
from .._version import __version__
from ..process import whole_file
from ._encoding import KINDS, NotKept, decode, encode

_FORMAT, _VERSION = "prsm_jax result", 1
_HEADER, _SUFFIX = "header.json", ".npy"
#: The same for every file, so that equal results give equal files.
_DATE = (1980, 1, 1, 0, 0, 0)


def save_result(path: str | os.PathLike[str], result: Any) -> Path:
    """Write a result to a file that `load_result` reads back exactly.

    The file is a zip archive: `header.json`, and the arrays in SI under their names, which
    `numpy.load(path)["efficiency"]` reads as well. It is written completely or not at all.

    **Arguments:**

    - `path`: the file; an existing one is replaced.
    - `result`: a result of this package, a mechanism, or a list, tuple or dictionary of them and
      of arrays.

    **Returns:** the path.

    **Raises:** `FileError` for what a file cannot hold: a function, an object of a class of your
    own, a number inside a trace.
    """
    target, arrays = Path(path), dict[str, np.ndarray]()
    try:
        content = encode(result, "", arrays)
    except NotKept as error:
        raise FileError(f"{target}: {type(result).__name__} cannot be saved: {error}") from error
    header = {"format": _FORMAT, "format_version": _VERSION, "prsm_jax": __version__}
    words = json.dumps(header | {"result": content}, allow_nan=False)
    with whole_file(target) as partial, zipfile.ZipFile(partial, "w") as archive:
        archive.writestr(zipfile.ZipInfo(_HEADER, _DATE), words)
        for name, array in arrays.items():
            data = io.BytesIO()
            npy.write_array(data, array, version=(1, 0), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(name + _SUFFIX, _DATE), data.getvalue())
    return target


def load_result(path: str | os.PathLike[str]) -> Any:
    """Read a result that `save_result` has written.

    No code of the file runs: it has numbers, words and names of classes of this package. It takes
    no more memory than a few times its size.

    **Arguments:**

    - `path`: the file.

    **Returns:** the result, equal to the one that was saved; on the default device.

    **Raises:** `FileError` for a file of another kind, one that is damaged, one of another version
    of the format, and one of a class that has other fields in this version.
    """
    source = Path(path)
    try:
        with zipfile.ZipFile(source) as archive:
            header, arrays = _contents(archive, source)
    except FileNotFoundError as error:
        raise FileError(f"{source}: there is no such file") from error
    except OSError as error:
        raise FileError(f"{source}: cannot be read: {error.strerror or error}") from error
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError) as error:
        _refuse(source, f"it is not a file of save_result, or is damaged ({error})", error)
    if header.get("format") != _FORMAT:
        _refuse(source, "it is not a file of save_result")
    if header.get("format_version") != _VERSION:
        found = str(header.get("format_version"))[:20]
        _refuse(
            source,
            f"its format is version {found}, and this prsm_jax {__version__} reads version "
            f"{_VERSION}; read it with prsm_jax {str(header.get('prsm_jax'))[:20]}",
        )
    try:
        return decode(header.get("result"), arrays)
    except NotKept as error:
        written = str(header.get("prsm_jax"))[:20]
        remedy = f"read it with prsm_jax {written}, or compute it again"
        _refuse(source, f"{error}; {remedy}", error)
    except (TypeError, ValueError, RecursionError) as error:
        _refuse(source, "its header is damaged", error)


def _refuse(source: Path, why: str, error: BaseException | None = None) -> NoReturn:
    raise FileError(f"{source}: not a result that can be read: {why}") from error


def _contents(
    archive: zipfile.ZipFile, source: Path
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    entries = archive.infolist()
    # Compressed, or with entries that overlap, a small file could need any amount of memory.
    if sum(one.file_size for one in entries) > os.path.getsize(source):
        _refuse(source, "it is not a file of save_result")
    names = [one.filename for one in entries]
    if names[:1] != [_HEADER] or len(set(names)) < len(names):
        _refuse(source, "it is not a file of save_result")
    try:
        header = json.loads(archive.read(_HEADER).decode())
        arrays = {name.removesuffix(_SUFFIX): _array(archive.read(name)) for name in names[1:]}
    except (ValueError, RecursionError) as error:
        _refuse(source, "it is damaged", error)
    if not isinstance(header, dict):
        _refuse(source, "it is not a file of save_result")
    return header, arrays


def _array(data: bytes) -> np.ndarray:
    """One array; its size must be that of its shape, which is not trusted."""
    stream = io.BytesIO(data)
    if npy.read_magic(stream) != (1, 0):
        raise ValueError("another version of NumPy's format")
    shape, fortran, dtype = npy.read_array_header_1_0(stream)
    size = len(data) - stream.tell()
    if dtype.kind not in KINDS or not dtype.isnative or math.prod(shape) * dtype.itemsize != size:
        raise ValueError("an array of another size than its shape")
    array = np.frombuffer(data, dtype, offset=stream.tell())
    return array.reshape(shape, order="F" if fortran else "C")
