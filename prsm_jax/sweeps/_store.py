"""A sweep on disk: a zarr store that is written block by block, and can be continued.

Metadata and coordinates are written once, before the first block. Every block has chunk files of
its own, and each file is written under another name and then renamed. Two processes may compute the
same block: they write the same bytes. The mark of a block is written after its chunks; a block
without a mark is computed again.
"""

import contextlib
import functools
import json
import math
import os
from collections.abc import Generator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._errors import missing_extra
from ..process import real_path, temporary_folder
from ._checked_chunks import checked_store
from ._labels import Variable, derivative_name
from ._plan import Blocks

if TYPE_CHECKING:
    import xarray

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

#: Largest chunk, and largest coordinate, which is read at once [bytes]. Blocks of a sweep have up
#: to 32,768 designs; a store that says more would fill the memory.
_LARGEST = 2**30
#: Codecs of the arrays of a sweep; the others may be larger than their chunks say.
_CODECS = frozenset({"bytes", "vlen-utf8", "zstd"})
#: Files that mark a directory as a zarr store of format 3 or 2.
_MARKS = ("zarr.json", ".zgroup")
#: Group of a store with data of the run, which xarray does not show.
_PROGRESS, _DONE, _SWEEP = "progress", "done", "sweep"


def check_store(store: str | os.PathLike[str]) -> None:
    """Check, before anything is computed, that a store can be written.

    **Raises:** `MissingExtraError` without zarr; `ValueError` if the path holds something that is
    not a zarr store, or its parent directory does not exist.
    """
    try:
        import zarr  # noqa: F401
    except ImportError as error:
        raise missing_extra("sweep", "a zarr store", error) from error
    path = Path(store)
    if not path.absolute().parent.is_dir():
        raise ValueError(f"store {path}: the directory {path.parent} does not exist; create it")
    if path.exists() and not any((path / mark).exists() for mark in _MARKS):
        empty = path.is_dir() and not any(path.iterdir())
        if not empty:
            raise ValueError(
                f"store {path} exists and is not a zarr store; remove it or choose another path"
            )


def create_store(
    store: Path,
    dataset: "xarray.Dataset",
    variables: tuple[Variable, ...],
    blocks: Blocks,
    identity: Mapping[str, Any],
) -> None:
    """Write a store without results, unless another process has written it in the meantime.

    **Arguments:**

    - `store`: its path.
    - `dataset`: coordinates and attributes.
    - `variables`: its arrays.
    - `blocks`: their edges are those of the chunks.
    - `identity`: data that the results depend on; JSON.
    """
    import zarr
    from zarr.codecs import ZstdCodec

    path = real_path(store)
    with temporary_folder(path.parent, f".{path.name}-") as temporary:
        new = temporary / "new"
        dataset.to_zarr(new, mode="w", zarr_format=3, consolidated=False)
        group = zarr.open_group(new, mode="r+")
        for variable in variables:
            group.create_array(
                variable.name,
                shape=(*blocks.shape, *variable.own_shape),
                chunks=(*blocks.block, *variable.own_shape),
                dtype=variable.dtype,
                # A third of the time of level 0 (zarr's default, which means 3), files as small.
                compressors=ZstdCodec(level=1),
                fill_value=variable.fill,
                dimension_names=(*identity["dimensions"], *variable.own_dimensions),
                attributes=variable.attributes,
            )
        progress = group.create_group(_PROGRESS, attributes={_SWEEP: dict(identity)})
        # Of each block: whether it is complete, and how many designs failed or have an error.
        progress.create_array(
            _DONE, shape=(len(blocks), 3), chunks=(1, 3), dtype=np.int32, fill_value=0
        )
        with contextlib.suppress(OSError):
            os.rename(new, path)
    if not path.is_dir():
        raise OSError(f"store {store} cannot be made in {path.parent}")


