"""Missing and unequal rollers in statics, masses and motion: closed forms."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from scenes import equal_shares

import prsm_jax as prsm
from prsm_jax.dynamics.forces._stage_forces import axial_inertia, carrier_inertia
from prsm_jax.mechanism import (
    UnequalRoller,
    body_inertia,
    body_mass,
    mean_roller_inertia,
    mean_roller_mass,
    stage_mass,
)
from prsm_jax.stiffness import ThreadStiffness, axial_stiffness
from prsm_jax.vibration._families import _orthonormal

# Sums and products of a few doubles.
_ROUNDING = 1e-14


@pytest.fixture(scope="module")
def actuator():
    """The actuator: ten equal rollers, whose threads share equally."""
    return equal_shares("actuator")


def _with(mechanism, *rollers, **changes):
    stage = dataclasses.replace(mechanism.stages[0], unequal_roller=rollers, **changes)
    return dataclasses.replace(mechanism, stages=(stage,))


def test_a_missing_roller_is_one_less_to_everything_but_the_places(actuator):
    missing = _with(actuator, UnequalRoller(4, missing=True))
    fewer = _with(actuator, roller_count=9)
    (one,), (other,) = missing.stages, fewer.stages
    assert (one.roller_count, one.present_roller_count) == (10, 9)
    for law in (stage_mass, axial_inertia, carrier_inertia):
        assert float(law(one)) == float(law(other))
    names = ["efficiency", "drive_torque", "contact_force", "max_pressure"]
    values, expected = prsm.compute(missing, names), prsm.compute(fewer, names)
    for name in names:
        np.testing.assert_array_equal(values[name], expected[name])


def test_masses_of_unequal_rollers_add_up(actuator):
    stage = actuator.stages[0]
    rollers = (
        UnequalRoller(1, mass_factor=1.2),
        UnequalRoller(2, stiffness_factor=0.5),
        UnequalRoller(7, missing=True),
    )
    unequal = _with(actuator, *rollers).stages[0]
    mass, inertia = float(body_mass(stage, "roller")), float(body_inertia(stage, "roller"))
    total = 1.2 + 8
    np.testing.assert_allclose(mean_roller_mass(unequal), mass * total / 9, rtol=_ROUNDING)
    np.testing.assert_allclose(mean_roller_inertia(unequal), inertia * total / 9, rtol=_ROUNDING)
    for law in (stage_mass, axial_inertia):
        change = float(law(unequal)) - float(law(stage))
        # The difference of two masses that are tens of times larger.
        np.testing.assert_allclose(change, mass * (total - 10), rtol=1e3 * _ROUNDING)


def test_axial_stiffness_adds_over_the_rollers(actuator):
    threads = ThreadStiffness(jnp.asarray(3e8), jnp.asarray(6e8))
    rollers = (UnequalRoller(2, stiffness_factor=0.5), UnequalRoller(7, missing=True))
    unequal = _with(actuator, *rollers).stages[0]
    np.testing.assert_allclose(axial_stiffness(unequal, threads), 8.5 * 2e8, rtol=_ROUNDING)


def test_masses_of_all_rollers_scaled_are_a_scaled_roller(actuator):
    stage = actuator.stages[0]
    all_heavier = _with(actuator, *(UnequalRoller(n, mass_factor=1.3) for n in range(1, 11)))
    roller = dataclasses.replace(
        stage.roller,
        mass=1.3 * body_mass(stage, "roller"),
        inertia=1.3 * body_inertia(stage, "roller"),
    )
    heavier = _with(actuator, roller=roller)
    for law in (stage_mass, axial_inertia, carrier_inertia):
        np.testing.assert_allclose(
            law(all_heavier.stages[0]), law(heavier.stages[0]), rtol=10 * _ROUNDING
        )


def test_patterns_are_orthonormal_and_a_pattern_of_nan_stays_nan():
    ones, slope = jnp.ones(4), jnp.arange(4.0)
    rows = np.asarray(_orthonormal([ones, 2 * ones, slope]))
    # The second depends on the first; the third is the slope without its mean.
    expected = [[0.5] * 4, [0.0] * 4, np.array([-1.5, -0.5, 0.5, 1.5]) / np.sqrt(5)]
    np.testing.assert_allclose(rows, expected, atol=1e-15)
    assert np.isnan(_orthonormal([ones, ones.at[2].set(jnp.nan)])[1]).all()
