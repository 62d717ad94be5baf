"""Transients of a recirculating roller screw: carriers and rollers turn at speeds of their own.

The reference integrates virtual power in NumPy and SciPy: slips of the rigid bodies come from
`type_motion`, normal forces from the axial balances of nut and rollers, which hold the acceleration
of the carriers.
"""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
from present import present
from scenes import Swing, array, mesh, simulate, steady_state
from type_motion import mechanism, reversal, slips_of, with_law

import prsm_jax as prsm
from prsm_jax.friction import LuGreFriction, RegularisedCoulombFriction
from prsm_jax.mechanism import Carrier, body_inertia, body_mass

MEAN, SWING, RATE, LOAD, FRICTION = 100.0, 60.0, 900.0, 5e3, 0.06
KIND = "recirculating"


@functools.cache
def _one():
    return mechanism(KIND, friction=FRICTION, extra=False)


def _speed():
    return Swing(array(MEAN), array(SWING), array(RATE))


@functools.cache
def _run(swings=True, load=LOAD):
    scenario = prsm.Scenario(
        _speed() if swings else MEAN, load, 4e-3, initial_carrier_ratio=0.3, samples=81
    )
    return simulate(_one(), scenario, method="rosenbrock")


def _reference(speed_at, times, load, start):
    (stage,) = _one().stages
    thread, meshing, count = stage.thread, mesh(stage.thread), stage.roller_count
    mass, inertia = (float(law(stage, "roller")) for law in (body_mass, body_inertia))
    nut = float(body_mass(stage, "nut"))
    carriers = stage.carrier.count * float(body_inertia(stage, "carrier"))
    reduced = float(thread.lead) / (2 * np.pi)
    distance = float(thread.centre_distance)
    base, _ = slips_of(thread, meshing, [0.0, 0.0], KIND)
    steps = [slips_of(thread, meshing, step, KIND)[0] for step in np.eye(2)]
    shares = {s: abs(float(getattr(meshing, s).normal_parts[2])) for s in ("screw", "nut")}

    def rates(time, state):
        speed, rate = speed_at(time)
        units, pushes = {}, {}
        for side in ("screw", "nut"):
            slip = speed * base[side]
            slip = slip + sum(
                w * (one[side] - base[side]) for w, one in zip(state, steps, strict=True)
            )
            units[side] = slip / np.linalg.norm(slip)
            pushes[side] = [FRICTION * units[side] @ (one[side] - base[side]) for one in steps]
        # Unknown: accelerations of carrier and roller, normal forces of screw and nut.
        # Rollers advance by h (ω − Ω); the load and the nut's inertia press the nut on them.
        on_nut = (load + nut * reduced * rate) / count
        up = shares["nut"] + FRICTION * units["nut"][2]
        down = shares["screw"] - FRICTION * units["screw"][2]
        circling = mass * distance**2 + carriers / count
        matrix = np.array([
            [0.0, 0.0, 0.0, up],
            [mass * reduced, 0.0, down, -up],
            [circling + inertia + mass * reduced**2, inertia, pushes["screw"][0], pushes["nut"][0]],
            [inertia, inertia, pushes["screw"][1], pushes["nut"][1]],
        ])  # fmt: skip
        advance = mass * reduced * rate
        return np.linalg.solve(matrix, [on_nut, advance, advance * reduced, 0.0])[:2]

    solved = scipy.integrate.solve_ivp(
        rates, (0.0, times[-1]), start, t_eval=times, rtol=1e-10, atol=1e-9, method="LSODA"
    )
    return solved.y[0]


@pytest.mark.parametrize("swings", [False, True])
def test_carrier_speed_is_that_of_virtual_power(swings):
    run, speed = _run(swings), _speed()

    def speed_at(time):
        if not swings:
            return MEAN, 0.0
        value, rate = jax.jvp(speed, (jnp.asarray(time),), (jnp.ones(()),))
        return float(value), float(rate)

    begin = 0.3 * speed_at(0.0)[0]
    thread = _one().stages[0].thread
    spin = -begin * float(thread.nut_radius) / float(thread.roller_radius)
    expected = _reference(speed_at, np.asarray(run.time), LOAD, [begin, spin])
    # Of the tolerances of both integrations.
    np.testing.assert_allclose(np.asarray(run.carrier_speed)[0], expected, rtol=3e-7)


@pytest.mark.parametrize("load", [LOAD, -LOAD])
@pytest.mark.parametrize("swings", [False, True])
def test_power_and_moments_balance(swings, load):
    run = _run(swings, load)
    assert int(run.solver.code) == 0
    assert float(jnp.max(run.power_balance_residual)) < 1e-12
    # Lagrange's accelerations satisfy the balance of moments about the roller's own axis, and that
    # of the pins' forces on the carriers.
    assert float(jnp.max(run.newton_residual)) < 1e-12


@pytest.mark.parametrize("load", [LOAD, -LOAD])
def test_it_settles_to_the_steady_state(load):
    run, state = _run(False, load), steady_state(_one(), MEAN, load)
    for name in ("carrier_ratio", "contact_force", "carrier_force", "screw_roller_axial_force"):
        last = float(getattr(run, name)[0, -1])
        assert last == pytest.approx(float(getattr(state, name)[0]), rel=1e-8), name
    for name in ("drive_torque", "efficiency"):
        last = float(getattr(run, name)[-1])
        assert last == pytest.approx(float(getattr(state, name)), rel=1e-8), name
    direction = np.asarray(run.slip_direction)[0, -1]
    np.testing.assert_allclose(direction, np.asarray(state.slip_direction)[0], atol=1e-8)
    loss = float(run.losses["thread_sliding"][-1])
    assert loss == pytest.approx(float(state.losses["thread_sliding"]), rel=1e-8)


