"""Operating points and duty cycles at their ends: standstill, next to jamming, impossible ones."""

import dataclasses

import equinox as eqx
import jax
import numpy as np
import pytest
from scenes import array, equal_shares

from prsm_jax.dynamics import all_kinematics, jamming_coefficient, self_locking_margin, steady_state
from prsm_jax.friction import CoulombFriction, SpinFriction
from prsm_jax.quantities import compute_checked
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
