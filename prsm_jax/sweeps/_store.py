"""A sweep on disk: a zarr store that is either complete or absent."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from .._errors import missing_extra
from ..process import placing_in, put_folder, real_path, temporary_folder

if TYPE_CHECKING:
    import xarray

#: Files that mark a directory as a zarr store of format 3 or 2.
_MARKS = ("zarr.json", ".zgroup")


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


def write_store(dataset: "xarray.Dataset", store: str | os.PathLike[str]) -> None:
    """Write a data set as a zarr store (format 3), under a temporary name until it is complete."""
    path = real_path(Path(store))
    with temporary_folder(path.parent, f".{path.name}-") as temporary:
        new = temporary / "new"
        # Consolidated metadata is not part of format 3, and zarr warns when it is written.
        dataset.to_zarr(new, mode="w", zarr_format=3, consolidated=False)
        with placing_in(path.parent):
            put_folder(new, path, temporary / "old")
