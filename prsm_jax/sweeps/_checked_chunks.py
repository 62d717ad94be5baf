"""A zarr store whose chunks are looked at before they are decompressed.

A compressed chunk states how large it is when it is read, and the decompressor believes it: a file
of a few bytes could ask for terabytes. Stores may come from other people.
"""

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: Longest header of a frame of Zstandard, with the number it begins with (RFC 8878, 3.1.1).
_HEADER, _MAGIC = 18, b"\x28\xb5\x2f\xfd"


def claimed_size(header: bytes) -> int | None:
    """Size of a Zstandard frame after decompression, as its header states it [bytes].

    `None` where the header states none, or is not that of a frame (RFC 8878, section 3.1.1).

    **Arguments:**

    - `header`: the first 18 bytes of the frame, or all of a shorter one.
    """
    if header[:4] != _MAGIC or len(header) < 6:
        return None
    descriptor = header[4]
    single = bool(descriptor & 0x20)
    width = (1 if single else 0, 2, 4, 8)[descriptor >> 6]
    # A byte for the window unless it is the whole frame, then the number of a dictionary.
    start = 5 + (not single) + (0, 1, 2, 4)[descriptor & 3]
    field = header[start : start + width]
    if width == 0 or len(field) < width:
        return None
    return int.from_bytes(field, "little") + (256 if width == 2 else 0)


def checked_store(path: Path, limits: Mapping[str, int]) -> Any:
    """A store of zarr for reading that refuses chunks which claim more than they may hold.

    **Arguments:**

    - `path`: directory of the store.
    - `limits`: largest size of a chunk by the name of its array [bytes]; the chunks of other arrays
      are not looked at.

    **Returns:** a store; reading from it raises `ValueError` with the chunk and both sizes.
    """
    return _class()(path, dict(limits))


@functools.cache
def _class() -> Any:
    # zarr is optional, and slow to import.
    from zarr.storage import LocalStore

    class CheckedStore(LocalStore):
        def __init__(self, root: Path, limits: dict[str, int]):
            super().__init__(root, read_only=True)
            self._limits = limits

        async def get(self, key: str, *arguments: Any, **options: Any) -> Any:
            found = await super().get(key, *arguments, **options)
            limit = self._limits.get(key.partition("/c")[0])
            if found is not None and limit is not None and not key.endswith("zarr.json"):
                _check(key, bytes(found.as_numpy_array()[:_HEADER]), limit)
            return found

    return CheckedStore


def _check(key: str, header: bytes, limit: int) -> None:
    claimed = claimed_size(header)
    if claimed is None:
        raise ValueError(f"the chunk {key} does not say how large it is; it is not read")
    if claimed > limit:
        raise ValueError(
            f"the chunk {key} claims {claimed} bytes when it is decompressed, and holds at most "
            f"{limit}; it is not read"
        )
