"""Whole numbers that a program may contain, or take as a number."""

from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from ._fields import Scalar


class Count(int):
    """A whole number that is part of a pytree's structure: a node without leaves.

    A traced number may take its place in the tree, as a leaf. Beside arrays it takes their type, as
    a plain `int` does.
    """

    def __jax_array__(self) -> jax.Array:
        return jnp.asarray(int(self))


jax.tree_util.register_pytree_node(Count, lambda one: ((), int(one)), lambda one, _: Count(one))


def as_count(value: Any) -> Any:
    """A whole number as a `Count`; all else is as it was, for the checks to refuse."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    return Count(value) if whole else value


if TYPE_CHECKING:
    #: A whole number; in a sweep over it, a traced one.
    CountOrTraced = int
else:
    CountOrTraced = int | Scalar


def plain(count: CountOrTraced) -> CountOrTraced:
    """A count for arithmetic with arrays: a plain `int` takes their type, a `Count` has its own."""
    return int(count) if isinstance(count, int) else count


#: A traced number of rollers is at least this large: with fewer, other modes exist.
FEWEST_TRACED = 4


def at_least(count: CountOrTraced, fewest: int) -> bool:
    """Whether a count is `fewest` (up to 4) or more; a traced one is."""
    return not isinstance(count, int) or count >= fewest
