"""The one place where the floating-point precision is chosen.

Natural frequencies squared reach 1e11 and contact approaches 1e-6 m in the same model, so float64
is the default and is enabled when `prsm_jax` is imported. Float32 is a choice with a cost that
`benchmarks` reports: cast the mechanism with `to_precision(mechanism, jnp.float32)`; every law
follows the dtype of what it is given.
"""

from typing import TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import DTypeLike

_Tree = TypeVar("_Tree")

jax.config.update("jax_enable_x64", True)


def to_precision(tree: _Tree, dtype: DTypeLike) -> _Tree:
    """Cast every floating-point leaf of a pytree (a mechanism, a result) to `dtype`."""

    def cast(leaf):
        is_float = isinstance(leaf, jax.Array | np.ndarray) and jnp.issubdtype(
            leaf.dtype, jnp.floating
        )
        return jnp.asarray(leaf, dtype=dtype) if is_float else leaf

    return jax.tree.map(cast, tree)
