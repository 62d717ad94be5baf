"""Prescribed torque with carriers as states, in ellipses that spin: against SciPy.

The reference (`benchmarks.references.transients.torque_spin`) puts slip and spin, integrated over
the ellipse itself, into the equations of `torque_runs` beside it; only Hertz's ellipse is the
package's.
"""

import functools

import equinox as eqx
import numpy as np
import pytest
from scenes import Swing, array, mechanism, stage, thread

import prsm_jax as prsm
from benchmarks.references.transients.torque_spin import SpinningChain
from prsm_jax.friction import CoulombFriction, Friction, SpinFriction

LOAD, DURATION, SAMPLES = 300.0, 0.5, 41
SLIDING, SPINNING = 0.7, 0.05


def one(spins=True, sliding=SLIDING, rollers=1.0):
    """Flanks at 30°, self-locking; few threads, so that ellipses are large."""
    friction = Friction(CoulombFriction(array(sliding)))
    if spins:
        friction = Friction(CoulombFriction(array(sliding)), SpinFriction(array(SPINNING)))
    geometry = thread(contact_angle=np.pi / 3)
    found = mechanism(stage(friction=friction, geometry=geometry, engaged_threads=2.0))
    for name in ("roller.mass", "roller.inertia"):
        found = prsm.set_parameter(found, name, rollers * prsm.get_parameter(found, name))
    return found


def scenario(amplitude=3.0, frequency=2.0, duration=DURATION, samples=SAMPLES):
    swing = Swing(array(0.0), array(amplitude), array(frequency))
    load = prsm.scenario.HingeLoad(array(LOAD))
    return prsm.TorqueScenario(swing, load, array(duration), samples=samples, most_phases=10)


@eqx.filter_jit
def run(chain, scene):
    return prsm.simulate(chain, scene, method="rosenbrock", gradient="forward", throw=False)


@functools.cache
def _found():
    return run(one(), scenario())


@pytest.mark.usefixtures("memory_for_large_programs")
def test_against_scipy():
    """Sticks, breaks away, reverses and sticks; screw, carrier and the times of the events."""
    found = _found()
    assert int(found.solver.code) == 0
    peak = float(np.max(np.abs(found.screw_speed)))
    reference = SpinningChain(one(), lambda t: 3.0 * np.sin(4 * np.pi * t), lambda *_: LOAD)
    exact = reference.run(DURATION, SAMPLES, peak=peak, rtol=1e-9)
    assert np.any(exact.speed > 0)
    assert np.any(exact.speed < 0)
    # 1.5e-9 apart; the reference changes by 8e-11 with a tolerance of 1e-11, and by 6e-11 with
    # fewer directions and forces. Events are located to 1e-10 of the duration.
    np.testing.assert_allclose(found.screw_speed, exact.speed, atol=1e-8 * peak)
    np.testing.assert_allclose(found.carrier_speed, exact.carriers, atol=1e-8 * peak)
    for phase in range(2):
        end = float(found.phases.end[phase])
        assert end == pytest.approx(exact.phases[phase][1], abs=2e-9 * DURATION)


def test_the_reference_is_the_integral_over_the_ellipse():
    """Between the directions and forces that it was computed at, as those with fewer of them."""
    chains = [
        SpinningChain(one(), lambda *_: 0.0, lambda *_: LOAD, points)
        for points in ((8, 5), (12, 6), (16, 8))
    ]
    contacts = [chain.contacts[0] for chain in chains]
    random = np.random.default_rng(7)
    errors = np.zeros(3)
    for _ in range(6):
        turn, growth = random.uniform(-np.pi, np.pi), random.uniform(1.0, 500 ** (1 / 3))
        axial = growth**3 / 2
        for k, contact in enumerate(contacts):
            force, rub, moment = contact.friction(turn, axial)
            exact = contact.integrated(turn, np.cbrt(force), chains[k].semi_axes[0], points=800)
            pulled = contact.axes @ rub / (SLIDING * force)
            turned = moment / (SLIDING * force * contact.numbers.normal[2])
            scale = np.array([1.0, 1.0, chains[k].semi_axes[0][0]])
            apart = np.abs(np.array([*pulled, turned]) - exact) / scale
            errors[k] = max(errors[k], np.max(apart))
    # Each row of points has a hundredth of the error of the one before, and the last 1e-11.
    assert errors[0] < 1e-5
    assert errors[1] < 1e-7
    assert errors[2] < 1e-10


@pytest.mark.usefixtures("memory_for_large_programs")
def test_two_stages_of_which_one_coasts_through_a_reversal():
    """Light rollers stop with the screw; heavy ones turn on, against a screw that has reversed.

    While they do the nut side turns against the screw, and its moment with it.
    """
    chain = mechanism(*(one(sliding=0.05, rollers=rollers).stages[0] for rollers in (0.05, 2.0)))
    duration, samples = 0.14, 29
    found = run(chain, scenario(4.0, 8.0, duration, samples))
    assert int(found.solver.code) == 0
    peak = float(np.max(np.abs(found.screw_speed)))
    reference = SpinningChain(
        chain, lambda t: 4.0 * np.sin(16 * np.pi * t), lambda *_: LOAD, points=(12, 6)
    )
    exact = reference.run(duration, samples, peak=peak, rtol=1e-9)
    np.testing.assert_allclose(found.screw_speed, exact.speed, atol=1e-7 * peak)
    np.testing.assert_allclose(found.carrier_speed, exact.carriers, atol=1e-7 * peak)
    # The second carrier turns against the screw, faster and slower than its rollers would roll.
    ratio = exact.carriers[1] / np.where(exact.speed == 0, np.inf, exact.speed)
    assert np.sum(ratio < -1) > 0
    assert np.sum((ratio < -0.25) & (ratio > -1)) > 1
    assert np.sum((ratio < 0) & (ratio > -0.25)) > 1
    assert np.all(exact.carriers[0][exact.speed < 0] < 0)
    assert np.max(found.power_balance_residual) < 1e-12
    assert np.max(found.newton_residual) < 1e-12


def test_power_is_in_balance_through_a_reversal():
    found = _found()
    turning = np.asarray(found.screw_speed) != 0
    assert np.max(np.asarray(found.power_balance_residual)[turning]) < 1e-12
    assert np.max(found.newton_residual) < 1e-12
    spin = np.asarray(found.losses["spin"])
    assert np.all(spin[turning] > 0)
    assert np.all(spin[~turning] == 0)


def test_spin_holds_longer_and_slows_the_carriers():
    """The same run without spin: it breaks away earlier, and its rollers turn faster."""
    found, plain = _found(), run(one(spins=False), scenario())
    assert float(found.phases.start[1]) > float(plain.phases.start[1])
    ahead = np.asarray((found.screw_speed > 0) & (plain.screw_speed > 0))
    ratios = [
        np.asarray(r.carrier_speed[0])[ahead] / np.asarray(r.screw_speed)[ahead]
        for r in (found, plain)
    ]
    assert len(ratios[0]) > 3
    assert np.all(ratios[0] < ratios[1])
    peak = float(np.max(np.abs(plain.screw_speed)))
    apart = np.max(np.abs(found.screw_speed - plain.screw_speed)) / peak
    assert 2e-4 < apart < 0.2
