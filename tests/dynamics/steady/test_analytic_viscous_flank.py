"""Flanks of a differential roller screw with viscous friction, against virtual power in NumPy.

Viscous friction carries a part of the axial force. What is left for the normal force changes its
sign, and the flanks change, where the axial slip h (Ω − ω) is large enough: it includes the carrier
speed, with which the roller moves along the axis.
"""

import dataclasses
import functools

import jax
import numpy as np
import pytest
from scenes import array, example, mesh, simulate, steady_state
from scipy.optimize import brentq
from type_motion import mechanism, slips_of, with_law

import prsm_jax as prsm
from prsm_jax.dynamics import sliding_contact
from prsm_jax.friction import CoulombFriction, StribeckFriction, ViscousFriction
from prsm_jax.mechanism import DesignProblem, DutyCycle, Objective, OperatingPoint, Variable
from prsm_jax.optimisation import optimise

RESISTANCE, LOAD = 25.0, 200.0
ONE = with_law(mechanism("differential", extra=False), ViscousFriction(RESISTANCE))
(STAGE,) = ONE.stages
COUNT = STAGE.present_roller_count
LEAD = float(STAGE.thread.lead)


@functools.cache
def _basis():
    """Slip and travel per radian at a carrier ratio of 0, and their change per unit of it."""
    meshing = mesh(STAGE.thread)
    (zero, still), (one, moved) = (
        slips_of(STAGE.thread, meshing, np.array([x]), "differential") for x in (0.0, 1.0)
    )
    share = abs(float(meshing.screw.normal_parts[2]))
    return zero["screw"], one["screw"] - zero["screw"], still, moved - still, share


def _reference(speed, load):
    """Carrier ratio, normal force of one roller with its sign, and torque.

    The normal force has no power, so the ratio follows from friction and load alone; its sign is
    that of the axial force less what friction carries.
    """
    slip, per_ratio, travel, more, share = _basis()
    resistance = COUNT * RESISTANCE
    along = np.sign(travel) * load * more
    ratio = -(along / speed + resistance * slip @ per_ratio) / (resistance * per_ratio @ per_ratio)
    velocity = speed * (slip + ratio * per_ratio)
    force = (load / COUNT + RESISTANCE * velocity[2]) / share
    lost = resistance * velocity @ velocity
    return ratio, force, load * abs(travel + ratio * more) + lost / speed


#: Where h Ω alone would change the flanks; h (Ω − ω) does at about 1/(1 − 0.4) of this speed.
FLIP = -LOAD / COUNT / RESISTANCE / (LEAD / (2 * np.pi))


@pytest.mark.parametrize("share", [0.5, 0.95, 1.05, 1.3, 1.6, 1.8, 3.0])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_flank_ratio_and_torque_are_those_of_virtual_power(share, sense):
    speed, load = sense * share * FLIP, sense * LOAD
    ratio, force, torque = _reference(speed, load)
    found = steady_state(ONE, speed, load)
    assert bool(found.valid)
    assert float(found.carrier_ratio[0]) == pytest.approx(ratio, rel=1e-10)
    assert float(found.contact_force[0]) == pytest.approx(abs(force), rel=1e-9)
    assert float(found.drive_torque) == pytest.approx(torque, rel=1e-10)
    # The flanks have changed in the last rows only, and not yet with h Ω alone.
    assert (force * sense < 0) == (share > 1.7)
    contact = sliding_contact(ONE, 1, speed, load)
    # In the frame of the loaded flank.
    turned = np.sign(force) * speed * LEAD / (2 * np.pi) * (1 - ratio)
    assert float(contact.velocity[2]) == pytest.approx(turned, rel=1e-9)


def test_a_transient_ends_on_the_same_flank():
    speed = 1.3 * FLIP
    _, force, torque = _reference(speed, LOAD)
    scenario = prsm.Scenario(array(speed), array(LOAD), 5e-3, samples=11)
    run = simulate(ONE, scenario, method="rosenbrock")
    assert int(run.solver.code) == 0
    assert float(run.contact_force[0, -1]) == pytest.approx(abs(force), rel=1e-6)
    assert float(run.drive_torque[-1]) == pytest.approx(torque, rel=1e-6)


def test_a_part_of_the_friction_that_follows_the_normal_force():
    """Alike on both flanks, with derivatives that are differences, on either side of the change."""
    law = StribeckFriction(0.05, 0.08, 5e-3, viscous_coefficient=RESISTANCE)
    one = with_law(ONE, law)

    def torque(speed):
        return steady_state(one, speed, LOAD).drive_torque

    for share in (1.2, 2.5):
        speed = share * FLIP
        found, mirrored = steady_state(one, speed, LOAD), steady_state(one, -speed, -LOAD)
        assert bool(found.valid)
        assert float(found.contact_force[0]) > 0
        assert float(found.power_balance_residual) < 1e-12
        assert float(mirrored.drive_torque) == pytest.approx(-float(found.drive_torque), rel=1e-12)
        step = 1e-4 * abs(speed)
        difference = (float(torque(speed + step)) - float(torque(speed - step))) / (2 * step)
        slope = float(jax.jit(jax.grad(torque))(array(speed)))
        assert slope == pytest.approx(difference, rel=1e-6)


