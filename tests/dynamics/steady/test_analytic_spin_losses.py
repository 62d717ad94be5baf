"""What spin adds to the loss of the screw side, by the whole toolkit.

The coefficient of `[stage.friction.spin]` is that of the nut side: at 0 the loss `spin` is that of
the screw side alone.
"""

import math

import numpy as np
import pytest
from scenes import array, mechanism, stage, steady_state, thread

import prsm_jax as prsm
from prsm_jax.dynamics.friction._law_inputs import Slip
from prsm_jax.dynamics.friction._rubbing import Rubbing, friction_on_roller, rubbed_moment
from prsm_jax.dynamics.friction._thread_friction import slip_direction, thread_friction
from prsm_jax.friction import (
    CoulombFriction,
    Friction,
    LuGreFriction,
    RegularisedCoulombFriction,
    SpinFriction,
    StribeckFriction,
    ViscousFriction,
)
from prsm_jax.mechanism import Material
from prsm_jax.numerics import cube_root_or_zero

COEFFICIENT = 0.05


def _screw_side(roller_count, engaged_threads, geometry, load, coefficient=0.0):
    """A steady state with spin, and what spin adds to the sliding loss of the screw side."""
    one = mechanism(
        stage(
            roller_count=roller_count,
            engaged_threads=array(engaged_threads),
            geometry=geometry,
            material=Material(array(210e9), array(0.3), array(7850.0)),
            friction=Friction(
                thread=CoulombFriction(array(COEFFICIENT)), spin=SpinFriction(array(coefficient))
            ),
        )
    )
    found = steady_state(one, 100.0, load)
    sliding = COEFFICIENT * roller_count * found.contact_force[0] * found.slip_speed[0]
    screw_side = found.losses["thread_sliding"] + found.losses["spin"]
    return found, float(screw_side / sliding - 1)


def test_first_stage_of_li_2020():
    """0.12 % of the sliding loss at 7 kN, if 20 threads of a roller share the load.

    The paper gives no number of threads; the shipped example assumes 15, and 0.146 % follow.
    """
    geometry = thread(array(3.25e-3), array(10e-3), array(np.pi / 4), array(5.0))
    found, added = _screw_side(7, 20.0, geometry, 7e3)
    assert added == pytest.approx(0.0012, abs=5e-5)
    assert found.valid
    _, fewer = _screw_side(7, 15.0, geometry, 7e3)
    assert fewer == pytest.approx(0.00146, abs=5e-6)
    # Friction along the slip falls by about as much as spin adds in all.
    assert found.losses["spin"] / found.losses["thread_sliding"] == pytest.approx(
        2 * added, rel=0.02
    )


def test_a_screw_of_30_by_5_mm():
    """0.52 % at 20 kN with 10 rollers and 51 threads of 1 mm: 0.6 of a catalogue nut of 85 mm.

    Threads carry equal loads; added is proportional to (rollers × threads)^(−2/3).
    """
    geometry = thread(array(5e-3), array(5e-3), array(np.pi / 4), array(5.0))
    found, added = _screw_side(10, 51.0, geometry, 20e3)
    assert added == pytest.approx(0.0052, abs=7e-5)
    assert found.power_balance_residual < 1e-13
    # Spin of the nut side is that of pure spin: it weighs far more.
    both, _ = _screw_side(10, 51.0, geometry, 20e3, COEFFICIENT)
    assert both.losses["spin"] > 4 * found.losses["spin"]
    assert both.power_balance_residual < 1e-13
    assert both.efficiency < found.efficiency


def test_spin_of_the_screw_side_takes_from_sliding_and_brakes_the_carriers():
    """Less friction along the slip than without spin, and rollers that turn more slowly."""
    geometry = thread(array(5e-3), array(5e-3), array(np.pi / 4), array(5.0))
    found, _ = _screw_side(10, 51.0, geometry, 20e3)
    alone = Friction(thread=CoulombFriction(array(COEFFICIENT)))
    without = steady_state(mechanism(stage(geometry=geometry, friction=alone)), 100.0, 20e3)
    assert found.carrier_ratio[0] < without.carrier_ratio[0]
    assert found.losses["thread_sliding"] < without.losses["thread_sliding"]


