"""A zarr store that is written in one go, for tests of how folders take their places."""

from pathlib import Path

from prsm_jax.process import placing_in, put_folder, real_path, temporary_folder


def write_store(dataset, store):
    """Write a data set as a zarr store (format 3), under a temporary name until it is complete."""
    path = real_path(Path(store))
    with temporary_folder(path.parent, f".{path.name}-") as temporary:
        new = temporary / "new"
        # Consolidated metadata is not part of format 3, and zarr warns when it is written.
        dataset.to_zarr(new, mode="w", zarr_format=3, consolidated=False)
        with placing_in(path.parent):
            put_folder(new, path, temporary / "old")
