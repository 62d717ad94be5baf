"""Energies in both directions, and what is said of an error, against integrals and integration."""

import dataclasses
from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import FIRST_STAGE_LOSSES, array, mechanism, simulate, stage

import prsm_jax as prsm
from prsm_jax.dynamics import default_scenario
from prsm_jax.friction import Friction, ViscousFriction
from tests.present import present

ONE = mechanism(stage(friction=FIRST_STAGE_LOSSES))


def _made(run, **changes):
    """A run with other histories, and another estimate at its samples."""
    estimate = changes.pop("estimate", None)
    if estimate is not None:
        report = dataclasses.replace(
            run.solver, error_over_time=estimate, error_estimate=jnp.max(estimate)
        )
        changes["solver"] = report
    return dataclasses.replace(run, **changes)


@pytest.fixture(scope="module")
def steady():
    scenario = prsm.Scenario(array(100.0), array(7e3), array(2.0), samples=401)
    return simulate(ONE, scenario, method="quasi_steady")


def test_energies_of_each_direction(steady):
    """8 N·m at 100 rad/s (sin πt + 1/2), negative for 2/3 of 2 s; the load is a cosine."""
    wave = jnp.pi * steady.time
    run = _made(
        steady,
        screw_speed=100.0 * jnp.sin(wave) + 50.0,
        drive_torque=8.0 + 0 * wave,
        load_power=300.0 * jnp.cos(wave) + 100.0,
    )
    found = {
        name: float(prsm.dynamics.energy(run, name))
        for name in ("from_drive", "to_drive", "to_load", "from_load", "drive", "load")
    }
    # 100 + 300 cos x vanishes at x = arccos(−1/3) = a and 2π − a.
    a = np.arccos(-1 / 3)
    to_load = 2 * (100 * a + 300 * np.sin(a)) / np.pi
    # −∫ (800 sin x + 400) dx/π from 7π/6 to 11π/6.
    to_drive = (800 * np.sqrt(3) - 800 * np.pi / 3) / np.pi
    expected = {
        "from_drive": to_drive + 800.0,
        "to_drive": to_drive,
        "to_load": to_load,
        "from_load": to_load - 200.0,
        "drive": 800.0,
        "load": 200.0,
    }
    # Simpson's rule over the kinks, which do not lie at samples.
    assert found == pytest.approx(expected, rel=3e-5, abs=1e-9)
    assert found["from_drive"] - found["to_drive"] == pytest.approx(found["drive"], abs=1e-10)
    assert found["to_load"] - found["from_load"] == pytest.approx(found["load"], rel=1e-13)
    efficiency = (found["to_load"] + found["to_drive"]) / (found["from_drive"] + found["from_load"])
    assert float(prsm.dynamics.mean_efficiency(run)) == pytest.approx(efficiency, rel=1e-14)
    with pytest.raises(prsm.UnknownNameError, match="from_drive"):
        prsm.dynamics.energy(run, "form_drive")


def test_energies_over_too_few_samples_are_named(steady):
    """Pulses of power that begin and end between samples; a sine with 40 samples in a period."""
    time = steady.time
    smooth = _made(
        steady,
        drive_torque=8.0 + 0 * time,
        screw_speed=100.0 * jnp.sin(10 * jnp.pi * time),
        load_power=500.0 * jnp.sin(10 * jnp.pi * time),
    )
    assert prsm.dynamics.coarse_samples(smooth) == ()
    step = jnp.where(jnp.arange(401) % 16 < 5, 100.0, 0.0)
    (sentence,) = prsm.dynamics.coarse_samples(_made(smooth, screw_speed=step, load_power=0 * time))
    # Weights of Simpson's rule at the five samples of a pulse, and at every second one.
    fine, coarse = 2 + 4 + 2 + 4 + 2, 2 * (2 + 4 + 2)
    assert "over 401 samples" in sentence
    share = 100 * abs(coarse / fine - 1)
    printed = float(sentence.split("differs by ")[1].split(" %")[0])
    assert printed == pytest.approx(share, rel=0.05)
    # One sample that is higher by 100 or 10 %: a weight of 4/3 among 400 intervals, 0.33 or 0.03 %.
    for size, stated in ((100.0, True), (10.0, False)):
        one = jnp.where(jnp.arange(401) == 9, 100.0 + size, 100.0)
        run = _made(smooth, screw_speed=one, load_power=0 * time)
        assert bool(prsm.dynamics.coarse_samples(run)) == stated


def test_words_of_a_small_error_and_of_none(steady):
    """Constant speed: no term is neglected after settling, and nothing is assumed."""
    assert prsm.dynamics.error_in_words(steady) is None
    assert prsm.dynamics.neglected_inertia(steady, ONE) == ()
    small = _made(steady, estimate=jnp.zeros(401).at[7].set(2e-3))
    assert prsm.dynamics.error_in_words(small, "nut") == (
        "carrier speed uncertain by up to 0.20 % of the highest nut speed at t = 35.0 ms"
    )
    assert prsm.dynamics.neglected_inertia(small, ONE) == ()
    exact = dataclasses.replace(steady.solver, error_estimate=None, error_over_time=None)
    exact = dataclasses.replace(steady, solver=exact)
    assert prsm.dynamics.error_in_words(exact) is None
    failed = dataclasses.replace(small.solver, code=jnp.asarray(4))
    failed = dataclasses.replace(small, solver=failed)
    assert prsm.dynamics.error_in_words(failed) is None
    assert prsm.dynamics.neglected_inertia(failed, ONE) == ()


