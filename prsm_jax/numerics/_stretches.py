"""Functions of time at many times, in blocks that are small enough for the cache.

All samples at once keep every intermediate number of every sample: above some thousand samples they
no longer fit the cache, and a sample of a long scenario costs several times as much as one of a
short scenario.
"""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

#: Maximum number of samples in a block; up to this number there is one block, without a loop.
LONGEST = 1024


def over_samples(function: Callable[..., Any], *rows: Any) -> Any:
    """`jax.vmap(function)(*rows)`, in blocks of up to `LONGEST` samples.

    **Arguments:**

    - `function`: of one sample.
    - `rows`: pytrees of arrays, samples along the first axis of each.

    **Returns:** the results, with samples along the first axis of every array.
    """
    count = len(jax.tree.leaves(rows)[0])
    if count <= LONGEST:
        return jax.vmap(function)(*rows)
    blocks = -(-count // LONGEST)
    # Blocks of nearly equal length: the padding of the last one is below one sample per block.
    length = -(-count // blocks)
    padding = blocks * length - count

    def cut(row):
        if padding:
            row = jnp.concatenate([row, jnp.broadcast_to(row[-1:], (padding, *row.shape[1:]))])
        return row.reshape(blocks, length, *row.shape[1:])

    results = jax.lax.map(lambda part: jax.vmap(function)(*part), jax.tree.map(cut, rows))
    return jax.tree.map(lambda row: row.reshape(-1, *row.shape[2:])[:count], results)
