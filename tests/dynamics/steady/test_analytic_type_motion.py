"""Steady motion of every type of roller screw against virtual power, in NumPy and SciPy.

Points and normals come from the meshing; velocities from rigid bodies, forces from the balance of
axial forces, and speeds from the balance of virtual power, none of it from the room of dynamics.
"""

import dataclasses
import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize
from hypothesis import given, settings, strategies as st
from present import present
from scenes import Swing, array, mesh, simulate, steady_state
from type_motion import FREE, mechanism, slips_of

import prsm_jax as prsm
from prsm_jax._errors import MissingDataError
from prsm_jax.dynamics import all_kinematics, states_at
from prsm_jax.dynamics.forces import roller_support_forces
from prsm_jax.friction import Friction, StribeckFriction, ViscousFriction
from prsm_jax.mechanism import (
    ROLLER_SCREW_TYPES,
    Mechanism,
    OperatingPoint,
)
from prsm_jax.quantities import compute_checked

SPEED, LOAD = 100.0, 5000.0
MARGINS = ("jamming_margin", "self_locking_margin")


def reference(one, friction, sense=1.0):
    """Carrier ratio, travel per radian, efficiency and jamming margin of threads alone.

    By virtual power; the margin is the share of the normal force that carries axially.

    The power of friction and load does not change with the unknown speeds.
    """
    (stage,) = one.stages
    thread, kind = stage.thread, stage.type
    meshing = mesh(thread)
    family = thread.family
    ideal = np.array([float(thread.ideal_carrier_ratio)])
    if family.carrying is None:
        ideal = np.append(ideal, -ideal * float(thread.nut_radius) / float(thread.roller_radius))
    zero, still = slips_of(thread, meshing, 0 * ideal, kind)
    bases = [slips_of(thread, meshing, step, kind) for step in np.eye(ideal.size)]

    def state(unknown):
        slips, travel = slips_of(thread, meshing, unknown, kind)
        forces = {}
        for side in family.sliding:
            unit = slips[side] / np.linalg.norm(slips[side])
            share = abs(float(getattr(meshing, side).normal_parts[2]))
            forces[side] = 1 / (share - sense * friction * abs(unit[2]))
        return slips, travel, forces

    def imbalance(unknown):
        slips, travel, forces = state(unknown)
        rows = []
        for other, moved in bases:
            # The load resists travel, or drives it.
            row = -sense * (moved - still) * np.sign(travel)
            for side in family.sliding:
                unit = slips[side] / np.linalg.norm(slips[side])
                row -= friction * forces[side] * unit @ (other[side] - zero[side])
            rows.append(row)
        return np.array(rows) / float(thread.lead)

    found = scipy.optimize.root(imbalance, ideal, method="hybr", options={"xtol": 1e-14})
    slips, travel, forces = state(found.x)
    loss = sum(friction * forces[side] * np.linalg.norm(slips[side]) for side in family.sliding)
    useful = abs(travel)
    efficiency = useful / (useful + loss) if sense > 0 else (useful - loss) / useful
    shares = [
        1 / (forces[side] * abs(float(getattr(meshing, side).normal_parts[2])))
        for side in family.sliding
    ]
    return found.x[0], useful, efficiency, min(shares)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("kind", ROLLER_SCREW_TYPES)
def test_ratio_travel_and_efficiency_by_virtual_power(kind, sense):
    """To 1e-9: SciPy's finite differences end there."""
    one = mechanism(kind, friction=0.06, extra=False)
    found = steady_state(one, sense * SPEED, LOAD)
    ratio, travel, efficiency, _ = reference(one, 0.06, sense)
    assert found.result_name == "successful"
    assert float(found.carrier_ratio[0]) == pytest.approx(ratio, rel=1e-9)
    assert float(found.efficiency) == pytest.approx(efficiency, rel=1e-9)
    output = abs(float(found.output_power if sense > 0 else found.input_power))
    assert output == pytest.approx(LOAD * travel * SPEED, rel=1e-9)


