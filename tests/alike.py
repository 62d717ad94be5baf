"""Results of two programs compared."""

import jax
import numpy as np


def same_but_for_rounding(found, expected):
    """The same structure, classes and words; numbers but for another order of additions."""
    assert jax.tree.structure(found) == jax.tree.structure(expected)
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-12 * np.max(np.abs(other)))
