"""Sweeps: quantities over the full grid of any parameters."""

import os
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import jax.numpy as jnp
import numpy as np

from .._errors import MissingDataError, missing_extra
from ..fields import Scalar
from ..findings import sources
from ..mechanism import Mechanism, of_one_known_design
from ..quantities import REASONS, find_quantity
from ._axes import Grid, grid_of
from ._dataset import labelled
from ._program import evaluate_chunk

if TYPE_CHECKING:
    import xarray

#: Designs per compiled call: large enough to hide the call, small enough to stay in the cache.
DEFAULT_CHUNK = 4096


@of_one_known_design
def sweep(
    mechanism: Mechanism,
    axes: Mapping[str, Iterable[Any]],
    quantities: Iterable[str],
    *,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    chunk: int = DEFAULT_CHUNK,
    progress: bool | Callable[[int, int], None] = False,
    store: str | os.PathLike[str] | None = None,
    findings: bool = True,
) -> "xarray.Dataset":
    """Evaluate quantities on the full grid of some parameters.

    The designs are computed in chunks of fixed size by one compiled program; every combination
    of static parameters (`roller_count`) has a program of its own. Memory beyond the result does
    not grow with the grid. A design that fails, because its threads do not mesh, a contact would
    have to pull, or a value is not finite, is marked in `failed` and is NaN in all quantities;
    the other designs are not affected. A design in which `check` finds an error (teeth that
    interfere, a carrier that cuts into the screw, a load above the static capacity) is marked in
    `error` with the code of the first error; its quantities are still computed.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `axes`: values [SI] by the name of a parameter, among them `operating_point.speed` and
      whole numbers such as `roller_count`; in the order of the data set's dimensions.
    - `quantities`: names from the catalogue.
    - `speed`, `load`: operating point [rad/s, N]; default that of the mechanism.
    - `chunk`: designs per compiled call.
    - `progress`: show a progress bar; or a function that is called with the number of finished
      designs and the total number.
    - `store`: directory to write as a zarr store; an existing store is replaced when the new one
      is complete.
    - `findings`: whether to look for errors of `check` in every design; this may need more
      analyses than the quantities.

    **Returns:** an `xarray.Dataset` with one variable per quantity, the boolean `failed`, and the
    codes `code` (why a design failed) and `error` (what `check` says), over the axes (then `stage`,
    or modes). Units are in the attributes `units`, the meaning of codes in `flag_meanings`; the
    attributes `points`, `failed` and `errors` of the data set count designs.

    **Raises:** `UnknownNameError` for an unknown name; `ValueError` for axes that are empty, not
    finite, or set the same number, and for a `store` that would replace something else;
    `MissingDataError` where the mechanism lacks data; `MissingExtraError` without xarray, or
    without zarr or tqdm where they are needed.
    """
    try:
        import xarray  # noqa: F401
    except ImportError as error:
        raise missing_extra("sweep", "a sweep", error) from error
    if isinstance(quantities, str):
        raise ValueError(f"quantities is the text {quantities!r}; give a list of names")
    # A quantity that is named twice is one variable.
    names = tuple(dict.fromkeys(quantities))
    if not names:
        raise ValueError("quantities is empty; name at least one")
    for name in names:
        find_quantity(name)
    if chunk < 1:
        raise ValueError(f"chunk is {chunk}; it must be at least 1")
    grid = grid_of(mechanism, axes, {"speed": speed, "load": load})
    if store is not None:
        from ._store import check_store

        check_store(store)
    point = {
        name: None if value is None else jnp.asarray(value, jnp.result_type(float))
        for name, value in (("speed", speed), ("load", load))
    }
    with _progress_bar(grid.points, progress) as bar:
        margin_sources = sources() if findings else None
        values, codes = _evaluate(mechanism, grid, names, point, chunk, margin_sources, bar)
    dataset = labelled(mechanism, grid, values, codes, point)
    if store is not None:
        from ._store import write_store

        write_store(dataset, store)
    return dataset


def _evaluate(
    mechanism: Mechanism,
    grid: Grid,
    names: tuple[str, ...],
    point: dict[str, Any],
    chunk: int,
    sources: tuple[Any, ...] | None,
    bar,
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """All quantities over the grid, and codes of each design: why it failed, which error it has."""
    traced = grid.traced
    shape = tuple(len(axis.values) for axis in traced)
    axes = tuple(jnp.asarray(axis.values) for axis in traced)
    axis_names = tuple(axis.name for axis in traced)
    total = int(np.prod(shape))
    size = min(chunk, total)
    codes = {
        "code": np.full(grid.shape, REASONS.index("not_computed"), dtype=np.int8),
        "error": np.zeros(grid.shape, dtype=np.int8),
    }
    values: dict[str, np.ndarray] = {}

    for where, words, chosen in grid.combinations(mechanism):
        part: dict[str, np.ndarray] = {}
        part_codes = {name: np.zeros(total, dtype=np.int8) for name in codes}
        try:
            # One chunk at a time: one program keeps the cores busy by itself.
            for start in range(0, total, size):
                results, *flags = evaluate_chunk(
                    chosen,
                    axis_names,
                    axes,
                    names,
                    jnp.asarray(start),
                    size,
                    point["speed"],
                    point["load"],
                    sources,
                )
                count = min(size, total - start)
                for name, array in results.items():
                    value = np.asarray(array)
                    if name not in part:
                        part[name] = np.full((total, *value.shape[1:]), np.nan, value.dtype)
                    part[name][start : start + count] = value[:count]
                for array, flag in zip(part_codes.values(), flags, strict=True):
                    array[start : start + count] = np.asarray(flag)[:count]
                bar.update(count)
        except MissingDataError as error:
            if words:
                raise MissingDataError(f"at {words}: {error}") from error
            raise
        for name, value in part.items():
            if name not in values:
                values[name] = np.full((*grid.shape, *value.shape[1:]), np.nan, value.dtype)
            if values[name].shape[len(grid.shape) :] != value.shape[1:]:
                raise ValueError(
                    f"quantity {name!r} has {value.shape[1:]} components at {words} and "
                    f"{values[name].shape[len(grid.shape) :]} before; sweep them separately"
                )
            values[name][where] = value.reshape((*shape, *value.shape[1:]))
        for name, array in part_codes.items():
            codes[name][where] = array.reshape(shape)
    return values, codes


class _CallbackProgress:
    """Reports progress to a function, if there is one, in place of a progress bar."""

    def __init__(self, points: int, tell: Callable[[int, int], None] | None):
        self._done, self._points, self._tell = 0, points, tell

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def update(self, count: int) -> None:
        self._done += count
        if self._tell is not None:
            self._tell(self._done, self._points)


def _progress_bar(points: int, progress: bool | Callable[[int, int], None]):
    if callable(progress) or not progress:
        return _CallbackProgress(points, progress if callable(progress) else None)
    try:
        import tqdm
    except ImportError as error:
        raise missing_extra("sweep", "a progress bar", error) from error
    return tqdm.tqdm(total=points, unit=" designs", unit_scale=True, desc="sweep")
