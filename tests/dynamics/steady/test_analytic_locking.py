"""Jamming and self-locking: limits in closed form, margins that are zero where it happens."""

import equinox as eqx
import jax
import numpy as np
import pytest
from scenes import (
    ALL_LOSSES,
    FIRST_STAGE_LOSSES,
    array,
    example,
    mechanism,
    simulate,
    stage,
    steady_state,
    thread,
)

import prsm_jax as prsm
from prsm_jax.friction import CoulombFriction, Friction
from prsm_jax.quantities import compute_checked
from tests.present import present

COEFFICIENT = "friction.thread.coefficient"
NAMES = (
    "jamming_margin",
    "self_locking_margin",
    "critical_friction_coefficient",
    "jamming_friction_coefficient",
)


def _one(coefficient, degrees=60.0):
    geometry = thread(contact_angle=np.radians(degrees))
    return mechanism(
        stage(friction=Friction(thread=CoulombFriction(coefficient)), geometry=geometry)
    )


@eqx.filter_jit
def _margins(one):
    return compute_checked(one, NAMES)


@pytest.mark.parametrize("degrees", [30.0, 45.0, 60.0])
def test_limits_of_one_stage(degrees):
    """μ_lock → tan α and μ_jam → cot α for small leads; exactly, the steady state changes there."""
    found, valid = _margins(_one(0.05, degrees))
    lock = float(found["critical_friction_coefficient"][0])
    jam = float(found["jamming_friction_coefficient"][0])
    assert bool(valid)
    flank = np.radians(90.0 - degrees)
    # The lead angle is 11.3° here: tan² of it is 0.04.
    assert lock == pytest.approx(np.tan(flank), rel=0.04)
    assert jam == pytest.approx(1 / np.tan(flank), rel=0.04)
    assert float(found["self_locking_margin"]) == pytest.approx(1 - 0.05 / lock, rel=1e-14)
    assert float(found["jamming_margin"]) == pytest.approx(1 - 0.05 / jam, rel=1e-14)
    back = steady_state(_one(lock, degrees), -100.0)
    assert abs(float(back.efficiency)) < 1e-14
    for side, code in ((1 - 1e-9, 0), (1 + 1e-9, 1)):
        assert int(present(steady_state(_one(lock * side, degrees), -100.0).code)) == code
    for side, code in ((1 - 1e-9, 0), (1 + 1e-9, 2)):
        assert int(present(steady_state(_one(jam * side, degrees), 100.0).code)) == code


def test_the_stage_that_is_closest_to_jamming_counts():
    """1 − μ/μ_jam of two stages, whichever of them comes first."""
    for first, second in ((0.05, 0.2), (0.2, 0.05)):
        stages = [
            stage(friction=Friction(thread=CoulombFriction(one)), geometry=thread())
            for one in (first, second)
        ]
        found, _ = _margins(mechanism(*stages))
        limits = np.asarray(found["jamming_friction_coefficient"])
        expected = 1 - 0.2 / limits[np.argmax([first, second])]
        assert float(found["jamming_margin"]) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("factor", [0.5, 15.0, 30.0])
def test_factor_of_all_friction_of_two_stages(factor):
    """With spline and bearing: at the factor that the margin tells the load is just held."""
    two = example("li2020_two_stage")
    two = prsm.set_parameter(two, COEFFICIENT, 0.05 * factor)
    found, valid = _margins(two)
    margin = float(found["self_locking_margin"])
    assert bool(valid)
    for name in (COEFFICIENT, "friction.spline.coefficient", "friction.thrust_bearing.coefficient"):
        for number in (1, 2):
            path = f"stage.{number}.{name}"
            try:
                now = prsm.get_parameter(two, path)
            except prsm.PrsmError:
                continue
            two = prsm.set_parameter(two, path, now / (1 - margin))
    assert abs(float(steady_state(two, -100.0).efficiency)) < 1e-10
    assert (margin > 0) == (factor < 20)


def test_a_load_that_no_friction_holds_has_no_margin():
    """Only the first of two stages has friction, and the second one goes on turning the screw."""
    two = mechanism(stage(), stage(friction=Friction(), geometry=thread(5e-3)))
    for factor in (1.0, 1e3, 1e6):
        held = prsm.set_parameter(two, "stage.1." + COEFFICIENT, 0.05 * factor)
        assert float(steady_state(held, -100.0).efficiency) > 0.008
    found, valid = _margins(two)
    assert not bool(valid)
    assert np.isfinite(float(found["self_locking_margin"]))


def test_every_loss_takes_part():
    losses = mechanism(
        stage(friction=FIRST_STAGE_LOSSES), stage(friction=ALL_LOSSES, geometry=thread(5e-3))
    )
    threads = Friction(thread=CoulombFriction(0.06))
    plain = mechanism(stage(friction=threads), stage(friction=threads, geometry=thread(5e-3)))
    with_losses, valid = _margins(losses)
    alone, _ = _margins(plain)
    assert bool(valid)
    assert 0 < float(with_losses["self_locking_margin"]) < float(alone["self_locking_margin"])


def test_derivatives_are_finite_at_the_limits():
    """Forward and reverse, against 1/μ: the margins are straight lines in the coefficient."""

    def margin(coefficient, name):
        return prsm.compute(prsm.set_parameter(_one(0.5), COEFFICIENT, coefficient), [name])[name]

    found, _ = _margins(_one(0.5))
    for name, limit in (
        ("self_locking_margin", float(found["critical_friction_coefficient"][0])),
        ("jamming_margin", float(found["jamming_friction_coefficient"][0])),
    ):
        for transform in (jax.jacfwd, jax.jacrev):
            slope = jax.jit(transform(margin), static_argnums=1)(array(limit), name)
            assert float(slope) == pytest.approx(-1 / limit, rel=1e-12)


def test_a_jammed_transient_says_so():
    run = simulate(
        _one(1.8), prsm.Scenario(array(100.0), array(7e3), array(1e-3), samples=3), max_steps=64
    )
    assert int(run.solver.code) == 7
    assert run.solver.result.startswith("jammed")
    assert "jamming_margin" in run.solver.result
    assert steady_state(_one(1.8), 100.0).result.startswith("jammed")
    assert steady_state(_one(0.7), -100.0).result.startswith("self-locking")
    assert steady_state(_one(0.05), 100.0).result == "successful"


@pytest.mark.parametrize("load", [np.inf, np.nan])
def test_a_load_that_is_no_number_is_named_before_the_jamming(load):
    """The number has to be corrected first, whatever the thread would do under a real load."""
    found = steady_state(_one(1.8), 100.0, load)
    assert found.result.startswith("not finite")
    assert not bool(found.valid)


def test_findings():
    names = {c: [(f.name, f.severity) for f in prsm.check(_one(c))] for c in (0.05, 0.55, 0.7, 1.8)}
    friction = {
        c: [found for found in names[c] if found[0] in ("jamming", "self_locking")] for c in names
    }
    assert friction == {
        0.05: [],
        0.55: [("self_locking", "warning")],
        0.7: [("self_locking", "note")],
        1.8: [("jamming", "error"), ("self_locking", "note")],
    }
