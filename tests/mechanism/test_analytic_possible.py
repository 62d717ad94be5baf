"""Inside a trace no number is refused; a code says that one is out of the range of files."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from scenes import example

from benchmarks.extremes.numbers import numbers_of, split
from prsm_jax.geometry import axis_possible
from prsm_jax.mechanism import AxisShaft, FarBearing, numbers_possible, set_parameter
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


def test_a_nut_beyond_its_screw_has_a_code():
    """Neighbours in the same batch keep their numbers; NaN says so by the values."""
    mechanism = example("actuator_axis")

    @jax.jit
    @jax.vmap
    def coded(distance):
        moved = set_parameter(mechanism, "nut_distance", distance, checked=False)
        return compute_coded(moved, ["first_axial_frequency"])

    # Of a screw of 500 mm.
    values, codes = coded(jnp.asarray([0.25, 0.499, 0.5, 0.6, 1.2, -0.1, jnp.nan, 0.25]))
    words = [REASONS[int(code)] for code in codes]
    beyond = "impossible_dimension"
    assert words == ["successful"] * 2 + [beyond] * 4 + ["not_finite", "successful"]
    found = values["first_axial_frequency"]
    assert bool(jnp.isfinite(found[jnp.asarray([0, 1, 7])]).all())
    assert float(found[0]) == float(found[7])


@pytest.mark.parametrize(
    ("distance", "far", "length", "possible"),
    [
        (0.2, None, 0.4, True),
        (0.4, None, 0.4, False),
        (0.7, None, None, True),
        (0.2, 0.3, 0.4, True),
        (0.2, 0.4, 0.4, True),
        (0.3, 0.3, 0.4, False),
        (0.2, 0.41, 0.4, False),
        (0.2, 0.41, None, True),
        (0.42, 0.41, None, False),
    ],
)
def test_the_nut_lies_between_the_bearings_on_the_screw(distance, far, length, possible):
    stage, axis = example("actuator_axis").stages[0], present(example("actuator_axis").axis)
    shaft = AxisShaft(0.2, None if far is None else FarBearing(0.3, 2e8))
    axis = dataclasses.replace(axis, shaft=shaft)
    stage = dataclasses.replace(stage, screw=dataclasses.replace(stage.screw, length=length))
    axis = eqx.tree_at(lambda a: a.shaft.nut_distance, axis, jnp.asarray(distance))
    if far is not None:
        axis = eqx.tree_at(lambda a: a.shaft.far_bearing.distance, axis, jnp.asarray(far))
    assert bool(axis_possible(axis, stage)) == possible
