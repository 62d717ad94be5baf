"""Sweeps: quantities and their derivatives over many designs."""

import hashlib
import math
import os
import re
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from .._errors import missing_extra
from .._version import __version__
from ..fields import Scalar
from ..mechanism import Mechanism, find_parameters, of_one_known_design
from ..process import placing_in, put_folder, real_path, temporary_folder
from ..quantities import QuantityLike, find_quantity, is_function, quantity_names
from ._labels import empty_dataset
from ._plan import PlanName, blocks_of, plan_of
from ._run import Job, run_blocks
from ._sizes import block_size, call_size, fitting_size
from ._store import (
    check_identity,
    check_store,
    create_store,
    open_store,
    stored_identity,
    writing,
)

if TYPE_CHECKING:
    import xarray


@of_one_known_design
def sweep(
    mechanism: Mechanism,
    axes: Mapping[str, Iterable[Any]],
    quantities: Iterable[QuantityLike],
    *,
    plan: PlanName = "grid",
    points: int | None = None,
    seed: int = 0,
    gradients: Iterable[str] = (),
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    chunk: int | None = None,
    progress: bool | Callable[[int, int], None] = False,
    store: str | os.PathLike[str] | None = None,
    resume: bool = True,
    shard: tuple[int, int] | None = None,
    executor: Executor | None = None,
    findings: bool = True,
    hold_axes: bool = False,
) -> "xarray.Dataset":
    """Evaluate quantities, and on request their derivatives, at many designs.

    One compiled program computes the designs in blocks. Numbers of rollers from 4 on share it where
    the quantities allow; every other combination of whole numbers has a program of its own. A
    design fails if its threads do not mesh, a contact would have to pull, or a value is not finite.
    It is then marked in `failed` and is NaN in all quantities; other designs are not affected. A
    design in which `check` finds an error (teeth that interfere, a carrier that cuts into the
    screw, a load above the static capacity) is marked in `error` with the code of the first error;
    its quantities are still computed.

    With a `store`, each block is written when it is computed, and memory does not grow with the
    number of designs. A run that was stopped continues where it stopped; the store has the same
    bytes as that of an uninterrupted run on the same kind of machine. A complete store is not
    computed again. Several processes can write to one store, on one machine or on many with a
    common folder: each with a `shard` of its own, or as workers of an `executor`.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `axes`: values [SI] by the name of a parameter, among them `operating_point.speed` and
      whole numbers such as `roller_count`; in the order of the data set's dimensions.
    - `quantities`: names from the catalogue; without store and executor also functions of a
      mechanism that return one number.
    - `plan`: `"grid"`: all combinations of the values. `"list"`: the first value of every axis,
      then the second, and so on. `"lhs"`: a Latin hypercube, or `"sobol"`: Sobol's sequence, of
      `points` designs between two limits on every axis.
    - `points`, `seed`: of `"lhs"` and `"sobol"`.
    - `gradients`: parameters by which every quantity is differentiated, exactly. As in
      `sensitivity`, each changes alone, in all stages by equal amounts, together with the
      dimensions that follow from it.
    - `speed`, `load`: operating point [rad/s, N]; default that of the mechanism.
    - `chunk`: largest number of designs in a block, which is stored as a whole. Default: that of
      the store, or a 32nd of the designs, from 4,096 to 32,768 (131,072 on an accelerator); fewer
      if the results of a block would take more than 64 MiB. A block is computed in one or several
      calls, which on a processor are as large as its cache allows.
    - `progress`: show a progress bar; or a function that is called with the number of finished
      designs and the total number; with a shard, of its designs only.
    - `store`: directory of a zarr store.
    - `resume`: continue a store of the same sweep. If not, an existing store is replaced when the
      new one is complete.
    - `shard`: (i, n), from 1: compute only every n-th block, beginning with block i. Needs a
      store, and `resume`.
    - `executor`: workers that compute the blocks: a `concurrent.futures.Executor`, for example that
      of a Dask client. Default: threads of this process, one for each core or device.
    - `findings`: whether to look for errors of `check` in every design; this may need more
      analyses than the quantities.
    - `hold_axes`: whether a derivative by an axis keeps the values of the other axes, where one
      follows from another (`pitch` from `starts`): it is then the slope along the axis.

    **Returns:** an `xarray.Dataset` with one variable per quantity, one per derivative
    (`efficiency_by_lead`), the boolean `failed`, and the codes `code` (why a design failed) and
    `error` (what `check` says). The dimensions of a grid are its axes, those of other plans
    `design`; then `stage`, or modes. Units are in the attributes `units`, the meaning of codes in
    `flag_meanings`; the attributes `points`, `failed` and `errors` of the data set count designs.
    With a store, values are read when they are used; while blocks of other shards are missing, the
    data set has no attribute `failed`.

    **Raises:** `UnknownNameError` for an unknown name; `ValueError` for axes that are empty, not
    finite, or set the same number, for limits or lists that do not fit the plan, for a `store` of
    another sweep or another version, and for one that would replace something else;
    `MissingDataError` where the mechanism lacks data; `MissingExtraError` without xarray, or
    without zarr, SciPy or tqdm where they are needed.
    """
    try:
        import xarray  # noqa: F401
    except ImportError as error:
        raise missing_extra("sweep", "a sweep", error) from error
    names = quantity_names(_names("quantities", quantities))
    own = [name for name in names if is_function(name)]
    if own and (store is not None or executor is not None):
        raise ValueError(
            f"quantities has the function {own[0]}, which a store or another process does not "
            "know; add it to the catalogue by the decorator prsm_jax.quantity"
        )
    if not names:
        raise ValueError("quantities is empty; name at least one")
    for name in names:
        find_quantity(name)
    parameters = _names("gradients", gradients)
    for name in parameters:
        if find_parameters(mechanism, name)[0].static:
            raise ValueError(f"gradients names {name}, a whole number, which has no derivative")
    if chunk is not None and not (isinstance(chunk, int) and chunk >= 1):
        raise ValueError(f"chunk is {chunk}; it must be a whole number of at least 1")
    laid_out = plan_of(mechanism, axes, {"speed": speed, "load": load}, plan, points, seed)
    shares = _checked_shard(shard, store, resume)
    if store is not None:
        check_store(store)
    blocks = blocks_of(laid_out.shape, chunk or block_size(laid_out.points))
    point = _point(speed, load)
    job = Job(mechanism, laid_out, blocks, names, parameters, point, findings, call_size())
    job = replace(job, hold_axes=hold_axes)
    path = None if store is None else real_path(Path(store))
    replacing = path is not None and not resume and path.exists()
    if path is None or replacing or not path.exists() or not any(path.iterdir()):
        job = job if chunk else _fitted(job)
        if path is not None and not replacing:
            _create(job, path)
    if path is not None and not replacing:
        # Another process may have been first.
        job = _as_stored(job, path, chunk)
    mine = range(shares[0] - 1, len(job.blocks), shares[1])
    with _progress_bar(_designs(job, mine), progress) as bar:
        if path is None:
            return _in_memory(job, executor, bar)
        fill = _in_new_store if replacing else _in_store
        return fill(job, path, mine, executor, bar)


