"""Inside a trace no number is refused; a code says that one is out of the range of files."""

import equinox as eqx
import jax
import numpy as np
import pytest
from scenes import example

from benchmarks.extremes.numbers import numbers_of, split
from prsm_jax.mechanism import numbers_possible
from prsm_jax.quantities import REASONS, compute_coded

MECHANISM = example("actuator")
LEAVES, BUILD = split(MECHANISM)
NUMBERS = numbers_of(MECHANISM)


@jax.jit
def _code(leaves):
    # Of the thread alone: whatever the number is, the flag looks at all of them.
    return compute_coded(BUILD(leaves), ["centre_distance"])[1]


def _moved(place, value):
    moved = list(LEAVES)
    moved[place] = np.full_like(LEAVES[place], value)
    return REASONS[int(_code(moved))]


@pytest.mark.parametrize("place", range(len(NUMBERS)), ids=[n.name for n in NUMBERS])
def test_every_number_of_a_stage_is_held_to_its_range(place):
    number = NUMBERS[place]
    if not number.name.startswith("stage"):
        pytest.skip("speed and load may be anything that is finite")
    limit = number.limit
    for end, allowed, beyond in (
        (limit.lower, limit.lower_allowed, -np.inf),
        (limit.upper, limit.upper_allowed, np.inf),
    ):
        if not np.isfinite(end):
            continue
        # Denormal numbers are zero in compiled programs.
        outside = np.nextafter(end, beyond) if end else np.copysign(1e-300, beyond)
        outside = outside if allowed else end
        # The screw's radius and the gaps between bodies have limits of their own.
        assert _moved(place, outside) == "impossible_dimension"
    if limit.admits(-1.0):
        assert _moved(place, -1.0) == "successful"


def test_nan_is_no_number_out_of_its_range():
    """What depends on it is NaN, and says so; what does not is right."""
    place = [n.name for n in NUMBERS].index("stage.1.material.density")
    assert _moved(place, np.nan) == "successful"


def test_lists_are_held_to_it_too():
    stage = example("actuator_load_sharing").stages[0]
    relief = eqx.tree_at(
        lambda s: s.load_sharing.screw_wear,
        stage,
        np.array([0.0, -1e-6]),
        is_leaf=lambda x: x is None,
    )
    assert bool(numbers_possible(stage))
    assert not bool(numbers_possible(relief))
