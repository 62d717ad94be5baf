"""Transients: power balance with everything that moves, and the way to the steady state."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array, Float
from scenes import (
    ALL_LOSSES,
    FIRST_STAGE_LOSSES,
    LOSS_NAMES,
    array,
    mechanism,
    simulate,
    stage,
    steady_state,
    thread,
)

import prsm_jax as prsm
from prsm_jax.friction import CoulombFriction, Friction


class Swinging(eqx.Module):
    """mean + amplitude sin(rate t), differentiable in its numbers."""

    mean: Float[Array, ""]
    amplitude: Float[Array, ""]
    rate: Float[Array, ""]

    def __call__(self, time):
        return self.mean + self.amplitude * jnp.sin(self.rate * time)


def _swinging(mean, amplitude, rate):
    return Swinging(array(mean), array(amplitude), array(rate))


@pytest.fixture(scope="module")
def accelerating():
    """Two stages with all losses, speed and load both swinging."""
    two = mechanism(
        stage(friction=FIRST_STAGE_LOSSES), stage(friction=ALL_LOSSES, geometry=thread(5e-3))
    )
    scenario = prsm.Scenario(
        _swinging(100.0, 20.0, 2e3), _swinging(7e3, 1e3, 3e3), 4e-3, samples=101
    )
    # Explicit only because it compiles faster; the balances hold at any carrier speed.
    return simulate(two, scenario, method="explicit")


def test_power_balance_with_kinetic_energy(accelerating):
    """Drive = load + every named loss + rate of kinetic energy, at every sample, to rounding."""
    assert int(accelerating.solver.code) == 0
    assert np.max(accelerating.power_balance_residual) < 1e-12
    assert set(accelerating.losses) == LOSS_NAMES
    assert all(np.all(np.asarray(power) >= 0) for power in accelerating.losses.values())


def test_newton_agrees_with_lagrange_while_accelerating(accelerating):
    assert np.max(accelerating.newton_residual) < 1e-13


def test_kinetic_energy_matters_here(accelerating):
    """The balance above would not close without it: it is a visible share of the drive's power."""
    drive = accelerating.drive_torque * accelerating.screw_speed
    lost = sum(accelerating.losses.values())
    useful = _swinging(7e3, 1e3, 3e3)(accelerating.time) * accelerating.screw_speed * 20e-3
    rest = np.asarray(drive - lost - useful / (2 * np.pi))
    assert np.max(np.abs(rest)) > 0.01 * np.max(np.abs(drive))


@pytest.mark.parametrize("method", ["implicit", "explicit", "rosenbrock"])
def test_ends_in_the_steady_state(method):
    """After many time constants, the same numbers as the algebra; both methods."""
    one = mechanism(stage(friction=FIRST_STAGE_LOSSES))
    scenario = prsm.Scenario(array(100.0), array(7e3), array(3e-3), samples=51)
    run, steady = simulate(one, scenario, method=method), steady_state(one)
    assert int(run.solver.code) == 0
    # The solver's tolerance, 1e-8, which the stiff end of the way damps.
    for name in ("efficiency", "drive_torque"):
        expected = float(getattr(steady, name))
        assert getattr(run, name)[-1] == pytest.approx(expected, rel=1e-7)
    for name in ("carrier_ratio", "contact_force", "ring_gear_force", "carrier_force"):
        np.testing.assert_allclose(getattr(run, name)[:, -1], getattr(steady, name), rtol=1e-5)
    for name, power in steady.losses.items():
        assert run.losses[name][-1] == pytest.approx(float(power), rel=1e-6)


def test_starting_at_the_steady_ratio_nothing_happens():
    one = mechanism(stage(friction=FIRST_STAGE_LOSSES))
    ratio = steady_state(one).carrier_ratio[0]
    scenario = prsm.Scenario(array(100.0), array(7e3), array(3e-3), ratio, samples=51)
    run = simulate(one, scenario, method="implicit")
    np.testing.assert_allclose(run.carrier_ratio[0], ratio, rtol=1e-11)


def test_running_out_of_steps_is_reported():
    one = mechanism(stage(friction=Friction(thread=CoulombFriction(0.05))))
    scenario = prsm.Scenario(array(100.0), array(7e3), array(1e-3), samples=11)
    with pytest.raises(prsm.PrsmError, match=r"out of steps.*raise max_steps"):
        prsm.simulate(one, scenario, method="explicit", max_steps=3)


@pytest.mark.parametrize(
    ("place", "start"),
    [
        (lambda m: m.operating_point.duration, "operating_point.duration is missing: give it, or"),
        (lambda m: m.operating_point, "neither scenario nor operating point is given"),
    ],
)
def test_without_a_scenario_the_error_names_what_is_missing(place, start):
    incomplete = eqx.tree_at(place, prsm.load("actuator"), None)
    with pytest.raises(prsm.MissingDataError) as refused:
        prsm.simulate(incomplete)
    words = str(refused.value)
    assert words.startswith(start)
    assert ("load" in words) == ("neither" in start)
    assert "[scenario] (in Python, a Scenario as an argument)" in words
