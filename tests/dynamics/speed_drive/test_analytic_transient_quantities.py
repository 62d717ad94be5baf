"""Peaks, settling times and energies: exact functions of time first, then a transient."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, changed, mechanism, stage

import prsm_jax as prsm
from prsm_jax.friction import CoulombFriction, Friction
from tests.present import present


def test_peak_of_a_parabola_is_exact_wherever_the_samples_fall():
    time = np.linspace(0, 1, 12)
    # In the second and in the last but one of the samples as well.
    for place in (0.2, 0.4321, 0.5, 0.1, 0.9):
        history = jnp.asarray(3.0 - 7 * (time - place) ** 2)
        assert float(prsm.dynamics.peak(history)) == pytest.approx(3.0, rel=1e-13)
        # The slope of the peak by a uniform rise is 1, spread over three samples.
        assert float(jnp.sum(jax.grad(prsm.dynamics.peak)(history))) == pytest.approx(
            1.0, rel=1e-12
        )
    assert float(prsm.dynamics.peak(jnp.asarray([3.0, 2.0, 1.0]))) == 3.0
    assert float(prsm.dynamics.peak(jnp.asarray([1.0, 2.0, 3.0]))) == 3.0
    two = prsm.dynamics.peak(jnp.asarray([[0.0, 1.0, 0.0], [5.0, 4.0, 1.0]]))
    np.testing.assert_allclose(two, [1.0, 5.0])


def test_peak_converges_with_the_samples():
    """Third order or better, against the first sample's second."""
    place, errors = np.arctan(2.9) / 2.9, []
    expected = np.sin(2.9 * place) * np.exp(-place)
    for count in (41, 81, 161):
        # Wherever the peak lies between two samples.
        shift = np.linspace(0, 1 / (count - 1), 9)[:, None]
        time = np.linspace(0, 1, count) + shift
        found = prsm.dynamics.peak(jnp.asarray(np.sin(2.9 * time) * np.exp(-time)))
        errors.append(np.max(np.abs(np.asarray(found) - expected)))
    assert errors[0] < 1e-4
    assert errors[2] < errors[0] / 4**2.5


def test_settling_time_of_an_exponential_is_exact():
    """x = 1 − e^{−t/τ}: t = τ ln(1/band), and its derivative by τ is ln(1/band)."""
    time = jnp.linspace(0.0, 1.0, 21)

    def settle(constant):
        history = 1 - jnp.exp(-time / constant)
        return prsm.dynamics.settling_time(time, history, 0.02, jnp.ones(()))

    found, settles = settle(array(0.1))
    assert bool(settles)
    assert float(found) == pytest.approx(0.1 * np.log(50), rel=1e-13)
    for transform in (jax.jacfwd, jax.jacrev):
        slope = transform(lambda c: settle(c)[0])(array(0.1))
        assert float(slope) == pytest.approx(np.log(50), rel=1e-12)


def test_settling_time_where_nothing_crosses():
    time = jnp.linspace(0.0, 1.0, 5)
    at_once, settles = prsm.dynamics.settling_time(time, jnp.ones(5))
    assert float(at_once) == 0.0
    assert not bool(settles)
    never, settles = prsm.dynamics.settling_time(time, time, 0.02, array(2.0))
    assert float(never) == 1.0
    assert not bool(settles)
    step, settles = prsm.dynamics.settling_time(time, jnp.asarray([0.0, 0.0, 1.0, 1.0, 1.0]), 0.1)
    # A straight line from 0 to 1 between 0.25 and 0.5.
    assert float(step) == pytest.approx(0.25 + 0.9 * 0.25)
    assert bool(settles)
    slopes = jax.grad(lambda h: prsm.dynamics.settling_time(time, h)[0])(jnp.ones(5))
    assert np.all(np.isfinite(slopes))


@pytest.mark.parametrize("count", [4, 5, 8, 9])
def test_integral_is_exact_for_cubics(count):
    time = jnp.linspace(0.0, 2.0, count)
    found = prsm.dynamics.integral(time, jnp.stack([time**3 - time, jnp.ones_like(time)]))
    np.testing.assert_allclose(found, [2.0, 2.0], rtol=1e-13)


