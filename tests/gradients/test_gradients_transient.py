"""Derivatives of a transient, through the solver, against central differences."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import Swing, array, mechanism, stage, thread

import prsm_jax as prsm
from prsm_jax.dynamics import slip_velocity, stage_kinematics
from prsm_jax.mechanism import CoulombFriction, Friction

VARIABLES = ("lead", "contact_angle", "roller_radius")


@pytest.mark.slow
@pytest.mark.parametrize("method", ["implicit", "rosenbrock"])
def test_derivatives_against_differences(method):
    """Half way through the run-up, where everything still moves.

    The solver's tolerance is 1e-9; steps that change with the parameters leave noise of that
    size in the differences, which a step of 1 % turns into 1e-7 per relative change.
    """
    one = mechanism(stage(friction=Friction(thread=CoulombFriction(0.1))))
    base = jnp.stack([prsm.get_parameter(one, name) for name in VARIABLES])

    def evaluate(changes):
        moved = one
        for name, value, change in zip(VARIABLES, base, changes, strict=True):
            moved = prsm.set_parameter(moved, name, value * (1 + change))
        scenario = prsm.Scenario(array(100.0), array(5e3), array(0.1e-3), samples=3)
        run = prsm.simulate(
            moved, scenario, method=method, rtol=1e-9, atol=1e-11, max_steps=256, throw=False
        )
        return jnp.stack([run.efficiency[1], run.carrier_ratio[0, 1], run.carrier_ratio[0, 2]])

    @eqx.filter_jit
    def everything(offsets):
        nothing = jnp.zeros(3)
        return (
            evaluate(nothing),
            jax.jacfwd(evaluate)(nothing),
            # Through the implicit reference solver only forward, which is half the program.
            jax.jacrev(evaluate)(nothing) if method == "rosenbrock" else None,
            jax.lax.map(evaluate, offsets),
        )

    step, weights = 1e-2, np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
    rows = [
        sign * k * step * np.eye(3)[v] for v in range(3) for sign in (1, -1) for k in range(1, 5)
    ]
    values, forward, reverse, moved = everything(jnp.asarray(np.array(rows)))
    moved = np.asarray(moved).reshape(3, 2, 4, -1)
    differences = np.einsum("k,vkq->qv", weights, moved[:, 0] - moved[:, 1]) / step
    assert np.max(np.abs(differences)) > 0.1
    np.testing.assert_allclose(forward, differences, rtol=1e-6, atol=2e-7)
    if method == "rosenbrock":
        np.testing.assert_allclose(reverse, differences, rtol=1e-6, atol=2e-7)
        # The two modes are two programs. Where rounding makes them take different steps, each
        # derivative carries its own error, some tens of the solver's tolerance.
        np.testing.assert_allclose(forward, reverse, rtol=5e-8, atol=1e-9)
        # Alone, each reverse derivative is a program of its own, compiled differently.
        alone = eqx.filter_jit(jax.grad(lambda changes: evaluate(changes)[2]))(jnp.zeros(3))
        np.testing.assert_allclose(alone, forward[2], rtol=5e-8, atol=1e-9)
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


@pytest.mark.slow
def test_torque_driven_carriers_through_events():
    """Forward and reverse through sticking, breaking away and a reversal, against differences."""
    geometry = thread(contact_angle=np.pi / 3)
    base = mechanism(stage(friction=Friction(thread=CoulombFriction(0.7)), geometry=geometry))
    weights = jnp.asarray([0.3, -1.0, 0.5, 0.7, 1.1, -0.2])

    def evaluate(values):
        one = prsm.set_parameter(base, "friction.thread.coefficient", values[0])
        one = prsm.set_parameter(one, "roller.inertia", values[2] * 1e-6)
        swing = Swing(array(0.0), values[1], array(2.0))
        scenario = prsm.TorqueScenario(
            swing, prsm.HingeLoad(array(300.0)), array(0.4), samples=21, most_phases=4
        )
        run = prsm.simulate(one, scenario, rtol=1e-8, atol=1e-10, max_steps=1024, throw=False)
        found = [run.screw_speed[10] / 1e3, run.screw_speed[-1] / 1e3, run.carrier_speed[0, -1]]
        found = [*found[:2], found[2] / 1e3, run.position[-1] * 10, *run.phases.end[:2]]
        return jnp.stack(found), run.solver.code

    point, step = jnp.asarray([0.7, 3.0, 0.4]), 1e-4
    forward = jax.jit(
        lambda values, change: jax.jvp(lambda v: evaluate(v)[0], (values,), (change,))[1]
    )
    value = jax.jit(evaluate)
    assert int(value(point)[1]) == 0
    slopes = np.stack([forward(point, axis) for axis in jnp.eye(3)], axis=1)
    for index in range(3):
        move = step * point[index] * jnp.eye(3)[index]
        difference = (value(point + move)[0] - value(point - move)[0]) / (2 * step * point[index])
        # Steps of 1e-8 end elsewhere on either side, which leaves 1e-4 of the difference.
        scale = 1e-3 * np.max(np.abs(slopes), axis=1)
        assert np.all(np.abs(slopes[:, index] - difference) < 1e-3 * np.abs(difference) + scale)
    gradient = jax.jit(jax.grad(lambda values: weights @ evaluate(values)[0]))(point)
    np.testing.assert_allclose(gradient, weights @ slopes, rtol=1e-5)
