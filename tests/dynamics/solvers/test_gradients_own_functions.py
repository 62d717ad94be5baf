"""Speeds, torques and loads that are functions of the caller's own, which hold what is traced."""

import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.core import Tracer
from scenes import mechanism, stage

import prsm_jax as prsm
from prsm_jax.dynamics.solvers import converted
from prsm_jax.friction import Friction, LuGreFriction

#: Read here: within a trace their numbers would be those of that trace.
_ONE = mechanism(stage())
_BRISTLES = mechanism(stage(friction=Friction(LuGreFriction(0.05, 0.08, 1e-2, 1e7, 1e-3))))
#: Enough without bristles; loops of fewer steps are smaller programs.
_FEW_STEPS = 256
_POINT = (100.0, 7e3)


def _speed_driven(mechanism, most_steps):
    def end(values, gradient):
        # Read inside, by a function that JAX compiles by itself.
        scenario = prsm.Scenario(
            lambda time: values[0] * (1 + 0.3 * jnp.sin(900.0 * time)),
            lambda time: values[1] * (1 + 0.1 * jnp.cos(700.0 * time)),
            1e-3,
            samples=3,
        )
        run = prsm.simulate(
            mechanism,
            scenario,
            method="rosenbrock",
            gradient=gradient,
            max_steps=most_steps,
        )
        return run.carrier_speed[0, -1]

    return end


def _torque_driven(values, gradient):
    scenario = prsm.TorqueScenario(
        lambda time: 0.14 * values[0] * (1 + 0.1 * jnp.sin(900.0 * time)),
        lambda time: values[1] * (1 + 0.1 * jnp.cos(700.0 * time)),
        1e-3,
        initial_speed=1.0,
        samples=3,
    )
    run = prsm.simulate(_ONE, scenario, gradient=gradient, max_steps=_FEW_STEPS)
    return run.screw_speed[-1]


_SCENES = {
    "speed": _speed_driven(_ONE, _FEW_STEPS),
    "bristles": _speed_driven(_BRISTLES, None),
    "torque": _torque_driven,
}


def agree(name):
    """`jax.grad` as it comes and forward mode give the same; JAX raised a TypeError before."""
    end, point = _SCENES[name], jnp.asarray(_POINT)

    def gradient(transform, kind):
        return np.asarray(jax.jit(transform(lambda values: end(values, kind)))(point))

    as_it_comes = gradient(jax.grad, "both")
    assert np.all(as_it_comes != 0)
    # The same steps, compiled in another way.
    np.testing.assert_allclose(gradient(jax.jacfwd, "forward"), as_it_comes, rtol=1e-6)


@pytest.mark.parametrize("name", _SCENES)
def test_gradients_through_what_a_function_holds(name):
    """In a process of its own: the types that tests check wrap functions, which hides the fault."""
    here = Path(__file__).parent
    paths = [str(here), str(here.parents[1]), str(Path(prsm.__file__).parents[1])]
    code = (
        f"import sys; sys.path[:0] = {paths}\n"
        f"import {Path(__file__).stem} as tests; tests.agree({name!r})"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=False
    )
    assert found.returncode == 0, found.stderr


def _at(time, function):
    """Closes over nothing, as the right-hand sides of the package do where nothing checks types."""
    return function(time)


def test_what_a_function_in_the_arguments_holds_becomes_a_number_of_the_converted_one():
    """Rules of derivatives see numbers only."""

    def held(value):
        function = lambda time: value * time  # noqa: E731
        found = converted(_at, jnp.asarray(2.0), function)
        assert any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(found))
        return found(jnp.asarray(2.0), function)

    assert jax.jvp(held, (3.0,), (1.0,)) == (6.0, 2.0)
