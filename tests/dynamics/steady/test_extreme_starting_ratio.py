"""Carriers of a screw that turns already when its torque is prescribed: where they start.

Of a screw that is braked there is always a balance with carriers that turn against it, and they
leave it at once. They start in a balance that attracts or, where there is none, in that of rolling.
"""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, mechanism, stage, thread
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import prsm_jax as prsm
from benchmarks.references.transients.torque_runs import TorqueChain
from prsm_jax.dynamics.torque_drive._driven_carriers import Carriers, leaving, slip_geometry
from prsm_jax.dynamics.torque_drive._torque_balance import torque_problem
from prsm_jax.friction import CoulombFriction, Friction, ThrustBearingFriction


def chain(friction, bearing, *rollers):
    """Stages with flanks at 30°, and rollers that many times as heavy."""
    law = Friction(CoulombFriction(friction), thrust_bearing=ThrustBearingFriction(bearing, 20e-3))
    found = mechanism(
        *(stage(friction=law, geometry=thread(contact_angle=np.pi / 3)) for _ in rollers)
    )
    for number, factor in enumerate(rollers, start=1):
        for name in ("mass", "inertia"):
            path = f"stage.{number}.roller.{name}"
            found = prsm.set_parameter(found, path, factor * prsm.get_parameter(found, path))
    return found


@eqx.filter_jit
def started(scene, torque, load, speed):
    """Ratios, and whether they are those of a balance."""
    scenario = prsm.TorqueScenario(torque, load, array(0.1), initial_speed=speed)
    problem = torque_problem(scene, scenario)
    none = jnp.zeros(len(scene.stages))
    rests = Carriers(none > 0, none, none)
    zero = array(0.0)
    tangents, found = leaving(problem, zero, zero, speed, jnp.sign(speed), rests)
    return slip_geometry(problem).ratio(tangents), found


def rates(scene, torque, load, speed):
    """Rates of the ratios in NumPy [1/s], and the ratios of rolling."""
    reference = TorqueChain(scene, lambda _: torque, lambda *_: load)

    def rate(ratios):
        turning, carriers = reference.acceleration(
            0.0, 0.0, speed, ratios * speed, int(np.sign(speed))
        )
        return (carriers - ratios * turning) / speed

    free = [np.dot(s.screw, s.drive) / np.dot(s.drive, s.drive) for s in reference.stages]
    return rate, np.array(free)


def settled(scene, torque, load, speed):
    """Where carriers that roll at first settle at that speed, or `None`."""
    rate, free = rates(scene, torque, load, speed)
    end = 1e3 / np.max(np.abs(rate(free)))

    def escapes(_, ratios):
        return 3.0 - np.max(np.abs(ratios))

    escapes.terminal = True
    run = solve_ivp(
        lambda _, ratios: rate(ratios), (0.0, end), free, "LSODA", rtol=1e-8, events=escapes
    )
    return None if run.status == 1 else fsolve(rate, run.y[:, -1], xtol=1e-13)


@pytest.mark.parametrize(
    ("friction", "bearing", "rollers", "load", "speed", "torque", "settles"),
    [
        (0.05, 0.1, 1.0, 100.0, 200.0, 0.0, True),
        (0.05, 0.6, 2.0, 100.0, 200.0, 0.0, False),
        (0.18, 0.38, 6.9, 717.0, -200.0, 0.0, False),
        (0.05, 0.0, 0.3, 1.7, 200.0, -0.02, False),
        (0.005, 0.0, 3.3, 51.0, 200.0, 0.044, False),
        (0.7, 0.3, 1.0, 300.0, 200.0, 0.0, True),
        (0.3, 0.0, 1.0, 300.0, -200.0, 0.5, True),
        (0.01, 0.1, 4.0, 300.0, 200.0, 30.0, True),
    ],
)
def test_one_stage_starts_where_it_settles(
    friction, bearing, rollers, load, speed, torque, settles
):
    scene = chain(friction, bearing, rollers)
    given = torque, load, speed
    ratio, found = started(scene, *(array(x) for x in given))
    expected: Any = settled(scene, *given)
    assert bool(found) == settles == (expected is not None)
    if expected is not None:
        np.testing.assert_allclose(ratio, expected, rtol=1e-7)


def test_two_stages_that_are_braked_too_hard_have_only_a_balance_that_repels():
    """Carriers that roll at first run away from it, and the screw starts beneath them."""
    scene = chain(0.05, 0.6, 2.0, 4.0)
    given = 0.0, 100.0, 200.0
    rate, free = rates(scene, *given)
    balance: Any = fsolve(rate, free, xtol=1e-13)
    np.testing.assert_allclose(balance, [-0.0576, -0.0474], atol=1e-4)
    np.testing.assert_allclose(rate(balance), 0.0, atol=1e-9)
    steps = 1e-6 * np.eye(2)
    slopes = [(rate(balance + step) - rate(balance - step)) / 2e-6 for step in steps]
    assert np.all(np.linalg.eigvals(np.array(slopes)).real > 1.0)
    _, found = started(scene, *(array(x) for x in given))
    assert not bool(found)