def stored_identity(store: Path) -> dict[str, Any] | None:
    """Data that the results in a store depend on; `None` if no sweep wrote it or it is damaged."""
    try:
        stored = json.loads((store / _PROGRESS / "zarr.json").read_text(encoding="utf-8"))
        identity = stored["attributes"][_SWEEP]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return identity if isinstance(identity, dict) else None


def check_identity(store: Path, identity: Mapping[str, Any]) -> None:
    """Check that a store belongs to this sweep, and that its blocks are written inside it.

    **Raises:** `ValueError` if it belongs to another one, cannot be read, or has links inside.
    """
    remedy = "remove it, choose another path, or replace it with resume=False (--no-resume)"
    for folder, inner, names in os.walk(store):
        for name in (*inner, *names):
            if os.path.islink(os.path.join(folder, name)):
                place = os.path.relpath(os.path.join(folder, name), store)
                raise ValueError(f"store {store} has a link inside, {place}; {remedy}")
    stored = stored_identity(store)
    if stored is None:
        raise ValueError(f"store {store} was not written by a sweep, or is damaged; {remedy}")
    for name, here in json.loads(json.dumps(identity)).items():
        there = stored.get(name)
        if there == here:
            continue
        if isinstance(there, dict) and isinstance(here, dict):
            names = {**there, **here}
            name, there, here = next(
                (f"{name}: {key}", there.get(key), here.get(key))
                for key in names
                if there.get(key) != here.get(key)
            )
        words = f"{name}: there {_short(there)}, here {_short(here)}"
        if name == "mechanism":
            words = "its mechanism has other numbers or parts"
        raise ValueError(f"store {store} belongs to another sweep ({words}); {remedy}")


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}…"


class BlockStore:
    """A store that is being written."""

    def __init__(self, path: Path):
        import zarr

        self.path = path
        self._group: Any = zarr.open_group(path, mode="r+")
        self._marks = self._group[f"{_PROGRESS}/{_DONE}"]
        self._arrays: dict[str, Any] = {}
        #: Whether `finish` found every block complete.
        self.complete = False

    def marks(self) -> np.ndarray:
        """Of every block: 1 if it is complete, designs that failed, designs with an error."""
        return np.asarray(self._marks[:])

    def write(
        self,
        number: int,
        where: tuple[slice, ...],
        arrays: dict[str, np.ndarray],
        counts: tuple[int, int],
    ) -> None:
        """Write a block, then its mark."""
        for name, values in arrays.items():
            array = self._arrays.get(name)
            if array is None:
                array = self._arrays[name] = self._group[name]
            array[where] = values
        self._marks[number] = np.asarray([1, *counts], np.int32)

    def finish(self, marks: np.ndarray) -> bool:
        """Write the number of failed designs if every block is complete; return whether it is."""
        if not marks[:, 0].all():
            return False
        counted = {"failed": int(marks[:, 1].sum()), "errors": int(marks[:, 2].sum())}
        if {name: self._group.attrs.get(name) for name in counted} != counted:
            self._group.attrs.update(counted)
        self.complete = True
        return True


def opened(path: Path) -> BlockStore:
    """The store at a path; opened once in each process that writes blocks.

    A store that was removed and made again is opened again: its blocks may be of another size.
    """
    made = (path / _PROGRESS / "zarr.json").stat()
    return _opened(path, made.st_ino, made.st_mtime_ns)


@functools.lru_cache(maxsize=4)
def _opened(path: Path, inode: int, modified: int) -> BlockStore:
    return BlockStore(path)


@contextlib.contextmanager
def writing(path: Path) -> Generator[BlockStore, None, None]:
    """A store that this process, or processes that it starts, write to.

    A process that was killed may leave a partly written file beside a chunk. Such files are removed
    when the store is complete, unless another process of this machine still writes to it.
    """
    store = BlockStore(path)
    lock = None
    # A file system without locks is accepted.
    with contextlib.suppress(OSError):
        lock = os.open(path, os.O_RDONLY)
        if fcntl is not None:
            fcntl.flock(lock, fcntl.LOCK_SH)
    try:
        yield store
        if store.complete and lock is not None and fcntl is not None:
            with contextlib.suppress(OSError):
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                for left in path.rglob("*.partial"):
                    left.unlink(missing_ok=True)
    finally:
        if lock is not None:
            os.close(lock)