@pytest.mark.parametrize("speed", [0.0, 1e-3, 0.02, 3.0])
def test_every_law_rubs_by_the_mean_local_speed(speed):
    """The coefficient of each law in closed form, and the moment μ F m + c m_v."""
    static, sliding, transition, width, viscous = 0.2, 0.05, 0.015, 0.01, 40.0
    changing = {
        "static_coefficient": array(static),
        "coefficient": array(sliding),
        "stribeck_speed": array(transition),
    }
    falling = sliding + (static - sliding) * math.exp(-((speed / transition) ** 2))
    bristles = {"bristle_stiffness": array(1e5), "bristle_damping": array(10.0)}
    cases = [
        (CoulombFriction(array(sliding)), sliding, 0.0),
        (
            RegularisedCoulombFriction(array(sliding), array(width)),
            sliding * speed / math.hypot(speed, width),
            0.0,
        ),
        (ViscousFriction(array(viscous)), 0.0, viscous),
        (StribeckFriction(**changing), falling, 0.0),
        (StribeckFriction(**changing, viscous_coefficient=array(viscous)), falling, viscous),
        (LuGreFriction(**changing, **bristles), falling, 0.0),
    ]
    along = array([0.6, 0.0, 0.8])
    rub = Rubbing(along, array(2e-4), array(speed), array(3e-7))
    slip = array([0.01, -0.02, 0.03])
    for law, coefficient, damping in cases:
        moment = float(rubbed_moment(law, rub, array(500.0)))
        expected = coefficient * 500.0 * 2e-4 + damping * 3e-7
        assert moment == pytest.approx(expected, rel=1e-13, abs=1e-300), law
        rubbed = stage(friction=Friction(thread=law))
        moving = Slip(slip, along, array(1.0), array(0.3))
        per_force, constant = friction_on_roller(rubbed, moving, None, rub, {})
        np.testing.assert_allclose(per_force, coefficient * along, rtol=1e-13)
        np.testing.assert_allclose(constant, damping * slip, rtol=1e-13)


def test_every_law_in_closed_form_along_the_slip():
    """Force per normal force and beside it, at 5.4 cm/s; and the size of an ellipse, F^{1/3}."""
    static, sliding, transition, width, viscous = 0.2, 0.05, 0.05, 0.03, 40.0
    slip = np.array([0.02, -0.03, 0.04])
    speed = float(np.sqrt(slip @ slip))
    falling = sliding + (static - sliding) * math.exp(-((speed / transition) ** 2))
    changing = (array(static), array(sliding), array(transition))
    cases = [
        (None, 0.0, 0.0),
        (CoulombFriction(array(sliding)), sliding, 0.0),
        (
            RegularisedCoulombFriction(array(sliding), array(width)),
            sliding * speed / math.hypot(speed, width),
            0.0,
        ),
        (ViscousFriction(array(viscous)), 0.0, viscous),
        (StribeckFriction(*changing), falling, 0.0),
        (StribeckFriction(*changing, array(viscous)), falling, viscous),
        (LuGreFriction(*changing, array(1e5), array(10.0)), falling, 0.0),
    ]
    along = slip_direction(array(slip))
    np.testing.assert_allclose(along, slip / speed, rtol=1e-15)
    for law, coefficient, damping in cases:
        per_force, constant = thread_friction(law, array(slip), along)
        np.testing.assert_allclose(per_force, coefficient * slip / speed, rtol=1e-13)
        np.testing.assert_allclose(constant, damping * slip, rtol=1e-13)
    sizes = [float(cube_root_or_zero(array(abs(force)))) for force in (0.0, 8.0, -27.0, 1e-9)]
    np.testing.assert_allclose(sizes, [0.0, 2.0, 3.0, 1e-3], rtol=1e-14)


@pytest.mark.parametrize(
    ("law", "spin", "told"),
    [
        (CoulombFriction(0.05), 0.05, None),
        (CoulombFriction(0.05), None, None),
        (None, 0.05, None),
        (CoulombFriction(0.05), 0.08, ("0.08", "0.05")),
        # The coefficient of fast slip is that of the pair of surfaces.
        (StribeckFriction(0.12, 0.06, 1e-3), 0.06, None),
        (StribeckFriction(0.12, 0.06, 1e-3), 0.12, ("0.12", "0.06")),
        (ViscousFriction(25.0), 0.05, ("viscous", "0.05")),
    ],
)
def test_a_coefficient_of_spin_that_is_not_that_of_the_threads_is_named(law, spin, told):
    """Which side follows which, where a file gives the two sides different friction."""
    friction = Friction(thread=law, spin=None if spin is None else SpinFriction(spin))
    found = [f for f in prsm.check(mechanism(stage(friction=friction))) if "spin" in f.name]
    if told is None:
        assert not found
        return
    (finding,) = found
    assert (finding.name, finding.severity, finding.stage) == ("spin_coefficient", "note", 1)
    assert finding.value == spin
    for word in (*told, "roller and nut only", "for sliding and for spin"):
        assert word in finding.message