NAMES = (
    "lead",
    "contact_angle",
    "roller_radius",
    "friction.thread.coefficient",
    "carrier.inertia",
    "roller.inertia",
)
ONE = mechanism(stage(friction=Friction(thread=CoulombFriction(0.1))))


class Stroke(eqx.Module):
    """Ω sin πt/T: out of rest and back to it."""

    speed: jax.Array
    duration: jax.Array

    def __call__(self, time):
        return self.speed * jnp.sin(jnp.pi * time / self.duration)


def _run(changes, speed, duration, method, gradient):
    moved = changed(ONE, NAMES, changes)
    scenario = prsm.Scenario(speed, array(5e3), duration, samples=65)
    return prsm.simulate(
        moved,
        scenario,
        method=method,
        gradient=gradient,
        rtol=1e-10,
        atol=1e-12,
        max_steps=1024,
        throw=False,
    )


def _numbers(changes):
    """Of a run-up of the carriers at constant speed."""
    run = _run(changes, array(100.0), array(0.4e-3), "rosenbrock", "both")
    return _judged(run)


def _judged(run):
    settled, _ = prsm.dynamics.settling_time(run.time, run.carrier_ratio[0], 0.05)
    return jnp.stack(
        [
            prsm.dynamics.mean_efficiency(run),
            prsm.dynamics.peak(run.ring_gear_force[0]) / 100,
            prsm.dynamics.peak(run.contact_force[0]) / 1000,
            settled * 1e4,
            prsm.dynamics.energy(run) * 10,
            prsm.dynamics.energy(run, "loss") * 10,
            prsm.dynamics.energy(run, "thread_sliding") * 10,
        ]
    )


def test_energies_of_a_transient_balance():
    """Drive, load, losses and kinetic energy, to the order of the quadrature."""
    run = eqx.filter_jit(_run)(jnp.zeros(6), array(100.0), array(0.4e-3), "rosenbrock", "both")
    drive, load, loss = (
        float(prsm.dynamics.energy(run, name)) for name in ("drive", "load", "loss")
    )
    kinetic = float(
        prsm.dynamics.integral(
            run.time, run.drive_torque * run.screw_speed - present(run.load_power)
        )
        - loss
    )
    assert 0 < kinetic < 0.5 * drive
    assert drive - load - loss == pytest.approx(kinetic, rel=1e-12)
    assert loss == pytest.approx(float(prsm.dynamics.energy(run, "thread_sliding")), rel=1e-15)
    assert float(prsm.dynamics.mean_efficiency(run)) == pytest.approx(load / drive, rel=1e-14)
    inertia = prsm.dynamics.carrier_inertia(ONE.stages[0])
    speed = float(run.carrier_speed[0, -1])
    assert kinetic == pytest.approx(0.5 * float(inertia) * speed**2, rel=1e-4)
    with pytest.raises(prsm.UnknownNameError, match="did you mean"):
        prsm.dynamics.energy(run, "thread_slidin")


def test_derivatives_of_what_designs_are_judged_by():
    """Forward and reverse against central differences, by geometry, friction and inertias."""
    slope = jax.jit(lambda at, direction: jax.jvp(_numbers, (at,), (direction,)))
    weights = jnp.asarray([1.0, -0.5, 0.7, 0.3, -0.2, 0.4, 0.6])
    nothing, step = jnp.zeros(6), 1e-3

    def weighted(changes):
        run = _run(changes, array(100.0), array(0.4e-3), "rosenbrock", "reverse")
        return weights @ _judged(run)

    gradient = jax.jit(jax.grad(weighted))(nothing)
    columns = []
    for direction in jnp.eye(6):
        _, forward = slope(nothing, direction)
        ahead, behind = (slope(s * step * direction, direction)[0] for s in (1, -1))
        # Central differences of a relative step 1e-3: a third derivative of order 10 gives 1e-5.
        np.testing.assert_allclose(forward, (ahead - behind) / (2 * step), rtol=1e-4, atol=2e-5)
        assert float(gradient @ direction) == pytest.approx(float(weights @ forward), rel=1e-6)
        columns.append(np.asarray(forward))
    matrix = np.array(columns).T
    # Every number depends on something, and every parameter matters.
    assert np.all(np.max(np.abs(matrix), axis=0) > 1e-3)
    assert np.all(np.max(np.abs(matrix), axis=1) > 1e-3)
