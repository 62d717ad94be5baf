"""Settling in closed form, the reduced stages under it, and the choice of the method."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.core import Tracer
from scenes import array, example, mechanism, simulate, stage, thread
from scipy.integrate import solve_ivp

import prsm_jax as prsm
from benchmarks.method_options import taken
from benchmarks.references.transients.dynamics import Chain
from prsm_jax import Scenario
from prsm_jax.dynamics import all_kinematics, carrier_inertia, choose_method, states_at
from prsm_jax.dynamics.forces._reduced_chain import reduced_chain, reduced_rates
from prsm_jax.dynamics.forces._reduced_stage import ReducedStage
from prsm_jax.dynamics.speed_drive import _choose_method
from prsm_jax.dynamics.speed_drive._closed_form import _settled_stage, inverse_path
from prsm_jax.friction import (
    CoulombFriction,
    Drag,
    Friction,
    SplineFriction,
    StribeckFriction,
    ThrustBearingFriction,
    ViscousFriction,
)
from tests.present import present

#: After a while, and long after: 40 time constants of the slowest carrier.
DURATION = 2e-3


def _chain(*laws):
    """One stage for every law of thread friction, in growing sizes, with all other frictions."""
    stages = []
    for index, law in enumerate(laws):
        friction = Friction(
            thread=law,
            spline=SplineFriction(0.1, 12e-3) if index else None,
            thrust_bearing=ThrustBearingFriction(0.005, 20e-3),
            drag=Drag(0.05),
        )
        size = thread(roller_radius=(3.25 + 1.5 * index) * 1e-3)
        stages.append(stage(friction=friction, geometry=size))
    return mechanism(*stages)


COULOMB = _chain(CoulombFriction(0.05), CoulombFriction(0.07), CoulombFriction(0.06))

PAIR = _chain(CoulombFriction(0.05), CoulombFriction(0.07))
SINGLE = _chain(CoulombFriction(0.05))


class _Accelerating(eqx.Module):
    start: jax.Array
    slope: jax.Array

    def __call__(self, time):
        return self.start + self.slope * time


@eqx.filter_jit
def _both_rates(one, speed, slope, load, ratios):
    kinematics = all_kinematics(one)
    inertia = jnp.stack([carrier_inertia(s) for s in one.stages])

    def at(speed, slope, load, ratio):
        carriers = ratio * speed
        scenario = Scenario(_Accelerating(speed, slope), load, array(1.0))
        states = states_at(one, kinematics, scenario, array(0.0), carriers)
        full = jnp.stack([s.forces.carrier_drive for s in states]) / inertia
        chain = reduced_chain(one, kinematics, inertia)
        return full, jnp.stack(reduced_rates(present(chain), speed, slope, load, carriers))

    return jax.vmap(at)(speed, slope, load, ratios)


@pytest.mark.parametrize(
    "one",
    [
        COULOMB,
        _chain(
            StribeckFriction(0.12, 0.05, 0.2, 30.0), ViscousFriction(25.0), CoulombFriction(0.1)
        ),
    ],
    ids=["coulomb", "mixed"],
)
def test_the_scalars_of_a_stage_tell_what_its_vectors_do(one):
    """Driving and driven, accelerating, loads of either sign, away from the steady state."""
    random = np.random.default_rng(2)

    def draw(low, high, *shape):
        return array(random.uniform(low, high, (200, *shape)))

    full, reduced = _both_rates(
        one, draw(-200, 200), draw(-1e4, 1e4), draw(-1e4, 1e4), draw(0.0, 0.6, 3)
    )
    # Where the slip along d nearly vanishes both are the difference of large numbers.
    scale = jnp.max(jnp.abs(full), axis=0, keepdims=True)
    assert jnp.max(jnp.abs(reduced - full) / scale) < 1e-13


@pytest.mark.parametrize("share", [-3.0, 0.0, 0.3, 0.9, 0.99, 0.9999])
def test_the_path_is_inverted_to_rounding(share):
    """x of P(x) − share x, over all slips from e⁻⁶⁰ to e⁶ times that across."""
    x = jnp.linspace(-60.0, 6.0, 2001)
    root = jnp.sqrt(1 + jnp.exp(2 * x))
    value = root + x - jnp.log1p(root) - share * x
    found = jax.jit(jax.vmap(inverse_path, (0, None)))(value, array(share))
    # The slope is 1 − share where the mechanism nearly locks, and amplifies rounding as much.
    allowed = 1e-15 / (1 - share) * jnp.maximum(1.0, jnp.abs(x))
    assert jnp.all(jnp.abs(found - x) <= 4 * allowed)


@eqx.filter_jit
def _settle(one, speed, load, ratio, method):
    def at(speed, load, ratio):
        run = prsm.simulate(
            one,
            Scenario(speed, load, array(DURATION), ratio, samples=21),
            method=method,
            gradient="forward",
            **taken(method, rtol=1e-12, atol=1e-14, max_steps=20_000),
            throw=False,
        )
        return run.carrier_ratio, run.solver.code

    return jax.vmap(at)(speed, load, ratio)


@pytest.mark.parametrize("rolls", [True, False])
@pytest.mark.parametrize("coefficient", [0.999, 1.0, 1.001])
def test_a_thread_at_the_limit_of_locking_is_told_and_finite(coefficient, rolls):
    """At μ L/2π = q |n_z| exactly, with and without slip along the roller's path."""
    lengths = {"along": 4e-3, "drive": 2.0**-6, "contact_radius": 1e-2, "normal_moment": 1e-3}
    # Powers of two, so that friction takes all of the normal force to the last digit.
    limit = {"across": 2.0**-8, "axial": 2.0**-9, "normal_axial": 0.5}
    reduced = ReducedStage(**{name: array(value) for name, value in (lengths | limit).items()})
    one = stage(friction=Friction(thread=CoulombFriction(coefficient)))
    start = lengths["along"] / lengths["drive"] if rolls else 0.3

    @jax.jit
    def settled(ratio, speed):
        return _settled_stage(one, reduced, array(1e-4), speed, ratio, array(500.0), array(1e-3))

    ratio, torque, carries = settled(array(start), array(100.0))
    assert bool(carries) == (coefficient < 1)
    assert np.isfinite([ratio, torque]).all()
    slopes = jax.jacfwd(lambda *x: settled(*x)[:2], argnums=(0, 1))(array(start), array(100.0))
    assert np.isfinite(np.asarray(jax.tree.leaves(slopes))).all()


