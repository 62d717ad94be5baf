"""Numbers of a batch of designs, of which each is checked as one alone."""

import numpy as np
import pytest

from prsm_jax.scenario import TrapezoidalMoveProfile


@pytest.mark.parametrize("count", [3, 64, 65, 1000])
@pytest.mark.parametrize("place", [0, 1, -1])
def test_a_zero_in_a_batch_of_moves_is_refused(count, place):
    """0 is neither the largest nor the smallest, so every number is looked at."""
    angles = np.linspace(-5.0, 7.0, count)
    angles[place] = 0.0
    with pytest.raises(ValueError, match="angle_moved is 0 rad; it must be finite and not 0"):
        TrapezoidalMoveProfile(angles, np.ones(count), np.ones(count))


@pytest.mark.parametrize("count", [3, 1000])
def test_moves_without_a_zero_pass(count):
    angles = np.linspace(-5.0, 7.1, count)
    assert TrapezoidalMoveProfile(angles, np.ones(count), np.ones(count)).angle_moved.shape == (
        count,
    )
