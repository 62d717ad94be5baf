"""Operating points and duty cycles at their ends: standstill, next to jamming, impossible ones."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scenes
from scenes import array, equal_shares

from prsm_jax.dynamics import all_kinematics, jamming_coefficient, self_locking_margin, steady_state
from prsm_jax.friction import CoulombFriction, Drag, Friction, SpinFriction, SplineFriction
from prsm_jax.mechanism import DutyCycle, Roller
from prsm_jax.programs import to_precision
from prsm_jax.quantities import compute, compute_checked
from prsm_jax.sweeps import sweep
from tests.present import present

_NAMES = ("efficiency_forward", "efficiency_backward", "static_safety", "dn_value")


def _mechanism(coefficient=0.06, spin=None):
    mechanism = equal_shares("actuator")
    (stage,) = mechanism.stages
    friction = dataclasses.replace(
        present(stage.friction),
        thread=CoulombFriction(coefficient),
        spin=spin,
        rolling_hysteresis=None,
    )
    stage = dataclasses.replace(stage, friction=friction)
    return dataclasses.replace(mechanism, stages=(stage,))


_checked = eqx.filter_jit(lambda mechanism: compute_checked(mechanism, _NAMES))


def _changed(path, value):
    return eqx.tree_at(path, _mechanism(), replace_fn=lambda old: 0 * old + value)


def test_both_efficiencies_at_standstill():
    """Coulomb friction does not depend on the speed: those of the motion about to begin."""
    moving, _ = _checked(_mechanism())
    still, valid = _checked(_changed(lambda m: m.operating_point.speed, 0.0))
    assert bool(valid)
    for name in _NAMES[:2]:
        assert float(still[name]) == pytest.approx(float(moving[name]), rel=1e-13), name
    assert float(still["efficiency_backward"]) < float(still["efficiency_forward"])


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (lambda m: m.operating_point.load, np.inf),
        (lambda m: m.duty_cycle.load, np.inf),
        (lambda m: m.duty_cycle.duration, 0.0),
        (lambda m: m.duty_cycle.duration, -1.0),
    ],
    ids=["infinite load", "infinite load in the cycle", "no time", "negative time"],
)
def test_what_cannot_be_is_told(path, value):
    _, valid = _checked(_changed(path, value))
    assert not bool(valid)


def test_bearing_loss_next_to_jamming():
    """It follows from the load; thread friction, however large, does not change it."""
    mechanism = _mechanism()
    limit = jamming_coefficient(all_kinematics(mechanism)[0])

    def loss(coefficient):
        moved = eqx.tree_at(
            lambda m: m.stages[0].friction.thread.coefficient, mechanism, coefficient
        )
        return steady_state(moved).losses["thrust_bearing"]

    value, slope = jax.jit(jax.value_and_grad(loss))(limit * (1 - 1e-9))
    assert float(value) == pytest.approx(float(loss(array(0.06))), rel=1e-14)
    assert float(slope) == 0


def test_a_locking_limit_beyond_the_balance_of_the_carriers_is_not_found():
    """With 32 times the friction spin holds the rollers, which so little of it cannot drive."""

    @eqx.filter_jit
    def margin(mechanism):
        point, kinematics = mechanism.operating_point, all_kinematics(mechanism)
        return self_locking_margin(mechanism, kinematics, point.speed, point.load)

    _, found = margin(_mechanism(0.06, SpinFriction(0.05)))
    assert bool(found)
    value, found = margin(_mechanism(1e-6, SpinFriction(0.05)))
    assert not bool(found)
    assert np.isfinite(float(value))


def test_an_impossible_number_does_not_hide_that_nothing_balances():
    """Rolling losses far past what the threads can drive, by a loss factor that no steel has."""
    (stage,) = equal_shares("actuator").stages
    friction = dataclasses.replace(
        present(stage.friction), thread=CoulombFriction(1e-3), spin=SpinFriction(0.06)
    )
    mechanism = dataclasses.replace(
        equal_shares("actuator"), stages=(dataclasses.replace(stage, friction=friction),)
    )
    found = steady_state(
        eqx.tree_at(
            lambda m: m.stages[0].friction.rolling_hysteresis.loss_factor,
            mechanism,
            array(2.0),
        )
    )
    assert found.result_name == "impossible_dimension"
    assert not bool(found.solved)
    assert not bool(found.computed)
    assert bool(steady_state(mechanism).computed)


@pytest.mark.parametrize("name", ["wu2022", "li2021_two_stage", "recirculating_stage"])
@pytest.mark.parametrize("speed", [100.0, 0.0])
def test_derivatives_without_a_load(name, speed):
    """All forces are proportional to the load, and the efficiency does not depend on it."""
    mechanism = _with_coulomb_friction_alone(name)

    def at(load):
        state = steady_state(mechanism, speed, load)
        forces = state.drive_torque, state.nut_load[0], state.contact_force[0]
        others = state.screw_roller_axial_force[-1], sum(state.losses.values())
        return jnp.stack([state.efficiency, *forces, *others, state.spline_friction[-1]])

    unloaded, loaded = np.asarray(at(0.0)), np.asarray(at(1e3))
    assert unloaded[0] == pytest.approx(loaded[0], rel=1e-14)
    assert (unloaded[1:] == 0).all()
    for of in (jax.jacfwd, jax.jacrev):
        slopes = np.asarray(jax.jit(of(at))(0.0))
        assert slopes[0] == 0.0
        # Forces over the load, by Euler's theorem.
        np.testing.assert_allclose(slopes[1:], loaded[1:] / 1e3, rtol=1e-13, atol=1e-18)


def _with_coulomb_friction_alone(name):
    mechanism = equal_shares(name)
    stages = tuple(
        dataclasses.replace(
            stage,
            friction=Friction(
                thread=CoulombFriction(0.08), spline=SplineFriction(0.1, 12e-3) if later else None
            ),
        )
        for later, stage in enumerate(mechanism.stages)
    )
    return dataclasses.replace(mechanism, stages=stages)


@pytest.mark.parametrize("speed", [100.0, -100.0])
@pytest.mark.parametrize("name", ["recirculating_stage", "differential_stage", "wu2022"])
def test_without_a_load_no_thread_jams_or_locks(name, speed):
    """Either direction has the efficiency of a driving screw, (1 − μ)/(1 + μ) at 45°."""
    mechanism = _with_coulomb_friction_alone(name)
    state = steady_state(mechanism, speed, 0.0)
    assert state.result_name == "successful"
    # To O(λ²).
    assert state.efficiency == pytest.approx(0.92 / 1.08, abs=2e-3)
    driving = steady_state(mechanism, speed, np.sign(speed) * 1e3)
    assert state.efficiency == pytest.approx(float(driving.efficiency), rel=1e-14)
    # With the load about to drive, the other limit.
    back = steady_state(mechanism, speed, 0.0, onset=-1.0)
    driven = steady_state(mechanism, speed, -np.sign(speed) * 1e3)
    assert back.efficiency == pytest.approx(float(driven.efficiency), rel=1e-14)


def test_jamming_without_a_load():
    """Beyond cot 45° the recirculating screw jams, whatever the load."""
    jammed = eqx.tree_at(
        lambda m: m.stages[0].friction.thread.coefficient,
        equal_shares("recirculating_stage"),
        array(1.5),
    )
    for load in (1e3, 0.0):
        assert steady_state(jammed, 100.0, load).result_name == "jammed"


@pytest.mark.parametrize("dtype", [jnp.float64, jnp.float32])
@pytest.mark.parametrize("name", ["actuator", "humanoid_leg", "recirculating_stage"])
def test_drag_without_a_load_is_the_same_in_both_directions(name, dtype):
    """Without a load M Ω goes into the screw, none comes out, and no thread bears a force."""
    mechanism = to_precision(_with_drag(name, 0.02), dtype)
    for speed in (50.0, -50.0, 0.0):
        state = steady_state(mechanism, jnp.asarray(speed, dtype), jnp.asarray(0.0, dtype))
        assert state.result_name == "successful"
        assert state.drive_torque == pytest.approx(np.sign(speed + 0.1) * 0.02, rel=1e-6)
        assert state.input_power == pytest.approx(abs(speed) * 0.02, rel=1e-6)
        for number in (state.efficiency, state.output_power, state.nut_load[0]):
            assert float(number) == 0
        assert float(state.contact_force[0]) == float(state.screw_roller_axial_force[0]) == 0
        assert {name for name, power in state.losses.items() if float(power)} <= {"drag"}


def test_derivatives_with_drag_and_without_a_load():
    """F_n, M and η per newton: of forces in proportion, L/2π over the drag for η."""
    mechanism = _with_drag("recirculating_stage", 0.02)
    travel = float(mechanism.stages[0].thread.lead) / (2 * np.pi)

    def at(load, of=mechanism):
        state = steady_state(of, 100.0, load)
        return jnp.stack([state.contact_force[0], state.drive_torque, state.efficiency])

    force, torque, _ = np.asarray(at(1e3, _with_coulomb_friction_alone("recirculating_stage")))
    slopes = jax.jacfwd(at)(0.0)
    np.testing.assert_allclose(slopes, [force / 1e3, torque / 1e3, travel / 0.02], rtol=1e-12)


def test_a_return_without_a_load_takes_energy():
    """Out under 4 kN, back under none, against drag alone: η = M₀/(M₀ + 2 T), M₀ = F L/2π."""
    mechanism = _with_drag("actuator", 0.2, coefficient=0.0)
    duty = DutyCycle(duration=array([2.0, 2.0]), speed=[30.0, -30.0], load=[4e3, 0.0])
    moment = 4e3 * float(mechanism.stages[0].thread.lead) / (2 * np.pi)
    found = compute(dataclasses.replace(mechanism, duty_cycle=duty), ["duty_efficiency"])
    assert float(found["duty_efficiency"]) == pytest.approx(moment / (moment + 0.4), rel=1e-12)


def test_a_sweep_through_no_load_names_no_locked_thread():
    """(speed, load): drag takes M Ω at load 0 and leaves no output, in either direction."""
    axes = {"speed": [-30.0, 30.0], "load": [-4e3, 0.0, 4e3]}
    data = sweep(_with_drag("actuator", 0.2), axes, ["efficiency", "drive_torque"])
    efficiency, torque = data["efficiency"].values, data["drive_torque"].values
    assert efficiency[:, 1].tolist() == [0.0, 0.0]
    np.testing.assert_allclose(torque[:, 1], [-0.2, 0.2], rtol=1e-12)
    # A half turn about a radial axis changes the sign of both.
    np.testing.assert_allclose(efficiency, efficiency[::-1, ::-1], rtol=1e-14)
    assert not data["failed"].any()


def _with_drag(name, torque, coefficient=0.08):
    mechanism = equal_shares(name)
    (stage,) = mechanism.stages
    friction = Friction(thread=CoulombFriction(coefficient), drag=Drag(torque))
    return dataclasses.replace(mechanism, stages=(dataclasses.replace(stage, friction=friction),))


@pytest.mark.parametrize("name", ["wu2022", "actuator"])
def test_single_precision_without_a_load(name):
    """The stand-in for a load of 0 does not underflow: values and slopes are finite."""
    # Drag would be the larger part of every torque.
    mechanism64 = eqx.tree_at(
        lambda m: m.stages[0].friction.drag, equal_shares(name), None, is_leaf=lambda x: x is None
    )
    mechanism = to_precision(mechanism64, jnp.float32)
    loads = jnp.asarray([0.0, 1e-35, 1e-25, 1e-13, 1e-6], jnp.float32)

    def at_load(of, lead, load=1e3):
        moved = eqx.tree_at(lambda m: m.stages[0].thread.lead, of, lead)
        return steady_state(moved, jnp.asarray(100.0, lead.dtype), load)

    def at(lead, load):
        state = at_load(mechanism, lead, load)
        return state.efficiency, state.valid

    lead = mechanism.stages[0].thread.lead
    both = jax.vmap(jax.value_and_grad(at, has_aux=True), (None, 0))
    (values, valid), slopes = jax.jit(both)(lead, loads)
    assert values.dtype == jnp.float32
    assert np.isfinite(values).all()
    assert np.isfinite(slopes).all()
    assert valid.all()
    if name == "wu2022":
        # The two terms of the slope cancel to a hundredth: rounding of 6e-8 becomes 1e-5 or more.
        of = lambda x: at_load(mechanism64, x).efficiency  # noqa: E731
        exact = jax.grad(of)(mechanism64.stages[0].thread.lead)
        np.testing.assert_allclose(slopes, float(exact), rtol=1e-2)


@pytest.mark.parametrize("name", ["wu2022", "actuator"])
@pytest.mark.parametrize(
    ("speed", "load", "coefficient"),
    [
        (np.nan, 1e3, 0.05),
        (100.0, np.nan, 0.05),
        (100.0, np.inf, 0.05),
        (100.0, 1e3, np.nan),
    ],
)
def test_what_is_not_finite_is_not_called_a_lack_of_balance(name, speed, load, coefficient):
    mechanism = eqx.tree_at(
        lambda m: m.stages[0].friction.thread.coefficient,
        equal_shares(name),
        jnp.asarray(coefficient),
    )
    state = scenes.steady_state(mechanism, speed, load)
    assert state.result_name == "not_finite"
    assert not bool(state.valid)


def test_a_roller_of_unknown_density_has_no_centripetal_force():
    """A length without a density is no mass; forces are those of a roller without length."""
    mechanism = equal_shares("wu2022")
    (stage,) = mechanism.stages
    without = dataclasses.replace(
        stage,
        roller=Roller(length=0.04),
        material=dataclasses.replace(present(stage.material), density=None),
    )
    states = [
        scenes.steady_state(dataclasses.replace(mechanism, stages=(one,)))
        for one in (without, dataclasses.replace(without, roller=Roller()))
    ]
    assert float(states[0].carrier_force[0]) == float(states[1].carrier_force[0]) > 0
