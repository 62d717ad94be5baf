"""What the tests of files share."""

import jax
import numpy as np
import pytest


def _identical(one, other) -> bool:
    """Same structure (static data too), and every number the same bit for bit."""
    leaves, tree = jax.tree.flatten(one)
    other_leaves, other_tree = jax.tree.flatten(other)
    return tree == other_tree and all(
        a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
        for a, b in zip(map(np.asarray, leaves), map(np.asarray, other_leaves), strict=True)
    )


@pytest.fixture(scope="session")
def identical():
    """Whether two mechanisms are the same: structure, static data, and every number's bits."""
    return _identical