def test_closed_form_and_integration_agree():
    """Three stages in a chain: impulses of torque and load go from each to the next."""
    speed = array([100.0, -100.0, 30.0, 100.0, 1e3, 100.0])
    load = array([7000.0, 7000.0, -4000.0, 7000.0, 7000.0, 1e-3])
    ratio = array([0.0, 0.3, 0.33, 0.8, -0.5, 0.1])
    exact, code = _settle(COULOMB, speed, load, ratio, "closed_form")
    integrated, _ = _settle(COULOMB, speed, load, ratio, "rosenbrock")
    assert not code.any()
    # The integrator's own error: a thousand steps with a relative tolerance of 1e-12.
    assert jnp.max(jnp.abs(exact - integrated)) < 3e-11


def test_closed_form_against_scipy():
    """A right-hand side in plain Python, with a meshing of its own in many digits."""
    two, duration = example("li2020_two_stage"), 1e-3
    scenario = Scenario(array(100.0), array(7000.0), array(duration), samples=41)
    run = simulate(two, scenario, method="closed_form")
    assert int(run.solver.code) == 0
    expected = solve_ivp(
        Chain(two, 100.0, 7000.0).rate,
        (0.0, duration),
        [0.0, 0.0],
        method="DOP853",
        t_eval=np.linspace(0.0, duration, 41),
        rtol=3e-14,
        atol=1e-15,
    )
    # The integrator's own error: some hundred steps with a relative tolerance of 3e-14.
    assert np.max(np.abs(run.carrier_ratio - expected.y)) < 5e-12


def test_what_does_not_move_and_what_has_settled():
    """Frictionless carriers coast; settled ones stay; at standstill nothing moves; all finite."""
    free = prsm.set_parameter(COULOMB, "stage.friction.thread.coefficient", 0.0)
    ones = jnp.ones(2)
    coasting, code = _settle(free, 100.0 * ones, 7000.0 * ones, array([0.2, 0.5]), "closed_form")
    assert not code.any()
    np.testing.assert_allclose(coasting, np.asarray(coasting)[:, :, :1] + np.zeros(21), atol=1e-15)
    steady = prsm.steady_state(COULOMB, 100.0, 7000.0).carrier_ratio
    runs, code = _settle(
        COULOMB, array([100.0, 0.0]), array([7000.0, 0.0]), array([steady[0], 0.0]), "closed_form"
    )
    assert not code.any()
    np.testing.assert_allclose(runs[0, 0], steady[0], rtol=1e-15)
    assert jnp.all(jnp.isfinite(runs))


def test_next_to_no_load_moves_carriers_in_proportion():
    """Carriers at rest, at loads of 1e-9 and 1e-12 N: what they have reached, to rounding."""
    loads = array([1e-9, 1e-12])
    runs, code = _settle(COULOMB, 100.0 * jnp.ones(2), loads, jnp.zeros(2), "closed_form")
    assert not code.any()
    # Of the last stage, whose nut carries nothing else.
    per_load = np.asarray(runs)[:, -1, 1:] / np.asarray(loads)[:, None]
    assert np.all(per_load > 0)
    np.testing.assert_allclose(per_load[1], per_load[0], rtol=1e-10)
    # And in proportion to the time: the direction of slip has hardly changed.
    np.testing.assert_allclose(per_load[0], per_load[0, 0] * np.arange(1, 21), rtol=1e-9)