def open_store(store: str | os.PathLike[str]) -> "xarray.Dataset":
    """The data set of a sweep's store; values are read when they are used.

    Designs that are not computed yet are NaN and have the code `not_computed`. The data set has the
    attribute `failed` when all designs are computed.

    No code of a store runs: it holds numbers, compressed by Zstandard. A chunk that claims to be
    larger than its array says is refused before it is decompressed.

    **Raises:** `MissingExtraError` without xarray or zarr; `ValueError` if there is no store, if it
    is damaged, or if one of its chunks needs more than 1 GiB; when values are read, `ValueError`
    for a chunk that claims too large a size.
    """
    try:
        import xarray
        import zarr  # noqa: F401
    except ImportError as error:
        raise missing_extra("sweep", "a zarr store", error) from error
    path = Path(store)
    if not (path / "zarr.json").is_file():
        raise ValueError(f"store {path} does not exist; run the sweep that writes it")
    try:
        checked = checked_store(path, _chunk_sizes(path))
        data = xarray.open_zarr(checked, consolidated=False, chunks=None, zarr_format=3)
        return _in_order(data, stored_identity(path) or {})
    except (ArithmeticError, LookupError, OSError, TypeError, ValueError) as error:
        words = f"store {path} was not written by a sweep, or is damaged: {error}; run it again"
        raise ValueError(words) from error


def _in_order(data: "xarray.Dataset", identity: Mapping[str, Any]) -> "xarray.Dataset":
    """The data set with axes, quantities and codes in the order of a sweep in memory.

    A folder lists the arrays in an order of its own.
    """

    def named(key: str) -> list[str]:
        names = identity.get(key)
        return list(map(str, names)) if isinstance(names, list | dict) else []

    quantities, gradients = named("quantities"), named("gradients")
    derived = [derivative_name(name, by) for name in quantities for by in gradients]
    axes = [name for name in named("axes") if name in data.coords]
    variables = [*quantities, *derived, "failed", "code", "error"]
    variables = [name for name in variables if name in data.data_vars]
    bare = data.drop_vars(list(data.variables))
    return bare.assign_coords(
        {name: data[name].variable for name in dict.fromkeys([*axes, *data.coords])}
    ).assign({name: data[name].variable for name in dict.fromkeys([*variables, *data.data_vars])})


def _chunk_sizes(path: Path) -> dict[str, int]:
    """Largest size of a compressed chunk by the name of its array [bytes].

    **Raises:** `ValueError` if a part of a store, read at once, would fill the memory, or is
    compressed otherwise than by a sweep.
    """
    import zarr

    sizes: dict[str, int] = {}
    for name, array in zarr.open_group(path, mode="r", zarr_format=3).arrays():
        # xarray reads coordinates when it opens a store.
        at_once = getattr(array.metadata, "dimension_names", None) == (name,)
        parts = array.shape if at_once else array.chunks
        size = math.prod(parts) * array.dtype.itemsize
        if size > _LARGEST:
            raise ValueError(f"{name} has parts of {size / 2**30:.3g} GiB, and 1 is allowed")
        metadata: Any = array.metadata
        codecs = {str(codec.to_dict()["name"]) for codec in metadata.codecs}
        if foreign := codecs - _CODECS:
            raise ValueError(f"{name} has the codec {sorted(foreign)[0]}, which no sweep writes")
        if "zstd" in codecs:
            # The length of a text is in the chunk only.
            chunk = math.prod(array.chunks) * array.dtype.itemsize
            sizes[name] = _LARGEST if "vlen-utf8" in codecs else chunk
    return sizes
