"""Friction laws of splines, thrust bearings and drag, against closed forms."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies
from scenes import mechanism, stage, steady_state, thread

from prsm_jax.dynamics.forces._chain import _coupled_frictions
from prsm_jax.friction import (
    CoulombFriction,
    Drag,
    Friction,
    RegularisedCoulombFriction,
    SplineFriction,
    StribeckFriction,
    ThrustBearingFriction,
    ViscousFriction,
)

SPEED, LOAD, RADIUS = 40.0, 5e3, 12e-3
#: Of the spline: the lead of the first stage, 10 mm, per turn.
SLIDING = SPEED * 10e-3 / (2 * np.pi)


def _steady(spline=None, bearing=None, drag=None, speed=SPEED):
    second = Friction(CoulombFriction(0.05), spline=spline, thrust_bearing=bearing, drag=drag)
    first = Friction(CoulombFriction(0.05))
    two = mechanism(
        stage(friction=first, geometry=thread(lead=10e-3)),
        stage(friction=second, geometry=thread(lead=15e-3)),
    )
    return steady_state(two, speed, LOAD)


def _coefficient(shape, sliding):
    """μ of each law at a sliding speed, for μ 0.1."""
    return {
        "coulomb": 0.1,
        "regularised": 0.1 * sliding / np.hypot(sliding, 0.03),
        "stribeck": 0.1 + 0.05 * np.exp(-((sliding / 0.05) ** 2)),
    }[shape]


@pytest.mark.parametrize(
    ("shape", "spline", "bearing"),
    [
        (
            "regularised",
            SplineFriction(RegularisedCoulombFriction(0.1, 0.03), RADIUS),
            ThrustBearingFriction(RegularisedCoulombFriction(0.1, 0.03), RADIUS),
        ),
        (
            "stribeck",
            SplineFriction(StribeckFriction(0.15, 0.1, 0.05), RADIUS),
            ThrustBearingFriction(StribeckFriction(0.15, 0.1, 0.05), RADIUS),
        ),
    ],
)
def test_a_law_is_coulombs_with_its_own_coefficient(shape, spline, bearing):
    """At a given speed, with the loop between torque and force solved."""
    found = _steady(spline, bearing)
    expected = _steady(
        SplineFriction(_coefficient(shape, SLIDING), RADIUS),
        ThrustBearingFriction(_coefficient(shape, SPEED * RADIUS), RADIUS),
    )
    assert float(found.drive_torque) == pytest.approx(float(expected.drive_torque), rel=1e-13)
    assert float(found.power_balance_residual) < 1e-13
    for name in ("spline", "thrust_bearing"):
        assert float(found.losses[name]) == pytest.approx(float(expected.losses[name]), rel=1e-12)
    plain = _steady(SplineFriction(0.1, RADIUS), ThrustBearingFriction(0.1, RADIUS))
    assert abs(float(found.drive_torque / plain.drive_torque) - 1) > 1e-4


def test_viscous_laws_do_not_know_the_load():
    found = _steady(
        SplineFriction(ViscousFriction(50.0)),
        ThrustBearingFriction(ViscousFriction(0.002)),
        Drag(0.1, 0.003),
    )
    assert float(found.spline_friction[1]) == pytest.approx(50.0 * SLIDING, rel=1e-14)
    assert float(found.losses["spline"]) == pytest.approx(50.0 * SLIDING**2, rel=1e-14)
    assert float(found.losses["thrust_bearing"]) == pytest.approx(0.002 * SPEED**2, rel=1e-14)
    drag = (0.1 + 0.003 * SPEED) * SPEED
    assert float(found.losses["drag"]) == pytest.approx(drag, rel=1e-14)
    assert float(found.power_balance_residual) < 1e-13
    back = _steady(
        SplineFriction(ViscousFriction(50.0)),
        ThrustBearingFriction(ViscousFriction(0.002)),
        Drag(0.1, 0.003),
        -SPEED,
    )
    # The same powers when the load drives, against the other direction.
    for name in ("spline", "thrust_bearing", "drag"):
        assert float(back.losses[name]) == pytest.approx(float(found.losses[name]), rel=1e-14)
    assert float(back.power_balance_residual) < 1e-13


def test_stribeck_adds_viscous_friction():
    with_film = _steady(
        SplineFriction(StribeckFriction(0.15, 0.1, 0.05, 50.0), RADIUS),
        ThrustBearingFriction(StribeckFriction(0.15, 0.1, 0.05, 0.002), RADIUS),
    )
    assert float(with_film.power_balance_residual) < 1e-13
    ratio = _coefficient("stribeck", SLIDING) / RADIUS
    friction = float(with_film.spline_friction[1])
    bearing = float(with_film.losses["thrust_bearing"]) / SPEED
    # The torque of the second screw presses on its spline: that of its threads and its bearing.
    alone = stage(friction=Friction(CoulombFriction(0.05)), geometry=thread(lead=15e-3))
    threads = float(steady_state(mechanism(alone), SPEED, LOAD).drive_torque)
    assert (friction - 50.0 * SLIDING) / ratio == pytest.approx(threads + bearing, rel=1e-12)
    own = _coefficient("stribeck", SPEED * RADIUS) * RADIUS
    axial = (bearing - 0.002 * SPEED) / own
    # What the nut of the first stage carries is the load and the spline's friction.
    assert axial == pytest.approx(LOAD + friction, rel=1e-12)
    assert float(with_film.nut_load[0]) == pytest.approx(LOAD + friction, rel=1e-12)


def test_drag_with_a_width_turns_round_smoothly():
    drag = Drag(0.1, width=2.0)
    at = [float(_steady(drag=drag, speed=s).losses["drag"]) for s in (-1e-3, 0.0, 1e-3, 200.0)]
    assert at[0] == pytest.approx(at[2], rel=1e-12)
    assert at[1] == 0.0
    assert at[2] == pytest.approx(0.1 * 1e-3**2 / 2.0, rel=1e-6)
    assert at[3] == pytest.approx(20.0, rel=1e-4)


_LOADS, _SENSES = strategies.floats(-1e4, 1e4), strategies.sampled_from([-1.0, 1.0])


def _check_coupled(torque, force, bearing, spline, sense):
    """Against iteration, which converges as the product of both coefficients is below 1."""
    per_force, per_torque = bearing * sense, spline * sense
    moment, axial = torque, force
    for _ in range(300):
        moment, axial = torque + per_force * abs(axial), force + per_torque * abs(moment)
    found = _coupled_frictions(*jnp.array([torque, force, per_force, per_torque]))
    np.testing.assert_allclose(found, (moment, axial), rtol=1e-10, atol=1e-9)


@given(_LOADS, _LOADS, strategies.floats(0.0, 0.9), strategies.floats(0.0, 0.9), _SENSES)
def test_frictions_that_follow_each_other(torque, force, bearing, spline, sense):
    _check_coupled(torque, force, bearing, spline, sense)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("torque", [1000.0, -1000.0, 100.0, -100.0])
@pytest.mark.parametrize("force", [1000.0, -1000.0, 100.0, -100.0])
def test_frictions_that_turn_what_they_follow(torque, force, sense):
    """Where one is ten times the other, its friction alone decides the sign of the other."""
    _check_coupled(torque, force, 0.5, 0.7, sense)
