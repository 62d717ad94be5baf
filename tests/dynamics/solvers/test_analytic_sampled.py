"""States at samples that each step computes for all samples, against those that diffrax saves."""

from typing import Any

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import mechanism

from prsm_jax import Scenario, simulate
from prsm_jax.dynamics.solvers._kvaerno import Kvaerno
from prsm_jax.dynamics.solvers._sampled import (
    LAST_STATE,
    Sampled,
    sampled,
    states_at_samples,
)
from prsm_jax.dynamics.solvers.rodasp._solver import Rodasp

_TIMES = jnp.linspace(0.0, 2.0, 41)
#: On a sample.
_BREAK = float(_TIMES[15])
#: Interpolation by a share that is a product instead of a quotient: roundings of states of order
#: one, times the slope of a state within a step.
_ROUNDING = 1e-14


def _rate(time, state, rates):
    pushed = jnp.where(time < _BREAK, 1.0, -1.0)
    return jnp.stack([rates * (pushed - state[0]), state[0] - 3.0 * state[1]])


def _solution(solver, rates, rtol=1e-6, max_steps=500):
    start = jnp.asarray([0.5, 0.0])
    own = isinstance(solver, Sampled)
    return diffrax.diffeqsolve(
        diffrax.ODETerm(_rate),
        solver,
        0.0,
        2.0,
        None,
        start,
        rates,
        saveat=LAST_STATE if own else diffrax.SaveAt(ts=_TIMES),
        stepsize_controller=diffrax.ClipStepSizeController(
            diffrax.PIDController(rtol=rtol, atol=1e-2 * rtol), jump_ts=jnp.asarray([_BREAK])
        ),
        adjoint=diffrax.ForwardMode(),
        max_steps=max_steps,
        throw=False,
    )


def _states(solver, rates, **options) -> Any:
    solution = _solution(solver, rates, **options)
    return states_at_samples(solution) if isinstance(solver, Sampled) else solution.ys


_SOLVERS = [Rodasp(), Rodasp(compact=True), Kvaerno(1e-6, 1e-8)]


@pytest.mark.parametrize("solver", _SOLVERS, ids=["rodasp", "rodasp in a loop", "kvaerno"])
def test_samples_are_those_that_diffrax_saves(solver):
    rates = jnp.asarray([0.1, 50.0, 4000.0])
    ours = jax.vmap(lambda r: _states(Sampled(solver, _TIMES), r))(rates)
    theirs = jax.vmap(lambda r: _states(solver, r))(rates)
    assert ours.shape == (3, 41, 2)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=_ROUNDING)
    # Steps with several samples, and several steps between samples.
    steps = jax.vmap(lambda r: _solution(solver, r).stats["num_accepted_steps"])(rates)
    assert steps.min() < 41 < steps.max()


def test_samples_are_exact_to_the_tolerance():
    """Against the closed form of the first state, before and after the break."""
    rate, times = 50.0, np.asarray(_TIMES)
    at_break = 1 - 0.5 * np.exp(-rate * _BREAK)
    before = 1 - 0.5 * np.exp(-rate * times)
    after = -1 + (at_break + 1) * np.exp(-rate * (times - _BREAK))
    states = _states(Sampled(Rodasp(), _TIMES), jnp.asarray(rate), rtol=1e-8)
    # The error is 5e-9 at a tolerance of 1e-8.
    np.testing.assert_allclose(
        states[:, 0], np.where(times <= _BREAK, before, after), rtol=0, atol=2e-8
    )


def test_derivatives_are_those_of_samples_that_diffrax_saves():
    rates = jnp.asarray([2.0, 4000.0])
    ours = jax.vmap(jax.jacfwd(lambda r: _states(Sampled(Rodasp(), _TIMES), r)))(rates)
    theirs = jax.vmap(jax.jacfwd(lambda r: _states(Rodasp(), r)))(rates)
    assert np.abs(theirs[0]).max() > 0.1
    np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=_ROUNDING)


def test_samples_that_are_not_reached_are_infinite():
    ours = _states(Sampled(Rodasp(), _TIMES), jnp.asarray(4000.0), max_steps=12)
    theirs = _states(Rodasp(), jnp.asarray(4000.0), max_steps=12)
    assert np.isinf(ours[-1]).all()
    assert np.isfinite(ours[0]).all()
    np.testing.assert_array_equal(np.isinf(ours), np.isinf(theirs))


def test_states_of_any_structure_are_sampled():
    def rate(time, state, args):
        return {"x": -state["x"], "turned": jnp.outer(state["x"], state["x"])}

    start = {"x": jnp.asarray([1.0, 2.0, 3.0]), "turned": jnp.zeros((3, 3))}
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(rate),
        Sampled(Rodasp(autonomous=True), _TIMES),
        0.0,
        2.0,
        None,
        start,
        saveat=LAST_STATE,
        stepsize_controller=diffrax.PIDController(rtol=1e-9, atol=1e-9),
        adjoint=diffrax.ForwardMode(),
    )
    states = states_at_samples(solution)
    decay = np.exp(-np.asarray(_TIMES))
    np.testing.assert_allclose(states["x"], np.outer(decay, start["x"]), rtol=0, atol=3e-9)
    products = np.outer(start["x"], start["x"])[None] * ((1 - decay**2) / 2)[:, None, None]
    np.testing.assert_allclose(states["turned"], products, rtol=0, atol=5e-9)


def test_many_samples_and_other_solvers_are_left_to_diffrax():
    assert sampled(Rodasp(), jnp.zeros(256), few_steps=True) is not None
    assert sampled(Rodasp(), jnp.zeros(257), few_steps=True) is None
    assert sampled(Rodasp(), jnp.zeros(64), few_steps=False) is not None
    assert sampled(Rodasp(), jnp.zeros(65), few_steps=False) is None
    assert sampled(diffrax.Tsit5(), jnp.zeros(3), few_steps=True) is None


def test_steps_have_no_loop_over_few_samples():
    one = mechanism()

    def loops(speed, samples):
        def speeds(load):
            scenario = Scenario(speed, load, duration=1e-3, samples=samples)
            run = simulate(one, scenario, method="rosenbrock", gradient="forward", throw=False)
            return run.carrier_speed

        traced, _, _ = eqx.filter_make_jaxpr(jax.vmap(speeds))(jnp.ones(2))
        return str(traced).count(" while[")

    assert loops(100.0, 201) == loops(100.0, 301) - 1

    def moving(time):
        return 100.0 * jnp.cos(time)

    assert loops(moving, 64) == loops(moving, 201) - 1
