"""Derivatives behind a reversal of a prescribed speed, where friction jumps."""

import functools
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax.dynamics.solvers._step_control import WithReversals
from tests.present import present

#: How much heavier carriers are than in the example: they follow the screw late enough to be seen.
_HEAVIER = 1e3
_FREQUENCY = 2 * np.pi * 500
#: Swing and mean of the screw speed [rad/s], and a factor of the friction.
_POINT = (100.0, 20.0, 1.0)
#: Read here: within a trace its numbers would be those of that trace.
_CHAIN = example("li2020_two_stage")


def _end(values, gradient, tolerance):
    """Carrier speeds half a millisecond behind the first reversal of two stages [rad/s]."""
    swing, mean, factor = values

    def changed(chain) -> list[Any]:
        return [
            part
            for stage in chain.stages
            for part in (stage.carrier.inertia, stage.friction.thread.coefficient)
        ]

    inertia, friction = changed(_CHAIN)[::2], changed(_CHAIN)[1::2]
    given = [
        part for i, f in zip(inertia, friction, strict=True) for part in (_HEAVIER * i, factor * f)
    ]
    chain = eqx.tree_at(changed, _CHAIN, given)
    # A function of the caller's own, which holds the numbers that are differentiated.
    scenario = prsm.Scenario(
        lambda time: swing * jnp.sin(_FREQUENCY * time) + mean, 7e3, 1.5e-3, samples=4
    )
    run = prsm.simulate(
        chain,
        scenario,
        method="rosenbrock",
        gradient=gradient,
        rtol=tolerance,
        atol=1e-2 * tolerance,
    )
    return run.carrier_speed[:, -1]


@functools.cache
def _differences(tolerance):
    """By all three numbers, from four values each."""
    evaluate = jax.jit(lambda values: _end(values, "forward", tolerance))
    slopes = []
    for index, value in enumerate(_POINT):
        step = 1e-4 * value
        move = step * jnp.eye(3)[index]
        near, far = (
            evaluate(jnp.asarray(_POINT) + k * move) - evaluate(jnp.asarray(_POINT) - k * move)
            for k in (1, 2)
        )
        slopes.append((8 * near - far) / (12 * step))
    return np.stack(slopes, axis=1)


@pytest.mark.parametrize(
    ("transform", "gradient"), [(jax.jacfwd, "forward"), (jax.jacrev, "reverse")]
)
def test_derivatives_follow_the_time_of_a_reversal(transform, gradient):
    """By swing and mean, which move it, and by friction, which does not.

    Steps that kept the reversal at its time were off by 1.6 % and 5 %. At this tolerance the error
    of the derivatives, and of the differences, is 1e-5 of them. At ten times the tolerance it is
    2e-5 to 6e-5: which steps are taken depends on the rounding of the drive.
    """
    found = jax.jit(transform(lambda values: _end(values, gradient, 1e-11)))(jnp.asarray(_POINT))
    np.testing.assert_allclose(found, _differences(1e-11), rtol=5e-5)


def test_a_time_moves_with_the_reversal_next_to_it():
    """dτ = −dv/(∂v/∂t), close to it only; the time itself stays."""

    def motion(time, offset):
        return 3.0 * (time - 2.0) + offset, jnp.asarray(3.0)

    def moved(time, offset):
        return WithReversals(motion, offset)(time)

    for time, slope in ((2.0, -1 / 3), (2.001, -1 / 3), (2.5, 0.0)):
        value, found = jax.jvp(moved, (jnp.asarray(time), jnp.asarray(0.0)), (0.0, 1.0))
        assert float(value) == time
        assert float(found) == pytest.approx(slope, abs=1e-15)
    # Steps that were not taken start and end at infinity.
    given = jnp.asarray(jnp.inf), jnp.asarray(0.0)
    assert np.all(np.isfinite(jax.grad(moved, 1)(*given)))


def test_values_do_without_it():
    """No motion is evaluated for a time that nothing is differentiated by."""

    def motion(time, offset):
        return jnp.sin(time) + offset, jnp.cos(time)

    def moved(time, offset):
        return WithReversals(motion, offset)(time)

    text = str(jax.make_jaxpr(moved)(1.0, 0.0).jaxpr.eqns)
    program = jax.jit(moved).lower(1.0, 0.0).compile().as_text()
    assert "custom_jvp" in text
    assert "sine" not in present(program)