def _power_of_the_load(speed):
    """Power that a driven load takes; negative where it moves against the travel of the screw."""
    ratio, _, _ = _reference(speed, LOAD)
    _, _, travel, more, _ = _basis()
    return LOAD * np.sign(travel) * (travel + ratio * more) * speed


@functools.cache
def _limit():
    """Speed at which the nut stands: below it the load sinks (power is linear in the speed)."""
    slow, fast = _power_of_the_load(1.0), _power_of_the_load(1e3)
    return 1.0 - slow * 999.0 / (fast - slow)


@pytest.mark.parametrize("share", [0.2, 0.9, 0.999, 1.001, 1.5, 5.0])
def test_a_load_that_sinks_while_the_screw_drives_has_a_name_and_no_efficiency(share):
    speed = share * _limit()
    expected = _power_of_the_load(speed)
    assert (expected < 0) == (share < 1)
    found = steady_state(ONE, speed, LOAD)
    assert float(found.output_power) == pytest.approx(expected, rel=1e-9, abs=1e-12)
    balance = found.input_power - found.output_power - sum(found.losses.values())
    assert float(balance) == pytest.approx(0.0, abs=1e-12 * float(found.input_power))
    assert bool(found.valid)
    assert found.result_name == ("sinking_load" if share < 1 else "successful")
    assert found.has_efficiency == (share > 1)
    names = [one.name for one in prsm.check(_at(speed))]
    assert ("sinking_load" in names) == (share < 1)
    assert "no_balance" not in names


def _at(speed):
    return dataclasses.replace(ONE, operating_point=OperatingPoint(array(speed), array(LOAD)))


def test_speed_and_energies_of_a_load_that_sinks():
    """A duty cycle of one second in which the load sinks, and one in which it is driven."""
    slow, fast = 0.5 * _limit(), 3.0 * _limit()
    cycle = DutyCycle(array([1.0, 1.0]), array([slow, fast]), array([LOAD, LOAD]))
    one = dataclasses.replace(_at(slow), duty_cycle=cycle)
    sunk, lifted = _power_of_the_load(slow), _power_of_the_load(fast)
    assert sunk < 0 < lifted
    found = prsm.compute(one, ["nut_speed", "duty_efficiency"])
    assert float(found["nut_speed"]) == pytest.approx(-sunk / LOAD, rel=1e-9)
    driven = sum(_reference(speed, LOAD)[2] * speed for speed in (slow, fast))
    # The torque of the reference has the travel without its sign.
    driven += 2 * sunk
    assert float(found["duty_efficiency"]) == pytest.approx(lifted / (driven - sunk), rel=1e-9)


def test_a_search_keeps_the_load_from_sinking():
    """Less viscous friction lowers the torque, until the nut would stand."""
    one = with_law(example("differential_stage"), ViscousFriction(25.0))
    speed, load = 100 * np.pi / 30, 3e3
    problem = DesignProblem(
        (Variable("friction.thread.coefficient", 15.0, 40.0),), (Objective("drive_torque"),)
    )
    point = OperatingPoint(array(speed), array(load))
    one = dataclasses.replace(one, operating_point=point, design_problem=problem)

    def power(coefficient):
        changed = prsm.set_parameter(one, "friction.thread.coefficient", coefficient)
        return float(steady_state(changed, speed, load).output_power)

    limit = brentq(power, 15.0, 40.0)
    best = optimise(one)
    assert best.converged
    assert best.optimum.variables["friction.thread.coefficient"] == pytest.approx(limit, rel=1e-3)
    assert "sinking_load" not in [found.name for found in best.findings_optimum]


def test_check_names_a_carrier_that_friction_cannot_hold():
    weak = with_law(mechanism("differential", extra=False), CoulombFriction(1e-3))
    weak = dataclasses.replace(weak, operating_point=OperatingPoint(array(100.0), array(LOAD)))
    assert steady_state(weak, 100.0, LOAD).result_name == "no_balance"
    (found,) = (one for one in prsm.check(weak) if one.name == "no_balance")
    assert (found.severity, found.stage) == ("error", 1)
    assert "raise it" in found.message


def test_a_batch_has_the_results_of_its_designs():
    speeds = array([0.5, 1.5]) * _limit()
    both = jax.vmap(lambda speed: prsm.steady_state(ONE, speed, array(LOAD)))(speeds)
    assert list(both.result_name) == ["sinking_load", "successful"]
    assert list(both.has_efficiency) == [False, True]
    assert np.all(np.asarray(both.valid))
    assert np.all(np.asarray(both.computed))
