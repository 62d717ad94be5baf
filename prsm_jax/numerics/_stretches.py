"""Functions of time at many times: stretch after stretch, each small enough for the cache.

All samples at once keep every intermediate number of every sample: past some thousand they no
longer fit the cache, and a sample of a long scene costs several times one of a short scene.
"""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

#: Samples in a stretch at most; scenes up to here are one, without a loop.
LONGEST = 1024


def over_samples(function: Callable[..., Any], *rows: Any) -> Any:
    """`jax.vmap(function)(*rows)`, in stretches of up to `LONGEST` samples.

    **Arguments:**

    - `function`: of one sample.
    - `rows`: pytrees of arrays, samples along the first axis of each.

    **Returns:** what the function gives, with samples along the first axis of every array.
    """
    count = len(jax.tree.leaves(rows)[0])
    if count <= LONGEST:
        return jax.vmap(function)(*rows)
    stretches = -(-count // LONGEST)
    # As equal as can be: what the last one lacks is less than one sample for each stretch.
    length = -(-count // stretches)
    lacking = stretches * length - count

    def cut(row):
        if lacking:
            row = jnp.concatenate([row, jnp.broadcast_to(row[-1:], (lacking, *row.shape[1:]))])
        return row.reshape(stretches, length, *row.shape[1:])

    found = jax.lax.map(lambda part: jax.vmap(function)(*part), jax.tree.map(cut, rows))
    return jax.tree.map(lambda row: row.reshape(-1, *row.shape[2:])[:count], found)