@pytest.mark.parametrize("kind", ROLLER_SCREW_TYPES)
def test_limits_of_efficiency_and_ratio_at_a_small_lead(kind):
    """(1 − μ tan α)/(1 + μ cot α) and ideal rolling, with errors of the order of the lead.

    The axial slips of screw and nut of a recirculating roller screw add up to the travel, so its
    limit is the same. That of a differential one is reached from a smaller lead, because its load
    also drives the carriers.
    """
    errors = []
    for helix in (0.4, 0.04):
        one = mechanism(kind, helix=helix, angle=50.0, friction=0.08, extra=False)
        found = steady_state(one, SPEED, LOAD)
        slope = np.tan(np.radians(40.0))
        limit = (1 - 0.08 * slope) / (1 + 0.08 / slope)
        errors.append(
            (
                abs(float(found.efficiency) - limit),
                abs(float(found.carrier_ratio[0] - one.stages[0].thread.ideal_carrier_ratio)),
            )
        )
    (efficiency, ratio), (smaller_efficiency, smaller_ratio) = errors
    assert smaller_efficiency < 0.11 * efficiency + 1e-12
    assert smaller_ratio < 0.11 * ratio + 1e-12


@pytest.mark.parametrize("kind", ROLLER_SCREW_TYPES)
@settings(max_examples=15)
@given(data=st.data())
def test_power_balances_at_random_dimensions(kind, data):
    """Torque times speed is load times travel plus all losses, to rounding."""
    ratio = st.integers(5, 9).map(float) if kind not in FREE else st.floats(4, 9)
    one = mechanism(
        kind,
        radius=data.draw(st.floats(1e-3, 5e-3)),
        ratio=data.draw(ratio),
        helix=data.draw(st.floats(0.2, 4)),
        angle=data.draw(st.floats(38, 52)),
        friction=data.draw(st.floats(0.05, 0.12)),
    )
    speed = data.draw(st.sampled_from([-1.0, 1.0])) * data.draw(st.floats(1, 500))
    load = data.draw(st.sampled_from([-1.0, 1.0])) * data.draw(st.floats(10, 1e4))
    found = steady_state(one, speed, load)
    assert bool(found.computed)
    assert float(found.power_balance_residual) < 1e-12
    assert set(found.losses) == {"thread_sliding", "thrust_bearing", "drag"}
    assert all(float(power) > 0 for power in found.losses.values())


@pytest.mark.parametrize("kind", ROLLER_SCREW_TYPES)
def test_both_flanks_are_alike(kind):
    """A load of the other sign, turned the other way, is the same mechanism from its other end."""
    one = mechanism(kind)
    first, second = (steady_state(one, s * SPEED, s * LOAD) for s in (1.0, -1.0))
    np.testing.assert_allclose(second.efficiency, first.efficiency, rtol=1e-14)
    np.testing.assert_allclose(second.drive_torque, -first.drive_torque, rtol=1e-14)
    np.testing.assert_allclose(second.carrier_force, first.carrier_force, rtol=1e-12)


def test_the_load_of_a_differential_screw_needs_friction():
    """It drives the carriers, and only friction at the screw holds them: h F ≤ μ F_n |d|."""
    one = mechanism("differential", friction=0.06, extra=False)
    ratio = float(steady_state(one, SPEED, LOAD).carrier_ratio[0])
    back = float(steady_state(one, -SPEED, LOAD).carrier_ratio[0])
    ideal = float(one.stages[0].thread.ideal_carrier_ratio)
    # Friction acts against the load in both senses of turning.
    assert ratio > ideal > back or ratio < ideal < back
    weak = mechanism("differential", friction=0.005, extra=False)
    assert prsm.steady_state(weak, array(SPEED), array(LOAD)).result_name == "no_balance"
    bare = dataclasses.replace(one.stages[0], friction=None)
    with pytest.raises(MissingDataError, match="only thread friction can drive them or hold them"):
        prsm.steady_state(Mechanism((bare,)), SPEED, LOAD)


