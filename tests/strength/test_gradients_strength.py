"""Derivatives of strength and life to all numbers at once: forward, reverse and by differences."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from derivatives import (
    all_values,
    along,
    by_all_numbers,
    central_slope,
    inner,
    some_direction,
)
from scenes import equal_shares, stage

from prsm_jax.friction import CoulombFriction, Friction
from prsm_jax.mechanism import (
    AxialPlay,
    DutyCycle,
    LoadSharing,
    Mechanism,
    OperatingPoint,
    Strength,
)
from prsm_jax.quantities import available_quantities, catalogue

_FILES = ("_strength", "_rating_life", "_play")
NAMES = tuple(q.name for q in catalogue() if q.function.__module__.endswith(_FILES))


def _actuator(**duty):
    """The actuator with equal shares, and with a duty cycle of three phases."""
    given = {"duration": [3.0, 2.0, 1.0], "speed": [10.0, -50.0, 200.0], "load": [3e3, 9e3, 1.4e4]}
    one = equal_shares("actuator")
    new = [jnp.asarray((given | duty)[name]) for name in given]
    return eqx.tree_at(lambda m: [getattr(m.duty_cycle, n) for n in given], one, new)


#: What a preload makes; the actuator has none.
PRELOADED = {
    *("preload_opening_load", "preloaded_pressure", "preloaded_stiffness", "preload_torque"),
}
AVAILABLE = tuple(name for name in NAMES if name not in PRELOADED)


@pytest.fixture(scope="module")
def parts():
    return eqx.partition(_actuator(), eqx.is_inexact_array)


def test_nothing_is_left_out():
    assert set(available_quantities(_actuator(), NAMES)) == set(AVAILABLE)


def test_forward_agrees_with_differences(parts):
    leaves, rest = parts
    direction = some_direction(leaves, 5)
    values, slopes = along(leaves, direction, rest, AVAILABLE)
    found = central_slope(leaves, direction, rest, AVAILABLE)
    # Second order in a step of 1e-6, and rounding of 1e-16 over it: the meshing has 1e-12.
    np.testing.assert_allclose(
        slopes,
        found,
        rtol=1e-6,
        atol=2e-6 * np.abs(values).max(initial=0, where=np.abs(values) < 1),
    )
    assert np.isfinite(values).all()


@pytest.mark.parametrize(
    "duty",
    [
        {},
        {"load": [0.0, 0.0, 0.0]},
        {"load": [5e3, 5e3, 5e3]},
        {"load": [5e3, -5e3, 0.0]},
        {"speed": [0.0, 0.0, 10.0]},
        {"speed": [0.0, 0.0, 0.0]},
        {"load": [1e-9, 0.0, 1e9]},
    ],
    ids=["ordinary", "no load", "equal", "both flanks", "standing", "never turning", "extreme"],
)
def test_reverse_agrees_with_forward_and_stays_finite(duty):
    leaves, rest = eqx.partition(_actuator(**duty), eqx.is_inexact_array)
    direction = some_direction(leaves, 5)
    values, slopes = along(leaves, direction, rest, AVAILABLE)
    assert not np.isnan(values).any()
    assert np.isfinite(slopes).all()
    # Each quantity of order one, so that none drowns in another's rounding.
    scale = jnp.where(jnp.isfinite(values) & (values != 0), jnp.abs(values), 1.0)
    for weights in (jnp.ones_like(values) / scale, jnp.cos(jnp.arange(values.size)) / scale):
        gradient = by_all_numbers(leaves, weights, rest, AVAILABLE)
        assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(gradient))
        expected = float(jnp.sum(weights * slopes))
        size = float(jnp.sum(jnp.abs(weights * slopes)))
        assert inner(gradient, direction) == pytest.approx(expected, abs=1e-10 * size)


#: What rests on a preload, and on how threads share the largest and the equivalent load.
SHARED = (*sorted(PRELOADED), "lost_motion", "static_safety", "rating_life")


def _preloaded():
    """Two preloaded nuts of four threads with pitch errors, and a duty cycle."""
    sharing = LoadSharing(
        4,
        screw_segment_stiffness=4e8,
        roller_segment_stiffness=1e8,
        nut_segment_stiffness=8e8,
        nut_pitch_error=jnp.asarray([0.0, 1e-6, -5e-7, 2e-6]),
    )
    data = Strength(4.2e9, material_factor=1.1, play=AxialPlay(preload_force=2e3))
    one = stage(
        friction=Friction(thread=CoulombFriction(0.06)),
        curvature="wu2022",
        gear=None,
        engaged_threads=4.0,
        strength=data,
        load_sharing=sharing,
    )
    cycle = DutyCycle(*(jnp.asarray(x) for x in ([2.0, 1.0], [10.0, -40.0], [1e3, 3e3])))
    return Mechanism((one,), OperatingPoint(100.0, 1.5e3), duty_cycle=cycle)


@eqx.filter_jit
def _all_ways(leaves, direction, weights, rest):
    def values(given):
        return all_values(given, rest, SHARED)

    here, slopes = jax.jvp(values, (leaves,), (direction,))
    return here, slopes, jax.vjp(values, leaves)[1](weights / here)[0]


def test_derivatives_through_preload_and_shared_loads():
    leaves, rest = eqx.partition(_preloaded(), eqx.is_inexact_array)
    direction = some_direction(leaves, 5)
    weights = jnp.cos(jnp.arange(float(len(SHARED))))
    here, slopes, gradient = _all_ways(leaves, direction, weights, rest)
    step = 1e-5
    ends = [
        _all_ways(
            jax.tree.map(lambda x, d, s=s: x + s * step * d, leaves, direction),
            direction,
            weights,
            rest,
        )[0]
        for s in (1, -1)
    ]
    assert np.isfinite(here).all()
    # Second order in a step of 1e-5; the balance of the threads has 1e-12, over the step 1e-7.
    np.testing.assert_allclose(
        slopes / here, (ends[0] - ends[1]) / (2 * step * here), rtol=1e-6, atol=1e-6
    )
    expected = jnp.sum(weights / here * slopes)
    size = float(jnp.sum(jnp.abs(weights / here * slopes)))
    assert inner(gradient, direction) == pytest.approx(float(expected), abs=1e-9 * size)