def collect(store: str | os.PathLike[str]) -> "xarray.Dataset":
    """Finish the store that the shards of a sweep have written; nothing is computed.

    **Arguments:**

    - `store`: its path.

    **Returns:** the data set; values are read when they are used.

    **Raises:** `ValueError` if there is no store of a sweep, or if blocks are missing.
    """
    path = real_path(Path(store))
    if not path.exists():
        raise ValueError(f"store {store} does not exist; run the shards first")
    if stored_identity(path) is None:
        raise ValueError(f"store {store} was not written by a sweep, or is damaged; remove it")
    with writing(path) as written:
        marks = written.marks()
        if not written.finish(marks):
            raise ValueError(
                f"store {store}: {int((marks[:, 0] == 0).sum())} of {len(marks)} blocks are not "
                "computed yet; run the shards that were stopped again, or the sweep without a shard"
            )
    return open_store(path)


def _point(speed, load) -> dict[str, float | None]:
    return {
        name: None if value is None else float(value)
        for name, value in (("speed", speed), ("load", load))
    }


def _names(argument: str, names: Iterable[Any]) -> tuple[Any, ...]:
    """Names without repetitions: a quantity that is named twice is one variable."""
    if isinstance(names, str):
        raise ValueError(f"{argument} is the text {names!r}; give a list of names")
    return tuple(dict.fromkeys(names))


def _checked_shard(shard, store, resume: bool) -> tuple[int, int]:
    if shard is None:
        return 1, 1
    whole = isinstance(shard, tuple) and len(shard) == 2 and all(isinstance(i, int) for i in shard)
    if not whole:
        raise ValueError(f"shard is {shard!r}; give its number and the number of shards: (3, 16)")
    index, count = shard
    if not 1 <= index <= count:
        raise ValueError(f"shard is {index} of {count}; it must be from 1 to the number of shards")
    if store is None:
        raise ValueError("shard is given without a store; name the store that all shards write to")
    if not resume:
        raise ValueError("shard is given with resume=False, but shards continue a common store")
    return index, count


