"""Sums, products and extremes of a few numbers, as plain operations.

From jaxlib 0.10 on, XLA on a CPU passes reductions and products of matrices to a library of kernels
for long rows. For the two or three numbers of a vector or of a mechanism's stages this costs more
than the operation itself: it took 40 % of the time of a RODASP step in a batch.
"""

import functools

import jax
import jax.numpy as jnp
from jaxtyping import Array, Shaped

from ._guards import root_or_zero


def _parts(values: Shaped[Array, "..."], axis: int) -> list[Array]:
    return [jax.lax.index_in_dim(values, k, axis, False) for k in range(values.shape[axis])]


def sum_few(values: Shaped[Array, "..."], axis: int = -1) -> Shaped[Array, "..."]:
    """`jnp.sum(values, axis)` of a few numbers along the axis, at least one."""
    return functools.reduce(jnp.add, _parts(values, axis))


def max_few(values: Shaped[Array, "..."], axis: int = -1) -> Shaped[Array, "..."]:
    """`jnp.max(values, axis)` of a few numbers along the axis, at least one."""
    return functools.reduce(jnp.maximum, _parts(values, axis))


def min_few(values: Shaped[Array, "..."], axis: int = -1) -> Shaped[Array, "..."]:
    """`jnp.min(values, axis)` of a few numbers along the axis, at least one."""
    return functools.reduce(jnp.minimum, _parts(values, axis))


def any_few(values: Shaped[Array, "..."], axis: int = -1) -> Shaped[Array, "..."]:
    """`jnp.any(values, axis)` of a few truth values along the axis, at least one."""
    return functools.reduce(jnp.logical_or, _parts(values, axis))


def all_few(values: Shaped[Array, "..."], axis: int = -1) -> Shaped[Array, "..."]:
    """`jnp.all(values, axis)` of a few truth values along the axis, at least one."""
    return functools.reduce(jnp.logical_and, _parts(values, axis))


def dot_few(first: Shaped[Array, "..."], second: Shaped[Array, "..."]) -> Shaped[Array, "..."]:
    """Scalar product of two vectors of a few numbers, or a matrix of a few columns times one."""
    return sum_few(first * jnp.broadcast_to(second, first.shape))


def length_few(vector: Shaped[Array, "..."], axis: int = -1) -> Shaped[Array, "..."]:
    """Length of a vector of a few numbers; 0, with derivative 0, for a zero vector."""
    return root_or_zero(sum_few(vector**2, axis))


__all__ = ["all_few", "any_few", "dot_few", "length_few", "max_few", "min_few", "sum_few"]
