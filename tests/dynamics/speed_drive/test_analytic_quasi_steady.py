"""Carriers in balance at every instant, against the integrated ones; laws of friction."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import (
    FIRST_STAGE_LOSSES,
    Swing,
    array,
    example,
    mechanism,
    simulate,
    stage,
    steady_state,
)

import prsm_jax as prsm
from prsm_jax.friction import (
    CoulombFriction,
    Friction,
    RegularisedCoulombFriction,
    StribeckFriction,
    ViscousFriction,
)
from prsm_jax.numerics import _stretches
from prsm_jax.numerics._stretches import over_samples
from tests.present import present


def _swing(mean, amplitude, samples=81):
    speed = Swing(array(mean), array(amplitude), array(5.0))
    return prsm.Scenario(speed, array(7e3), array(0.2), array(0.3737), samples=samples)


def _error(mechanism, scenario, of):
    """Largest difference from integrated carriers of a result, past the settling, and the runs."""
    found = simulate(mechanism, scenario, method="quasi_steady")
    exact = simulate(
        mechanism, scenario, method="rosenbrock", rtol=1e-10, atol=1e-12, max_steps=16384
    )
    assert int(found.solver.code) == int(exact.solver.code) == 0
    return np.max(np.abs(np.asarray(of(found) - of(exact)))[:, 5:]), found, exact


def test_error_is_below_the_estimate():
    """A speed that swings without standing still, where the integrated carriers are exact.

    The estimate, 1.1e-8 of the highest speed, is the last step, of second order. What is left is of
    third order; the integrated carriers have an error of 5e-11.
    """
    two, scenario = example("li2020_two_stage"), _swing(200.0, 100.0)
    error, found, exact = _error(two, scenario, lambda run: run.carrier_ratio)
    estimate = float(present(found.solver.error_estimate))
    assert 5e-9 < estimate < 2e-8
    assert error < 3e-10
    assert error < estimate / 30
    torque = np.asarray(exact.drive_torque)
    np.testing.assert_allclose(found.drive_torque[5:], torque[5:], atol=1e-9 * torque.max())


def test_smooth_friction_through_standstill():
    """Regularised friction: carriers lag behind the screw at standstill too, by its rate times I/k.

    The balance of carrier ratios does not know this lag. The step to the equation of motion does,
    and the estimate says how large it is.
    """
    smooth = RegularisedCoulombFriction(array(0.05), array(1e-3))
    one = mechanism(stage(friction=Friction(smooth)))
    scenario = _swing(0.0, 100.0)
    error, found, exact = _error(one, scenario, lambda run: run.carrier_speed / 100.0)
    estimate = float(present(found.solver.error_estimate))
    assert error < estimate < 1e-5
    standing = np.argmin(np.abs(np.asarray(exact.screw_speed))[5:-5]) + 5
    lag = np.asarray(exact.carrier_speed)[0, standing]
    assert abs(lag) > 1e-7 * 100.0
    # One step overshoots: friction changes within the lag. The balance alone has no lag at all.
    np.testing.assert_allclose(found.carrier_speed[0, standing], lag, rtol=0.4)
    assert prsm.dynamics.choose_method(one, scenario).method == "rosenbrock"


def test_through_reversals():
    """Exact Coulomb friction through standstill: balances close, and nothing is lost there."""
    two = example("li2020_two_stage")
    # One period: its start, middle and end are standstills.
    run = simulate(two, _swing(0.0, 100.0), method="quasi_steady")
    assert int(run.solver.code) == 0
    standing = np.abs(np.asarray(run.screw_speed)) < 1e-10
    assert standing.sum() == 3
    for name in ("drive_torque", "carrier_force", "contact_force", "ring_gear_force"):
        assert np.all(np.isfinite(getattr(run, name)))
    assert np.max(np.abs(np.asarray(run.power_balance_residual)[~standing])) < 1e-12
    assert np.max(run.newton_residual) < 1e-12
    forward = np.asarray(run.screw_speed) > 1e-10
    assert np.all(np.asarray(run.drive_torque)[forward] > 0)


def test_a_long_scene_is_computed_in_stretches(monkeypatch):
    """A scene longer than one stretch, here three of 54, has the numbers of one that is not."""
    two = example("li2020_two_stage")
    whole = simulate(two, _swing(200.0, 100.0), method="quasi_steady")
    # A number of samples that no other test has: a program of one stretch would be taken again.
    monkeypatch.setattr(_stretches, "LONGEST", 60)
    found = simulate(two, _swing(200.0, 100.0, samples=161), method="quasi_steady")
    assert int(found.solver.code) == 0
    for name in ("time", "drive_torque", "efficiency", "carrier_ratio", "contact_force"):
        ours, plain = np.asarray(getattr(found, name))[..., ::2], getattr(whole, name)
        # Rounding: samples at the same times to the last bit but one.
        np.testing.assert_allclose(ours, plain, rtol=1e-12, atol=0)
    lines = str(jax.make_jaxpr(lambda: over_samples(jnp.sin, found.time))())
    assert "length=3" in lines


def test_constant_speed_is_the_steady_state():
    one = mechanism(stage(friction=FIRST_STAGE_LOSSES))
    scenario = prsm.Scenario(array(100.0), array(7e3), array(1.0), samples=3)
    run, steady = simulate(one, scenario, method="quasi_steady"), steady_state(one)
    np.testing.assert_allclose(run.efficiency, float(steady.efficiency), rtol=1e-13)
    np.testing.assert_allclose(run.drive_torque, float(steady.drive_torque), rtol=1e-13)
    assert float(present(run.solver.error_estimate)) == 0.0
    assert 1e-6 < float(present(run.solver.time_constant)) < 1e-2


def _steady(law, speed=100.0):
    return steady_state(mechanism(stage(friction=Friction(thread=law))), speed)


def test_regularised_coulomb_tends_to_coulomb():
    """√(1 + (ε/v)²) − 1 = ε²/2v² of the friction is missing; 1e-12 is rounding."""
    exact = _steady(CoulombFriction(0.1))
    slip = float(exact.slip_speed[0])
    for width in (1e-1, 1e-2, 1e-3):
        found = _steady(RegularisedCoulombFriction(0.1, width * slip))
        coefficient = 0.1 / np.sqrt(1 + width**2)
        expected = _steady(CoulombFriction(coefficient))
        assert float(found.efficiency) == pytest.approx(float(expected.efficiency), rel=1e-12)
    creeping = _steady(RegularisedCoulombFriction(0.1, 1e3 * slip))
    assert float(creeping.efficiency) > float(exact.efficiency)


@pytest.mark.parametrize("speed", [1e-6, 1.0, 1e4])
def test_stribeck_is_coulomb_with_the_coefficient_of_its_slip(speed):
    """Static at creep, sliding when fast, and in between the exponential."""
    law = StribeckFriction(0.15, 0.05, 0.1)
    found = _steady(law, speed)
    slip = float(found.slip_speed[0])
    coefficient = 0.05 + 0.10 * np.exp(-((slip / 0.1) ** 2))
    expected = _steady(CoulombFriction(coefficient), speed)
    assert float(found.efficiency) == pytest.approx(float(expected.efficiency), rel=1e-12)
    assert float(found.power_balance_residual) < 1e-12


def test_stribeck_with_a_viscous_part():
    """With equal coefficients it is Coulomb's plus a viscous law: losses add up, by power."""
    both = _steady(StribeckFriction(0.05, 0.05, 0.1, 25.0))
    assert float(both.power_balance_residual) < 1e-12
    alone = _steady(CoulombFriction(0.05)), _steady(ViscousFriction(25.0))
    lost = float(both.losses["thread_sliding"])
    assert lost > float(alone[0].losses["thread_sliding"])
    assert lost > float(alone[1].losses["thread_sliding"])


def test_contact_losses_and_derivatives_under_another_law():
    """Resisting moments shift the carriers under any law; both derivative modes agree."""
    law = StribeckFriction(0.15, 0.05, 0.1, 5.0)
    friction = dataclasses.replace(FIRST_STAGE_LOSSES, thread=law)
    one = mechanism(stage(friction=friction))

    @jax.jit
    def everything(lead):
        def evaluate(value):
            state = prsm.steady_state(prsm.set_parameter(one, "lead", value), array(100.0), 7e3)
            return state.efficiency

        step = 1e-4 * lead
        difference = (evaluate(lead + step) - evaluate(lead - step)) / (2 * step)
        state = prsm.steady_state(one, array(100.0), array(7e3))
        return (
            difference,
            jax.jvp(evaluate, (lead,), (jnp.ones_like(lead),))[1],
            jax.grad(evaluate)(lead),
            state.power_balance_residual,
            state.valid,
        )

    difference, forward, reverse, residual, valid = everything(array(10e-3))
    assert bool(valid)
    assert float(residual) < 1e-12
    assert float(forward) == pytest.approx(float(difference), rel=1e-6)
    assert float(reverse) == pytest.approx(float(forward), rel=1e-10)