def _as_stored(job: Job, store: Path, chunk: int | None) -> Job:
    """The job with calls and, unless `chunk` is given, blocks as large as in an existing store.

    **Raises:** `ValueError` if the store belongs to another sweep.
    """
    stored = stored_identity(store) or {}
    call, block = stored.get("call"), stored.get("chunk")
    if isinstance(call, int) and call >= 1:
        job = replace(job, call=call)
    if chunk is None and isinstance(block, int) and block >= 1:
        job = replace(job, blocks=blocks_of(job.plan.shape, block))
    check_identity(store, _identity(job))
    return job


def _fitted(job: Job) -> Job:
    """The job in blocks whose results fit into the memory that they may take."""
    size = fitting_size(job.blocks.size, job.result_bytes())
    if size == job.blocks.size:
        return job
    return replace(job, blocks=blocks_of(job.plan.shape, size))


def _designs(job: Job, blocks: Iterable[int]) -> int:
    """Number of designs in blocks."""
    return sum(math.prod(job.blocks.lengths(number)) for number in blocks)


def _in_memory(job: Job, executor: Executor | None, bar) -> "xarray.Dataset":
    variables = job.variables()
    arrays = {
        variable.name: np.full(
            (*job.plan.shape, *variable.own_shape), variable.fill, variable.dtype
        )
        for variable in variables
    }
    counts = np.zeros(2, int)
    for done in run_blocks(job, range(len(job.blocks)), executor):
        where = job.blocks.slices(done.number)
        counts += done.counts
        for name, part in (done.arrays or {}).items():
            arrays[name][where] = part
        bar.update(done.designs)
    data = empty_dataset(job.mechanism, job.plan, variables, job.point)
    for variable in variables:
        dimensions = (*job.plan.dimensions, *variable.own_dimensions)
        data[variable.name] = (dimensions, arrays[variable.name], variable.attributes)
    return data.assign_attrs(failed=int(counts[0]), errors=int(counts[1]))


def _create(job: Job, path: Path) -> None:
    variables = job.variables()
    data = empty_dataset(job.mechanism, job.plan, variables, job.point)
    create_store(path, data, variables, job.blocks, _identity(job))


def _in_store(
    job: Job, path: Path, mine: range, executor: Executor | None, bar
) -> "xarray.Dataset":
    """Compute blocks that are missing in a store."""
    points = _designs(job, mine)
    with writing(path) as blocks:
        marks = blocks.marks()
        left = [number for number in mine if not marks[number, 0]]
        before = points - _designs(job, left)
        for block in run_blocks(replace(job, store=path), left, executor):
            # With the first block, so that the time of the compilation is not in the rate.
            bar.update(before + block.designs)
            before = 0
        if before:
            bar.update(before)
        blocks.finish(blocks.marks() if left else marks)
    return open_store(path)


def _in_new_store(
    job: Job, path: Path, mine: range, executor: Executor | None, bar
) -> "xarray.Dataset":
    """Compute all blocks into a store that then takes the place of another."""
    with temporary_folder(path.parent, f".{path.name}-") as temporary:
        new = temporary / "new"
        _create(job, new)
        _in_store(job, new, mine, executor, bar)
        with placing_in(path.parent):
            put_folder(new, path, temporary / "old")
    return open_store(path)


def _identity(job: Job) -> dict[str, Any]:
    """Data that the bytes of a store depend on; JSON."""
    return {
        "prsm_jax": __version__,
        "jax": jax.__version__,
        "plan": job.plan.kind,
        "points": job.plan.points,
        "dimensions": list(job.plan.dimensions),
        "axes": {axis.name: _digest(axis.values.tobytes()) for axis in job.plan.axes},
        "quantities": list(job.quantities),
        "gradients": list(job.gradients),
        # Of derivatives only: stores of sweeps without any have no such entry.
        **({"hold_axes": job.hold_axes} if job.gradients else {}),
        "point": job.point,
        "findings": job.findings,
        "precision": str(jnp.result_type(float)),
        "chunk": job.blocks.size,
        "call": job.call,
        "block": list(job.blocks.block),
        "mechanism": _fingerprint(job.mechanism),
    }


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]


def _fingerprint(mechanism: Mechanism) -> str:
    """A digest that is equal for equal mechanisms, also in another process."""
    leaves = [leaf for leaf in jax.tree.leaves(mechanism) if eqx.is_array(leaf)]
    numbers = b"".join(np.asarray(leaf).tobytes() for leaf in leaves)
    words = eqx.tree_pformat(mechanism, short_arrays=True)
    # Some objects are printed with the address at which they lie.
    return _digest(numbers + re.sub(r" at 0x[0-9a-f]+", "", words).encode())


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
