"""A function of one design over any number of designs, with bounded working memory."""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

_In = TypeVar("_In")
_Out = TypeVar("_Out")


def map_in_chunks(
    function: Callable[[_In], _Out],
    designs: _In,
    *,
    chunk: int = 2000,
    devices: Sequence[Any] | None = None,
) -> _Out:
    """`jax.vmap(function)(designs)`, chunk by chunk.

    A chunk stays in the cache, which is several times faster than all designs at once if the
    function is long and consists of scalars. In addition to arguments and results only one chunk
    needs memory. Jittable, and differentiable if `function` is.

    **Arguments:**

    - `function`: of one design, a pytree.
    - `designs`: the same pytree with the designs along the first axis of every array. One
      array per number is faster than one row of numbers per design.
    - `chunk`: largest number of designs at once; a few thousand are fastest, fewer for longer
      functions. If the number of designs has a divisor from half of `chunk` to `chunk`, no copy
      of the arguments is made.
    - `devices`: devices that share the designs; each runs a program at the same time. A CPU can
      be several devices (`jax.config.update("jax_num_cpu_devices", 2)` before JAX is used).
      This works with all functions of this package, but your own functions that call LAPACK
      (`jax.numpy.linalg`) can deadlock.

    **Returns:** the results, with the designs along the first axis of every array.

    **Raises:** `ValueError` if there are no designs, if arrays disagree about their number, or if
    `chunk` is below 1.
    """
    totals = {jnp.shape(leaf)[:1] for leaf in jax.tree.leaves(designs)}
    if len(totals) != 1 or () in totals or (0,) in totals:
        shapes = ", ".join(str(shape) for shape in sorted(totals))
        raise ValueError(
            f"designs have the first axes {shapes or 'of no array'}; all arrays need the same "
            "length, at least 1"
        )
    if chunk < 1:
        raise ValueError(f"chunk is {chunk}; it must be at least 1")
    (total,) = next(iter(totals))
    lanes = 1 if devices is None else len(devices)
    length = -(-total // lanes)
    size = _chunk_size(length, chunk) if total % lanes == 0 else min(chunk, length)
    chunks = -(-length // size)
    missing = lanes * chunks * size - total

    def filled(leaf):
        leaf = jnp.asarray(leaf)
        if missing:
            leaf = jnp.concatenate([leaf, jnp.repeat(leaf[-1:], missing, axis=0)])
        return leaf.reshape(lanes * chunks, size, *leaf.shape[1:])

    def mapped(parts):
        return jax.lax.map(jax.vmap(function), parts)

    if devices is not None and lanes > 1:
        mesh = jax.sharding.Mesh(np.array(devices), ("designs",))
        shared = jax.sharding.PartitionSpec("designs")
        mapped = jax.shard_map(mapped, mesh=mesh, in_specs=shared, out_specs=shared)
    results = mapped(jax.tree.map(filled, designs))

    def joined(leaf):
        leaf = leaf.reshape(lanes * chunks * size, *leaf.shape[2:])
        return leaf[:total] if missing else leaf

    return jax.tree.map(joined, results)


def _chunk_size(total: int, chunk: int) -> int:
    """The largest divisor from `chunk` down to half of it, else the size of nearly equal chunks."""
    if total <= chunk:
        return total
    for size in range(chunk, chunk // 2, -1):
        if total % size == 0:
            return size
    return -(-total // -(-total // chunk))
