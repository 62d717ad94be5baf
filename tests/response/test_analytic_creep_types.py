"""Creep friction of inverted and differential roller screws: losses, slip, and what is refused."""

import dataclasses
import functools

import equinox as eqx
import numpy as np
import pytest
from damped_spectrum import assert_all_among, quadratic_eigenvalues
from present import present
from scenes import array, example

import prsm_jax as prsm
from prsm_jax.dynamics import sliding_contact
from prsm_jax.friction import CoulombFriction, StribeckFriction
from prsm_jax.response import creep_friction, spatial_damping
from prsm_jax.vibration import spatial_network, stage_spatial_system

EXAMPLES = {"inverted": "humanoid_leg", "differential": "differential_stage"}
LAWS = {"coulomb": CoulombFriction(0.08), "stribeck": StribeckFriction(0.15, 0.08, 0.3)}
_creep = eqx.filter_jit(creep_friction)
_SPEED = 104.0


def _mechanism(kind, law="coulomb"):
    one = example(EXAMPLES[kind])
    friction = dataclasses.replace(
        present(one.stages[0].friction), thread=LAWS[law], spin=None, rolling_hysteresis=None
    )
    stage = dataclasses.replace(one.stages[0], friction=friction)
    return dataclasses.replace(one, stages=(stage,))


@functools.cache
def _found(kind, law="coulomb", load=2e3):
    return _creep(_mechanism(kind, law), speed=array(_SPEED), load=array(load))


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("load", [2e3, -2e3])
@pytest.mark.parametrize("kind", EXAMPLES)
def test_power_is_the_friction_loss_of_the_steady_state(kind, load, law):
    one, creep = _mechanism(kind, law), _found(kind, law, load)
    loss = float(prsm.steady_state(one, _SPEED, load).losses["thread_sliding"])
    assert float(creep.power) * one.stages[0].roller_count == pytest.approx(loss, rel=1e-12)
    assert bool(creep.valid)
    sliding = sliding_contact(one, 1, _SPEED, load)
    slip = np.asarray(sliding.velocity)
    assert slip / np.linalg.norm(slip) == pytest.approx(np.asarray(sliding.direction), abs=1e-12)
    assert slip @ np.asarray(sliding.contact.normal) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_dashpots_see_the_slip_of_the_steady_motion(kind):
    """Levers of the vibration room against the kinematics of the dynamics room.

    Seen from the carrier. In the frame of the springs the nut of an inverted roller screw presses
    the rollers towards +z, so that a positive speed turns it the other way.
    """
    one = _mechanism(kind)
    thread, creep = one.stages[0].thread, _found(kind)
    speed = -_SPEED if kind == "inverted" else _SPEED
    carrier = speed * float(prsm.steady_state(one, _SPEED, 2e3).carrier_ratio[0])
    screw, nut = float(thread.screw_radius), float(thread.nut_radius)
    roller, reduced = float(thread.roller_radius), float(thread.lead) / (2 * np.pi)
    if kind == "inverted":
        # Rollers roll around the screw, which is held, and move along the axis with it.
        around, rolling, advance = (speed - carrier) * nut, carrier * screw, reduced * speed
    else:
        # Rollers roll in the nut, whose travel depends on the carriers.
        around, rolling = (speed - carrier) * screw, -carrier * nut
        advance = reduced * (speed - carrier)
    assert rolling / roller == pytest.approx(-float(thread.rolling_ratio) * carrier)
    for dashpot, expected in zip(creep.dashpots, (float(creep.slip_speed), 0.0), strict=True):
        rate = float(dashpot.central[3]) * around + float(dashpot.roller[3]) * rolling
        rate += float(dashpot.central[2]) * advance
        assert rate == pytest.approx(expected, abs=1e-12)
    assert {dashpot.body for dashpot in creep.dashpots} == {
        "nut" if kind == "inverted" else "screw"
    }


def test_ratios_of_the_dense_stage():
    """Harmonics against all coordinates: eigenvalues of the whole inverted stage by LAPACK."""
    one = dataclasses.replace(_mechanism("inverted"), axis=None)
    stage = dataclasses.replace(one.stages[0], roller_count=4)
    one = dataclasses.replace(one, stages=(stage,))
    found = eqx.filter_jit(spatial_damping)(one, speed=array(_SPEED), load=array(2e3))
    assert found.result_name == "successful"
    system = eqx.filter_jit(stage_spatial_system)(one, 1, array(2e3))
    network = spatial_network(system)
    exact = quadratic_eigenvalues(network, np.asarray(found.creep.viscous_matrix(system)))
    assert assert_all_among(found, exact) > 10


def test_rollers_that_slide_on_both_sides_are_refused():
    with pytest.raises(prsm.MissingDataError, match=r'sliding contact .* "recirculating"'):
        creep_friction(example("recirculating_stage"))