def test_words_of_a_reversal(steady):
    """7 kN (1 − t/0.7 s): it reverses at 0.7 s, where the estimate is made 0.3."""
    time = steady.time
    load = 7e3 * (1 - time / 0.7)
    run = _made(
        steady,
        load=load,
        drive_torque=12.0 * load / 7e3,
        load_power=1e3 * load / 7e3,
        estimate=jnp.zeros(401).at[140].set(0.3),
    )
    (sentence,) = prsm.dynamics.neglected_inertia(run, ONE)
    assert "by up to 30 % of the highest screw speed at t = 0.700 s" in sentence
    assert "the load reverses while the screw turns: once, at about t = 0.700" in sentence
    assert "exceeds 1 % at 1 of 401 samples" in sentence
    assert "so peak torque and energies are hardly affected" in sentence
    assert "standstill" not in sentence
    # Where all of the torque is uncertain, this is said.
    (everywhere,) = prsm.dynamics.neglected_inertia(_made(run, estimate=jnp.full(401, 0.02)), ONE)
    assert "at 401 of 401 samples" in everywhere
    assert "at most 100 % of its peak and 100 % of the energy passes" in everywhere
    assert "so torque and energies are uncertain, too" in everywhere
    # No sample is near the reversal: none has a large estimate, but it is there.
    (between,) = prsm.dynamics.neglected_inertia(_made(run, estimate=jnp.full(401, 1e-4)), ONE)
    assert "once, at about t = 0.700" in between
    assert "The samples beside it do not show the error there." in between
    # Load and screw reverse together: the carriers stand still, too.
    both = (0.7025 - time) / 0.7025
    together = _made(run, estimate=0 * time, load=7e3 * both, screw_speed=100.0 * both)
    assert prsm.dynamics.neglected_inertia(together, ONE) == ()
    # The screw stands still while the load reverses, and goes on.
    pause = jnp.where(abs(time - 0.7) < 0.1, 0.0, 100.0)
    paused = _made(run, estimate=jnp.full(401, 1e-4), screw_speed=pause)
    assert prsm.dynamics.neglected_inertia(paused, ONE) == ()
    # Viscous threads drive the carriers at any load.
    viscous = mechanism(stage(friction=Friction(thread=ViscousFriction(array(10.0)))))
    even = _made(run, estimate=jnp.full(401, 1e-4))
    assert prsm.dynamics.neglected_inertia(even, viscous) == ()
    # Under a prescribed torque it is the speed of the screw.
    torque = _made(run, estimate=jnp.full(401, 0.05), position=time)
    (sentence,) = prsm.dynamics.neglected_inertia(torque, ONE)
    assert "screw speed uncertain by about 5.0 % of its largest value" in sentence


class _From(eqx.Module):
    """A function of a scenario, from a later start."""

    of: Callable
    start: float

    def __call__(self, time):
        return self.of(time + self.start)


def test_error_at_a_reversal_of_the_example():
    """The shipped mission around the first reversal of its load, integrated to 1e-10.

    The estimate bounds the error of the carriers, and is seven times as large. Torque changes by
    less than 0.2 % of the peak of 24 N·m, and energies by less than 0.01 % of the 463 J from the
    drive.
    """
    start, end = 0.67, 0.73
    mission = prsm.load("actuator_mission")
    whole = default_scenario(mission)
    assert isinstance(whole, prsm.Scenario)
    bound = prsm.dynamics.bound_scenario(mission, whole)
    scenario = prsm.Scenario(
        _From(bound.speed_at, start),
        _From(bound.load_at, start),
        array(end - start),
        array(0.3741),
        samples=401,
    )
    found = prsm.simulate(mission, scenario, method="quasi_steady")
    exact = prsm.simulate(mission, scenario, rtol=1e-10, atol=1e-12, method="rosenbrock")
    fastest = np.abs(np.asarray(found.screw_speed)).max()
    # Past the settling from the initial ratio.
    apart = np.abs(np.asarray(found.carrier_speed - exact.carrier_speed))[0, 20:]
    # Both in shares of the 1500 rpm of the mission.
    largest = apart.max() / (2 * np.pi * 25)
    assert largest == pytest.approx(0.095, rel=0.02)
    estimate = float(present(found.solver.error_estimate)) * fastest / (2 * np.pi * 25)
    assert largest < estimate
    torque = np.asarray(found.drive_torque - exact.drive_torque)[20:]
    assert np.abs(torque).max() < 2e-3 * 24
    for of in ("from_drive", "to_drive", "loss"):
        ours, true = (float(prsm.dynamics.energy(run, of)) for run in (found, exact))
        assert abs(ours - true) < 1e-4 * 463
    (sentence,) = prsm.dynamics.neglected_inertia(found, mission)
    assert "reverses while the screw turns: once" in sentence


def test_a_run_that_fails_keeps_the_efficiency_before(steady):
    """NaN at the end hides no sample before; what is near standstill or beyond 1 has none."""
    late = jnp.arange(401) > 300
    run = _made(
        steady,
        drive_torque=jnp.where(late, jnp.nan, 8.0),
        screw_speed=jnp.where(jnp.arange(401) < 10, 0.1, 100.0),
        efficiency=jnp.where(jnp.arange(401) == 50, 1.2, jnp.where(late, jnp.nan, 0.8)),
        load_power=jnp.where(late, jnp.nan, 640.0 * (jnp.arange(401) >= 10).astype(float)),
    )
    known = prsm.dynamics.known_efficiency(run)
    gaps = np.isnan(known)
    assert np.flatnonzero(gaps).tolist() == [*range(10), 50, *range(301, 401)]
    assert np.all(known[~gaps] == 0.8)
