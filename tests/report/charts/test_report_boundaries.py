"""A design exactly at a limit is within it: lines, ticks and hatching on either side of it."""

import numpy as np
import pytest

from prsm_jax.report.sweep_charts._boundaries import _two_sides, crossings, outside_ranges

X = np.array([0.0, 1.0, 2.0, 4.0])


@pytest.mark.parametrize(
    ("excess", "found", "ranges"),
    [
        # Through a design: one line there, outside above or below it.
        ([-2.0, 0.0, 1.0, 1.0], [(1.0, True)], [(1.0, 4.0)]),
        ([2.0, 0.0, -1.0, -1.0], [(1.0, False)], [(0.0, 1.0)]),
        # Between designs, in the ratio of the distances.
        ([-1.0, -1.0, -1.0, 3.0], [(2.5, True)], [(2.5, 4.0)]),
        # Touched from within: no line, and nothing outside.
        ([-1.0, 0.0, -1.0, -1.0], [], []),
        ([0.0, 0.0, 0.0, 0.0], [], []),
        # At the limit over a whole range: outside begins at its end.
        ([0.0, 0.0, 0.0, 5.0], [(2.0, True)], [(2.0, 4.0)]),
        # Next to a design that failed nothing is known.
        ([-1.0, np.nan, 1.0, 1.0], [], [(2.0, 4.0)]),
    ],
)
def test_lines_and_ranges(excess, found, ranges):
    assert crossings(X, np.array(excess)) == found
    assert outside_ranges(X, [np.array(excess)]) == ranges


def test_one_limit_is_enough():
    low, high = np.array([1.0, -1.0, -1.0, -1.0]), np.array([-1.0, -1.0, 0.0, 1.0])
    assert outside_ranges(X, [low, high]) == [(0.0, 0.5), (2.0, 4.0)]


@pytest.mark.parametrize(
    ("excess", "both"),
    [
        ([0.0, 1.0], True),
        ([0.0, -1.0], False),
        ([-1.0, 1.0], True),
        ([1.0, np.nan], False),
        ([np.nan], False),
    ],
)
def test_a_design_at_the_limit_counts_as_within(excess, both):
    assert _two_sides(np.array(excess)) == both