def test_bearing_drag_and_screw_inertia_add_to_the_torque():
    """The torque beside that of the threads: μ r F, drag, and J Ω̇ of the screw."""
    full, bare_one = mechanism(KIND, friction=FRICTION), _one()
    # Carriers whose mass follows from their dimensions: they move along the axis with the nut.
    carrier = Carrier(inertia=1e-6, length=5e-3, radial_width=3e-3)
    full, bare_one = (
        dataclasses.replace(m, stages=(dataclasses.replace(m.stages[0], carrier=carrier),))
        for m in (full, bare_one)
    )
    scenario = prsm.Scenario(_speed(), LOAD, 1e-3, initial_carrier_ratio=0.3, samples=21)
    with_losses, bare = (simulate(one, scenario, method="rosenbrock") for one in (full, bare_one))
    assert float(jnp.max(with_losses.power_balance_residual)) < 1e-12
    (stage,) = full.stages
    friction, rate = present(stage.friction), np.asarray(bare.screw_acceleration)
    reduced = float(stage.thread.lead) / (2 * np.pi)
    # The thrust bearing carries the load and what accelerates nut and rollers.
    rollers = stage.roller_count * float(body_mass(stage, "roller"))
    carrier = np.asarray(bare.carrier_acceleration)[0]
    moved = float(body_mass(stage, "nut")) + 2 * float(body_mass(stage, "carrier"))
    thrust = LOAD + moved * reduced * rate
    thrust = thrust - rollers * reduced * (carrier - rate)
    bearing = present(friction.thrust_bearing)
    expected = float(present(bearing.coefficient)) * float(present(bearing.radius)) * thrust
    expected = expected + float(present(present(friction.drag).torque))
    found = np.asarray(with_losses.drive_torque - bare.drive_torque)
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_reversal_with_friction_that_is_smooth_at_standstill():
    one = with_law(_one(), RegularisedCoulombFriction(FRICTION, 1e-3))
    run = simulate(one, reversal(LOAD))
    assert float(jnp.max(run.power_balance_residual)) < 1e-10
    assert run.solver.name == "RODASP"


def test_a_screw_that_jams_says_so():
    """Beyond a coefficient of about 1 the axial balance needs a contact that pulls."""
    for friction, name in ((0.8, "successful"), (1.2, "jammed")):
        one = mechanism(KIND, friction=friction, extra=False)
        run = prsm.simulate(one, prsm.Scenario(MEAN, LOAD, 1e-3, samples=9), throw=False)
        assert run.solver.result.startswith(name)
        assert steady_state(one, MEAN, LOAD).result_name == name


@pytest.mark.usefixtures("memory_for_large_programs")
def test_derivatives_are_central_differences():
    (stage,) = _one().stages

    def middle(friction, **options):
        law = dataclasses.replace(present(present(stage.friction).thread), coefficient=friction)
        losses = dataclasses.replace(present(stage.friction), thread=law)
        moved = dataclasses.replace(_one(), stages=(dataclasses.replace(stage, friction=losses),))
        scenario = prsm.Scenario(_speed(), array(LOAD), 1e-3, initial_carrier_ratio=0.3, samples=9)
        run = prsm.simulate(moved, scenario, method="rosenbrock", **options)
        return run.drive_torque[4]

    at, step = array(FRICTION), 1e-4
    # Differences of steps that are chosen anew are noise unless these are fine.
    value = jax.jit(lambda x: middle(x, rtol=1e-10, atol=1e-12, max_steps=20000))
    forward = float(jax.jit(jax.jacfwd(middle))(at))
    reverse = float(jax.jit(jax.grad(middle))(at))
    difference = float(value(at + step) - value(at - step)) / (2 * step)
    # Derivatives of the steps taken at the default tolerance: `simulate` states 2e-5.
    assert forward == pytest.approx(difference, rel=3e-5)
    assert reverse == pytest.approx(forward, rel=1e-6)


def test_what_is_not_known_is_refused_and_others_hold_none_of_it():
    one, traced = _one(), prsm.programs.traced_physics
    with pytest.raises(prsm.MissingDataError, match=r"torque are not known for type = .recirc"):
        prsm.simulate(one, prsm.TorqueScenario(1.0, LOAD, 1e-3))
    scenario = prsm.Scenario(MEAN, LOAD, 1e-3)
    with pytest.raises(ValueError, match=r"'closed_form' is not for type = .recirculating"):
        prsm.simulate(one, scenario, method="closed_form")
    assert prsm.dynamics.choose_method(one, scenario).method == "rosenbrock"
    lugre = with_law(one, LuGreFriction(0.08, 0.06, 0.1, 1e7, 10.0))
    with pytest.raises(prsm.MissingDataError, match="LuGre friction of the threads is not known"):
        prsm.simulate(lugre, scenario)
    for kind, holds in (("standard", False), (KIND, True)):
        names = traced(
            lambda m: prsm.simulate(m, scenario, method="rosenbrock").efficiency, mechanism(kind)
        )
        assert ("two_sliding_sides_dynamics" in names) == holds
