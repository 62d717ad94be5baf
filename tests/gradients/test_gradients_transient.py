"""Derivatives of a transient, through the solver, against central differences."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, mechanism, stage

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
