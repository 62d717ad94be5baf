"""Derivatives of a transient, through the solver, against central differences."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import Swing, array, changed, mechanism, stage, thread

import prsm_jax as prsm
from prsm_jax.dynamics import slip_velocity, stage_kinematics
from prsm_jax.dynamics.histories._integration import Settings
from prsm_jax.dynamics.solvers import ForwardMode, Gradient, QuasiSteady, Rodasp, gradient_of
from prsm_jax.dynamics.torque_drive._stick_slip import follow_carriers
from prsm_jax.dynamics.torque_drive._torque_balance import torque_problem
from prsm_jax.dynamics.torque_drive._torque_drive import follow
from prsm_jax.friction import CoulombFriction, Friction
from tests.present import present

VARIABLES = ("lead", "contact_angle", "roller_radius")


@pytest.mark.parametrize("method", ["implicit", "rosenbrock"])
def test_derivatives_against_differences(method):
    """Half way through the run-up, where everything still moves.

    The solver's tolerance is 1e-9; steps that change with the parameters leave noise of that
    size in the differences, which a step of 1 % turns into 1e-7 per relative change.
    """
    one = mechanism(stage(friction=Friction(thread=CoulombFriction(0.1))))

    def evaluate(changes, gradient: Gradient = "both"):
        moved = changed(one, VARIABLES, changes)
        scenario = prsm.Scenario(array(100.0), array(5e3), array(0.1e-3), samples=3)
        run = prsm.simulate(
            moved,
            scenario,
            method=method,
            gradient=gradient,
            rtol=1e-9,
            atol=1e-11,
            max_steps=256,
            throw=False,
        )
        return jnp.stack([run.efficiency[1], run.carrier_ratio[0, 1], run.carrier_ratio[0, 2]])

    @eqx.filter_jit
    def everything(offsets):
        nothing = jnp.zeros(3)
        return (
            jax.jacfwd(evaluate)(nothing),
            # Through the implicit reference solver only forward, which is half the program.
            jax.jacrev(evaluate)(nothing) if method == "rosenbrock" else None,
            jax.lax.map(evaluate, offsets),
        )

    step, weights = 1e-2, np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
    rows = [np.zeros(3)] + [
        sign * k * step * np.eye(3)[v] for v in range(3) for sign in (1, -1) for k in range(1, 5)
    ]
    forward, reverse, found = everything(jnp.asarray(np.array(rows)))
    values, moved = found[0], np.asarray(found[1:]).reshape(3, 2, 4, -1)
    differences = np.einsum("k,vkq->qv", weights, moved[:, 0] - moved[:, 1]) / step
    assert np.max(np.abs(differences)) > 0.1
    np.testing.assert_allclose(forward, differences, rtol=1e-6, atol=2e-7)
    if method == "rosenbrock":
        np.testing.assert_allclose(present(reverse), differences, rtol=1e-6, atol=2e-7)
        # Both modes take the steps of one first integration.
        np.testing.assert_allclose(forward, present(reverse), rtol=1e-11, atol=1e-13)
        # With checkpoints it is a program of its own, which may choose other steps: 80 times the
        # tolerance of the solver were seen.
        alone = eqx.filter_jit(jax.grad(lambda changes: evaluate(changes, "reverse")[2]))
        np.testing.assert_allclose(alone(jnp.zeros(3)), forward[2], rtol=2e-7, atol=1e-9)
    # Still far from the end, so that the solver mattered.
    assert 0 < values[1] < 0.36


def test_reverse_derivative_of_the_slip_direction():
    """The smallest program that jaxlib 0.10.2 got wrong on a CPU, by 18 %.

    Its reshape-mover pass broke programs in which the meshing's root, its transposed derivative
    and the slip are optimised together, as long as the meshing was in small arrays. It is in plain
    numbers now, which leaves that pass nothing to move.
    """
    one = stage(friction=Friction(thread=CoulombFriction(0.1)))

    def axial_direction(angle):
        moved = eqx.tree_at(lambda s: s.thread.contact_angle, one, angle)
        slip = slip_velocity(stage_kinematics(moved), array(100.0), array(20.0))
        return slip[2] / jnp.sqrt(slip @ slip)

    angle = array(np.pi / 4)
    forward = jax.jit(jax.jacfwd(axial_direction))(angle)
    reverse = jax.jit(jax.grad(axial_direction))(angle)
    assert reverse == pytest.approx(float(forward), rel=1e-12)


def _swinging(values, gradient, *, quasi_steady=False):
    """Screw and carriers at the end and half way, and events; without the forces at the samples.

    They stick, break away, and reverse.
    """
    geometry = thread(contact_angle=np.pi / 3)
    one = mechanism(stage(friction=Friction(thread=CoulombFriction(0.7)), geometry=geometry))
    one = prsm.set_parameter(one, "friction.thread.coefficient", values[0])
    one = prsm.set_parameter(one, "roller.inertia", values[2] * 1e-6)
    swing = Swing(array(0.0), values[1], array(2.0))
    scenario = prsm.TorqueScenario(
        swing, prsm.scenario.HingeLoad(array(300.0)), array(0.4), samples=5, most_phases=3
    )
    problem = torque_problem(one, scenario)
    times = jnp.linspace(0.0, 0.4, 5)
    method = QuasiSteady() if quasi_steady else Rodasp()
    settings = Settings(method, gradient_of(gradient), 1e-7, 1e-9, 1024)
    if quasi_steady:
        run = follow(problem, times, settings)
        code, phases = run.code, run.phases
        found = [run.speed[2] / 1e3, run.speed[-1] / 1e3, run.angle[-1] / 1e3]
    else:
        run = follow_carriers(problem, times, settings)
        code, phases = run.solution.code, run.solution.phases
        found = [run.speed[2] / 1e3, run.speed[-1] / 1e3, run.carrier_speed[-1, 0] / 1e3]
    return jnp.stack([*found, *phases.end[:2]]), code


_SWING = (0.7, 3.0, 0.4)


def _weighted(values, gradient, quasi_steady=False):
    """A number that depends on all of them; not a number where the run failed."""
    found, code = _swinging(values, gradient, quasi_steady=quasi_steady)
    return jnp.where(code == 0, jnp.asarray([0.3, -1.0, 0.5, 1.1, -0.2]) @ found, jnp.nan)


def _compare(quasi_steady, rtol):
    """Forward against differences, and reverse, which takes the same steps, against forward."""
    point, step = jnp.asarray(_SWING), 1e-4

    def weighted(gradient):
        return lambda values: _weighted(values, gradient, quasi_steady)

    forward = jax.jit(lambda values, change: jax.jvp(weighted("forward"), (values,), (change,)))
    slopes = []
    for axis in jnp.eye(3):
        move = step * point * axis
        slopes.append(float(forward(point, axis)[1]))
        above, below = (float(forward(point + way * move, axis)[0]) for way in (1, -1))
        difference = (above - below) / (2 * float(jnp.sum(move)))
        # Steps of 1e-7 end elsewhere on either side, which leaves 1e-3 of the difference.
        assert slopes[-1] == pytest.approx(difference, rel=3e-3, abs=3e-3)
    gradient = jax.jit(jax.grad(weighted("reverse")))(point)
    np.testing.assert_allclose(gradient, slopes, rtol=rtol, atol=rtol)
    return slopes


@pytest.mark.usefixtures("memory_for_large_programs")
def test_torque_driven_carriers_through_events():
    """Forward and reverse through sticking, breaking away and a reversal, against differences.

    Reverse mode takes the steps of the forward run again. When it chose them anew, amplified
    rounding made it end elsewhere, and derivatives were 3e-4 to 1e-2 off.
    """
    slopes = _compare(quasi_steady=False, rtol=3e-6)
    # Reverse mode through "both" chooses steps anew, compiled differently: 6e-6 off were seen;
    # steps that are taken again leave 5e-8.
    chosen_anew = jax.jit(jax.grad(lambda values: _weighted(values, "both")))(jnp.asarray(_SWING))
    np.testing.assert_allclose(chosen_anew, slopes, rtol=5e-5)


def test_torque_driven_screw_with_quasi_steady_carriers():
    """The same where the screw alone is a state."""
    _compare(quasi_steady=True, rtol=3e-6)


@jax.jit
def _reversal(scale, friction, torque, speed):
    """When a screw that its load turns back stops, its derivative by `scale`, code and steps."""

    def integrated(scale):
        one = prsm.load("li2020_two_stage")
        one = prsm.mechanism.Mechanism(one.stages[:1], one.operating_point)
        one = prsm.set_parameter(one, "friction.thread.coefficient", friction * scale)
        scenario = prsm.TorqueScenario(
            torque, 7e3 * scale, array(5e-3), initial_speed=speed, samples=3, most_phases=2
        )
        settings = Settings(Rodasp(), ForwardMode(), 1e-8, 1e-10, 256)
        times = jnp.linspace(0.0, 5e-3, 3)
        found = follow_carriers(torque_problem(one, scenario), times, settings).solution
        return found.phases.end[0], (found.code, found.steps)

    return jax.jvp(integrated, (scale,), (jnp.ones_like(scale),), has_aux=True)


def test_derivative_of_the_time_of_a_reversal():
    """By friction and load, against differences, where one long step passes standstill.

    Carriers are in balance all the time. Rounding in the derivative of their slip was multiplied in
    such a step: the derivative was 0.3 s or -31 s, by how it was compiled, in place of -32 µs.
    """
    gentle, quick = (0.0114, 3.0, 3.0), (0.02, 7.5, 30.0)
    _, slope, (code, _) = _reversal(array(1.0), *map(array, gentle))
    above, below = (_reversal(array(x), *map(array, gentle))[0] for x in (1.001, 0.999))
    assert int(code) == 0
    # Truncation of the difference is 1e-6 of it, and the error of the times 1e-5.
    assert slope == pytest.approx(float(above - below) / 2e-3, rel=1e-4)
    # Speeds are linear in time before and after: 20 steps were taken, most of them at standstill.
    _, _, (code, steps) = _reversal(array(1.0), *map(array, quick))
    assert int(code) == 0
    assert int(steps) <= 6