def test_a_torque_that_changes_its_sign_is_seen():
    """Near self-locking a driven screw first has to be pushed, then holds back."""
    ends, coefficients = [], jnp.linspace(0.02, 0.4, 20)
    for coefficient in coefficients:
        one = prsm.set_parameter(COULOMB, "stage.friction.thread.coefficient", coefficient)
        _, code = _settle(
            one, array([-100.0, 100.0]), array([7000.0, 7000.0]), jnp.zeros(2), "closed_form"
        )
        ends.append(np.asarray(code))
    backward, forward = np.array(ends).T
    assert not forward.any()
    assert set(backward) == {0, 6}
    first = coefficients[int(np.argmax(backward))]
    one = prsm.set_parameter(COULOMB, "stage.friction.thread.coefficient", first)
    scenario = Scenario(-100.0, 7000.0, DURATION, samples=21)
    choice = choose_method(one, scenario)
    assert choice.method == "rosenbrock"
    assert "sign" in choice.reason


def test_derivatives_of_the_closed_form():
    """Forward and reverse against central differences, by friction, lead, speed, and load."""

    def ratio(numbers):
        one = prsm.set_parameter(PAIR, "stage.friction.thread.coefficient", 0.06 * numbers[0])
        one = prsm.set_parameter(one, "lead", 1e-2 * numbers[1])
        scenario = Scenario(100 * numbers[2], 7e3 * numbers[3], array(2e-4), samples=2)
        run = prsm.simulate(one, scenario, method="closed_form", throw=False)
        # Only the first stage, which depends on everything that the second does.
        return run.carrier_ratio[0, 1]

    @jax.jit
    def everything(at, moved):
        _, slope = jax.vmap(lambda d: jax.jvp(ratio, (at,), (d,)))(jnp.eye(4))
        return slope, jax.grad(ratio)(at), jax.lax.map(ratio, moved)

    at, step = jnp.ones(4), 1e-5
    rows = jnp.concatenate([at[None] + step * jnp.eye(4), at[None] - step * jnp.eye(4)])
    forward, reverse, values = everything(at, rows)
    np.testing.assert_allclose(reverse, forward, rtol=1e-11)
    differences = (values[:4] - values[4:]) / (2 * step)
    assert np.all(np.abs(differences) > 1e-3)
    # Rounding of the difference, 1e-16 over the step.
    np.testing.assert_allclose(forward, differences, rtol=1e-7, atol=1e-10)


def test_the_method_is_chosen_by_the_scene():
    """What is algebra is not integrated, and what is not traced is looked at."""
    constant = Scenario(100.0, 7000.0, DURATION, samples=21)
    assert choose_method(SINGLE, constant).method == "closed_form"
    viscous = _chain(ViscousFriction(25.0))
    assert choose_method(viscous, constant).method == "rosenbrock"

    slow = Scenario(lambda t: 100 * jnp.sin(10 * t), 7000.0, 1.0, samples=21)
    assert choose_method(SINGLE, slow, rtol=1e-6).method == "quasi_steady"
    quick = Scenario(lambda t: 100 + 10 * jnp.sin(1e4 * t), 7000.0, DURATION, samples=21)
    assert choose_method(SINGLE, quick).method == "rosenbrock"
    names = []

    @jax.jit
    def traced(load):
        run = prsm.simulate(SINGLE, Scenario(lambda t: 100 + t, load, 1.0, samples=2), throw=False)
        names.append(run.solver.name)
        return run.carrier_ratio

    jax.eval_shape(traced, array(7000.0))
    assert names == ["RODASP"]


def test_closed_form_says_what_it_needs():
    with pytest.raises(ValueError, match=r"closed_form.*constant speed and load"):
        prsm.simulate(SINGLE, Scenario(lambda t: 1 + t, 1.0, 1.0), method="closed_form")


def test_the_method_is_chosen_in_compiled_programs(monkeypatch):
    """Not one operation after the other, each compiled by itself: that takes a minute."""
    traced = []

    def kinematics(mechanism):
        traced.append(isinstance(mechanism.stages[0].thread.lead, Tracer))
        return all_kinematics(mechanism)

    monkeypatch.setattr(_choose_method, "all_kinematics", kinematics)
    # A number of samples of its own, so that nothing is compiled already.
    choose_method(SINGLE, Scenario(100.0, 7000.0, DURATION, samples=23))
    assert traced == [True]