@pytest.mark.parametrize("kind", FREE)
def test_gradients_of_efficiency_and_ratio(kind):
    """Both modes against central differences of step 1e-6, whose error is below 1e-7."""
    one = mechanism(kind)
    names = ["lead", "roller_radius", "contact_angle", "radius_ratio"]
    names.append("friction.thread.coefficient")

    def both(changes):
        moved = one
        for name, change in zip(names, changes, strict=True):
            value = prsm.get_parameter(one, name) * (1 + change)
            moved = prsm.set_parameter(moved, name, value, checked=False)
        found = prsm.steady_state(moved, array(SPEED), array(LOAD))
        return jnp.stack([found.efficiency, found.carrier_ratio[0], found.drive_torque])

    both = jax.jit(both)
    zero, step = jnp.zeros(len(names)), 1e-6
    forward = np.asarray(jax.jacfwd(both)(zero))
    reverse = np.asarray(jax.jacrev(both)(zero))
    central = np.stack(
        [(both(step * e) - both(-step * e)) / (2 * step) for e in jnp.eye(len(names))], axis=-1
    )
    np.testing.assert_allclose(reverse, forward, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(forward, central, rtol=1e-6, atol=1e-8)
    assert np.all(np.abs(forward[0, :3]) > 0)


def test_an_inverted_screw_settles_to_its_steady_ratio():
    """The carriers' equation is that of the standard type, with the inertias of its own bodies."""
    one = mechanism("inverted", extra=False)
    steady = steady_state(one, SPEED, LOAD)
    run = simulate(one, prsm.Scenario(SPEED, LOAD, 2e-2))
    assert int(run.solver.code) == 0
    settled = run.carrier_speed[0, -1] / SPEED
    np.testing.assert_allclose(settled, steady.carrier_ratio[0], rtol=1e-9)
    # h of the start, at rest: f·d = I ω̇ with all of the friction along the slip.
    np.testing.assert_allclose(run.power_balance_residual, 0.0, atol=1e-10)


@pytest.mark.parametrize("kind", FREE)
def test_what_is_not_known_names_the_type(kind):
    one = mechanism(kind)
    with pytest.raises(MissingDataError, match=f'all bodies .* not for type = "{kind}"'):
        prsm.dynamics.body_forces(one, steady_state(one, SPEED, LOAD))


@functools.cache
def _margins(kind):
    """Both margins of a friction coefficient, and their derivatives in both modes."""
    one = mechanism(kind, friction=0.06, extra=False)

    def both(coefficient):
        moved = prsm.set_parameter(one, "friction.thread.coefficient", coefficient)
        values, valid = compute_checked(moved, MARGINS, speed=SPEED, load=LOAD)
        return jnp.stack([values[name] for name in MARGINS]), valid

    slopes = (jax.jit(way(lambda c: both(c)[0])) for way in (jax.jacfwd, jax.jacrev))
    return jax.jit(both), *slopes


@pytest.mark.parametrize("kind", FREE)
def test_margins_of_jamming_and_self_locking_by_virtual_power(kind):
    values, forward, reverse = _margins(kind)
    one = mechanism(kind, friction=0.06, extra=False)
    held: Any = scipy.optimize.brentq(lambda f: reference(one, f, -1.0)[2], 0.7, 1.3, xtol=1e-14)
    # Less friction does not hold the carriers of a differential one against the load.
    for friction in (0.06, 0.5, 0.9):
        (jamming, locking), valid = values(array(friction))
        assert bool(valid)
        # SciPy's finite differences end near 1e-9.
        assert float(jamming) == pytest.approx(reference(one, friction)[3], rel=1e-8)
        assert float(locking) == pytest.approx(1 - friction / held, rel=1e-8, abs=1e-9)
        step = 1e-4 * friction
        ends = [np.asarray(values(array(friction + h * step))[0]) for h in (-2, -1, 1, 2)]
        difference = (8 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / (12 * step)
        for slope in (forward, reverse):
            np.testing.assert_allclose(slope(array(friction)), difference, rtol=1e-7)
    # Beyond both limits forces have no meaning, but an optimiser finds its way back.
    beyond, valid = values(array(1.2))
    assert bool(valid)
    assert np.all(np.asarray(beyond) < -0.1)
    for slope in (forward, reverse):
        np.testing.assert_allclose(slope(array(1.2)), -1.0, rtol=0.02)


@pytest.mark.parametrize("kind", FREE)
def test_the_steady_state_changes_at_the_margins(kind):
    values, _, _ = _margins(kind)

    def zero_of(which) -> Any:
        # At the jam itself forces are infinite: the search ends beside it.
        return scipy.optimize.brentq(
            lambda f: float(values(array(f))[0][which]), 0.7, 1.3, xtol=1e-8
        )

    def code(friction, speed):
        one = mechanism(kind, friction=friction, extra=False)
        return steady_state(one, speed, LOAD).result_name

    held = zero_of(1)
    assert code(held * (1 - 1e-6), -SPEED) == "successful"
    assert code(held * (1 + 1e-6), -SPEED) == "self_locking"
    if kind == "differential":
        jam, near = zero_of(0), 1e-6
    else:
        # Between the jams of its two sides, near the cotangent of 45°, it has no balance.
        jam, near = 1.0, 1e-2
        assert float(values(array(jam - near))[0][0]) > 0 > float(values(array(jam + near))[0][0])
    assert code(jam * (1 - near), SPEED) == "successful"
    assert code(jam * (1 + near), SPEED) == "jammed"


@pytest.mark.parametrize("kind", FREE)
def test_findings_of_jamming_and_self_locking(kind):
    def findings(friction):
        one = dataclasses.replace(
            mechanism(kind, friction=friction, extra=False),
            operating_point=OperatingPoint(speed=SPEED, load=LOAD),
        )
        found = {finding.name: finding for finding in prsm.check(one)}
        return [found.get(name) for name in ("jamming", "self_locking")]

    assert findings(0.06) == [None, None]
    jamming, locking = (present(one) for one in findings(0.87))
    assert (jamming.severity, locking.severity) == ("warning", "warning")
    margin = reference(mechanism(kind, extra=False), 0.87)[3]
    assert f"leaves {margin:.0%} of the axial part" in jamming.message
    locking_margin = float(_margins(kind)[0](array(0.87))[0][1])
    factor = 1 / (1 - locking_margin)
    assert f"all friction multiplied by {factor:.3g} would just hold" in locking.message
    jamming, locking = (present(one) for one in findings(1.2))
    assert (jamming.severity, locking.severity) == ("error", "note")
    assert "screw jams" in jamming.message


def _with_friction(one, friction):
    return dataclasses.replace(one, stages=(dataclasses.replace(one.stages[0], friction=friction),))


@pytest.mark.parametrize("helix", [1.0, 4.0, 9.0])
def test_without_friction_nothing_jams_and_the_load_drives_back(helix):
    free = _with_friction(mechanism("recirculating", helix=helix, extra=False), None)
    values = prsm.compute(free, MARGINS, speed=SPEED, load=LOAD)
    assert [float(values[name]) for name in MARGINS] == [1.0, 1.0]


@pytest.mark.parametrize("kind", FREE)
@pytest.mark.parametrize("load", [LOAD, 0.0])
def test_friction_that_does_not_grow_with_the_load_never_jams(kind, load):
    """Also with a Stribeck law: only its part in proportion to the normal force counts."""
    one = mechanism(kind, extra=False)
    viscous = _with_friction(one, Friction(thread=ViscousFriction(30.0)))
    if kind == "recirculating":
        margin = prsm.compute(viscous, ["jamming_margin"], speed=SPEED, load=load)
        assert float(margin["jamming_margin"]) == 1.0
    law = StribeckFriction(0.06, 0.06, 0.3, viscous_coefficient=20.0)
    mixed, plain = (
        prsm.compute(which, ["jamming_margin"], speed=SPEED, load=load)["jamming_margin"]
        for which in (_with_friction(one, Friction(thread=law)), one)
    )
    # The viscous part moves the carriers a little.
    assert float(mixed) == pytest.approx(float(plain), rel=0.05)


def test_too_little_friction_has_no_margin_and_says_so():
    """It does not hold the carriers of a differential one against the load."""
    _, valid = _margins("differential")[0](array(1e-3))
    assert not bool(valid)


@pytest.mark.parametrize("kind", FREE)
def test_no_coefficient_of_rollers_without_lead_jams_or_locks(kind):
    for name in ("critical_friction_coefficient", "jamming_friction_coefficient"):
        with pytest.raises(MissingDataError, match=f'not for type = "{kind}"'):
            prsm.compute(mechanism(kind, extra=False), [name], speed=SPEED, load=LOAD)


@pytest.mark.parametrize("kind", ["standard", "inverted", "differential"])
def test_forces_on_a_roller_balance_in_newtons_form(kind):
    """Moments about the roller's axis, which Lagrange's equation of the carriers does not use.

    Relative to the largest moment, the normal force of the screw at the roller's radius.
    """
    one = mechanism(kind, extra=False)
    (stage,) = one.stages
    kinematics = all_kinematics(one)
    ratio = steady_state(one, SPEED, LOAD).carrier_ratio
    scenario = prsm.Scenario(SPEED, LOAD, 1.0)
    (state,) = states_at(one, kinematics, scenario, array(0.0), ratio * SPEED)
    support = roller_support_forces(stage, kinematics[0], state, None)
    size = state.forces.contact_force * stage.thread.roller_radius
    assert abs(float(support.moment_residual / size)) < 1e-9
    assert float(support.ring_gear_tangential) != 0
    assert (float(support.ring_gear_force) == 0) == (kind == "differential")


@pytest.mark.parametrize("kind", ["standard", "inverted"])
def test_the_motor_accelerates_one_body_and_the_other_moves_along(kind):
    """M = J Ω̇ + h (F + m h Ω̇): J of the body that turns, m of the other with the rollers.

    Without friction the carriers stand still and take no part.
    """
    one = mechanism(kind)
    (stage,) = one.stages
    one = Mechanism((dataclasses.replace(stage, friction=None),))
    swing = Swing(array(50.0), array(20.0), array(3.0))
    scenario = prsm.Scenario(swing, LOAD, 1.0)
    time = 0.1
    rate = 20 * 2 * np.pi * 3 * np.cos(2 * np.pi * 3 * time)
    (state,) = states_at(one, all_kinematics(one), scenario, array(time), jnp.zeros(1))
    steel, thread = 7850 * np.pi, stage.thread
    screw, roller, nut = (float(getattr(thread, f"{b}_radius")) for b in ("screw", "roller", "nut"))
    masses = {
        "screw": steel * 0.3 * screw**2,
        "nut": steel * 0.05 * ((nut + 6e-3) ** 2 - nut**2),
    }
    inertias = {
        "screw": masses["screw"] * screw**2 / 2,
        "nut": masses["nut"] * ((nut + 6e-3) ** 2 + nut**2) / 2,
    }
    turns, moves = ("nut", "screw") if kind == "inverted" else ("screw", "nut")
    moved = masses[moves] + 5 * steel * 0.03 * roller**2
    h = float(thread.lead) / (2 * np.pi)
    torque = inertias[turns] * rate + h * (LOAD + moved * h * rate)
    assert float(state.screw.drive_torque) == pytest.approx(torque, rel=1e-12)
